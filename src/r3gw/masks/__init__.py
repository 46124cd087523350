"""Masks of every photo: which pixels are valid (no occluder) and which show sky."""
