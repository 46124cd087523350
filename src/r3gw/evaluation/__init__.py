"""How good a trained scene is: protocols, metrics, decomposition."""
