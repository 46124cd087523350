"""What a model file may ask for at most; apart, since settings are read where PyTorch is not."""

LARGEST_LAYER = 4096  # A file from a stranger must not ask for more memory than this.
