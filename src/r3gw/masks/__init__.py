"""Masks of every photo: which pixels are valid (no occluder) and which show sky."""

from r3gw.masks.classical import segment_sky
from r3gw.masks.files import load_masks, make_masks

__all__ = ["load_masks", "make_masks", "segment_sky"]
