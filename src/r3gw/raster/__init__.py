"""Rasterizing 3D Gaussians: `rasterize` (C++), and `reference` (plain torch, same semantics).

This package owns projection, sorting and compositing and their gradients; what the feature
channels mean is the caller's business.
"""

from r3gw.raster.api import rasterize
from r3gw.raster.result import RasterResult

__all__ = ["RasterResult", "rasterize"]
