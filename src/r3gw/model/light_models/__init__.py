"""Light models: how the light of a training photo follows from what is learned of it."""
