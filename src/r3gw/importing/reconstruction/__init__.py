"""Cameras and points from photos: structure from motion and triangulation by pycolmap."""
