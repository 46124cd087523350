"""A trained scene reduced to what pictures and viewers need, in memory and as PLY and JSON."""
