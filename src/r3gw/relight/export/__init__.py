"""Trained scenes for other programs: PLY, glTF and lights."""
