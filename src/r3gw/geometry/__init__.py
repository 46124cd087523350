"""Geometry: rotations, cameras, the sky's spherical coordinates, similarity transforms."""
