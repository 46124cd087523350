"""Images: display gamma, files on disk, masks."""
