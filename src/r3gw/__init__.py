"""r3gw: relightable 3D Gaussians for outdoor scenes in the wild."""

import os

# Waiting OpenMP threads sleep instead of spinning. With as many threads as cores, and two thread
# pools (torch's autograd has its own), spinning costs milliseconds per parallel loop as soon as
# anything else runs. Read once, when torch loads its OpenMP runtime; the user's own value wins.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

__version__ = "0.1.0"
