"""From the model to pictures: shading, splats, one rendering pass."""
