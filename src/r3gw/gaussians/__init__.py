"""The scene model: foreground Gaussians, sky Gaussians, per-photo appearance, rendering."""
