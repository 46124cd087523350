"""Files of a relightable scene: PLY and lights.json."""
