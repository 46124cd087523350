"""Showing a trained scene: any camera, any light, as pictures or as a film."""
