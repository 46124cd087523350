"""r3gw: relightable 3D Gaussians for outdoor scenes in the wild."""

__version__ = "0.1.0"
