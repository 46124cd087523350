"""A made place of textured planes, and photos of it cast ray by ray."""

import cv2
import numpy as np

SIZE = (400, 300)
FOCAL_PX = 380.0
# Point, two axes, extent along both: two walls that meet at z = 6, and the ground; up is -y.
PLANES = (
    ((0, 1, 6), (-0.8, 0, -0.6), (0, -1, 0), (6, 4)),
    ((0, 1, 6), (0.6, 0, -0.8), (0, -1, 0), (6, 4)),
    ((-5, 1, 0), (1, 0, 0), (0, 0, 1), (10, 8)),
)


def texture(seed):
    rng = np.random.default_rng(seed)
    image = sum(
        cv2.resize(rng.normal(size=(n, n)).astype(np.float32), (800, 800), interpolation=3) * w
        for n, w in ((12, 25), (50, 30), (160, 30))
    )
    return np.clip(image + 120, 0, 255).astype(np.uint8)


TEXTURES = [texture(seed) for seed in range(3)]


def place_photo(cam_from_world, centre):
    """Ray cast the planes: an oracle that shares no code with the importer."""
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    rays = np.stack([x - SIZE[0] / 2, y - SIZE[1] / 2, np.full_like(x, FOCAL_PX)], -1)
    rays = rays @ cam_from_world
    image = np.full((SIZE[1], SIZE[0]), 200, np.uint8)
    nearest = np.full(image.shape, np.inf)
    for (point, first, second, extent), pixels in zip(PLANES, TEXTURES, strict=True):
        first, second = np.array(first, float), np.array(second, float)
        normal = np.cross(first, second)
        distance = ((np.array(point) - centre) @ normal) / (rays @ normal)
        offset = centre + distance[..., None] * rays - np.array(point)
        u, v = offset @ first / extent[0], offset @ second / extent[1]
        hit = (distance > 0) & (distance < nearest) & (abs(u - 0.5) < 0.5) & (abs(v - 0.5) < 0.5)
        nearest[hit] = distance[hit]
        maps = [(value * 799).astype(np.float32) for value in (u, v)]
        image[hit] = cv2.remap(pixels, *maps, cv2.INTER_LINEAR)[hit]
    return image
