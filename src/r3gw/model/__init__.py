"""What a trained scene is: Gaussians of foreground and sky, light per photo, its file."""
