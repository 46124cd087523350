"""Depth from photos whose cameras are known, and the many points that follow from it."""
