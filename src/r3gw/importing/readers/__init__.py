"""One reader per format: COLMAP, nerfstudio, NeRF-OSR in two layouts, anybody's photos."""
