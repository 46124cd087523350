"""One reader per format of posed photos: COLMAP, nerfstudio, NeRF-OSR in two layouts."""
