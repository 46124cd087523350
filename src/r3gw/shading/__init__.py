"""Reflection of the foreground: the split-sum table and Cook-Torrance shading under SH light."""
