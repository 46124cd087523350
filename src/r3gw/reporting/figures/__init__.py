"""Figures of scenes and studies."""
