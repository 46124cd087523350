"""How each light model is started and trained: its first light, its learning rates, its losses."""
