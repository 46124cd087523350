"""The sky segmentation on made pictures, whose sky is known."""

import cv2
import numpy as np
import pytest

from r3gw.masks.classical import segment_sky

pytestmark = pytest.mark.slow


def made_photo(sky_rgb, wall_rgb, size=(300, 400), seed=0):
    """A gabled house with stones and a tree, under a sky with a soft gradient; and the sky."""
    rng = np.random.default_rng(seed)
    height, width = size
    y, x = np.mgrid[:height, :width] / height
    house = (y > 0.35) & (abs(x - 0.6) < 0.35) | (abs(x - 0.6) < (y - 0.12) * 1.5) & (y < 0.36)
    tree = (x - 1.15) ** 2 + (y - 0.6) ** 2 < 0.02
    ground = y > 0.8
    photo = np.array(sky_rgb) * (0.9 + 0.1 * y[..., None])
    stones = cv2.resize(rng.uniform(0.7, 1.1, (30, 40)), (width, height), interpolation=0)
    photo[house] = (np.array(wall_rgb) * stones[..., None])[house]
    photo[tree] = rng.uniform(0.3, 1, (height, width, 1))[tree] * (30, 60, 20)
    photo[ground] = (np.array((110, 105, 95)) * stones[..., None])[ground]
    photo += rng.normal(0, 2, photo.shape)
    return np.clip(photo, 0, 255).astype(np.uint8), ~(house | tree | ground)


@pytest.mark.parametrize(
    ("sky_rgb", "wall_rgb"),
    [
        ((120, 160, 220), (190, 170, 140)),  # fair day
        ((225, 228, 232), (150, 148, 142)),  # overcast, grey stone
        ((60, 90, 160), (235, 233, 230)),  # white stone, darker than the sky is bright
        ((90, 90, 100), (70, 55, 45)),  # dusk
    ],
)
def test_sky_of_a_made_photo(sky_rgb, wall_rgb):
    photo, truth = made_photo(sky_rgb, wall_rgb)
    found = segment_sky(photo)
    assert found.shape == truth.shape
    assert iou(found, truth) > 0.97


@pytest.mark.parametrize("size", [(150, 200), (900, 1200)])
def test_sky_of_small_and_large_photos(size):
    photo, truth = made_photo((120, 160, 220), (190, 170, 140), size)
    found = segment_sky(photo)
    assert iou(found, truth) > 0.97


@pytest.mark.parametrize("hard", [0, 70])  # pixels from the left whose edge is hard
def test_cloud_on_a_blue_sky_is_sky(hard):
    photo, truth = made_photo((60, 100, 190), (150, 130, 105))
    y, x = np.mgrid[:300, :400]
    cloud = np.exp(-(((x - 60) / 60) ** 4) - ((y - 160) / 50) ** 4)
    cloud = np.where(x < hard, cloud > 0.5, cloud)[..., None] * truth[..., None]
    photo = (photo * (1 - cloud) + 250 * cloud).astype(np.uint8)
    found = segment_sky(photo)
    assert iou(found, truth) > 0.97


def test_sky_of_a_photo_at_night():
    photo, truth = made_photo((120, 160, 220), (190, 170, 140))
    noise = np.random.default_rng(5).normal(0, 1.0, photo.shape)
    night = np.clip(photo * 0.05 + noise, 0, 255).astype(np.uint8)
    assert iou(segment_sky(night), truth) > 0.95


def photo_beside_a_wall(rough, rgb=(205, 110, 70)):
    """The made photo with a wall up to the top edge on its right; and the sky."""
    photo, truth = made_photo((120, 160, 220), (190, 170, 140))
    rng = np.random.default_rng(2)
    bricks = cv2.resize(rng.uniform(1 - rough, 1 + rough, (60, 20)), (80, 300), interpolation=0)
    photo[:240, 320:] = np.clip(np.array(rgb) * bricks[:240, :, None], 0, 255)
    photo[:, 312:320] = 30  # a gutter in shade
    truth[:, 312:] = False
    return photo, truth


def iou(found, truth):
    return (found & truth).sum() / (found | truth).sum()


def test_a_wall_of_brick_at_the_top_edge_is_no_sky():
    photo, truth = photo_beside_a_wall(0.25)
    assert iou(segment_sky(photo), truth) > 0.97


def test_a_smooth_wall_at_the_top_edge_is_no_sky_where_points_lie_on_it():
    photo, truth = photo_beside_a_wall(0.0)
    assert segment_sky(photo)[:240, 330:].mean() > 0.9  # nothing in the photo tells
    on_wall = np.random.default_rng(3).uniform((330, 10), (390, 230), (12, 2))
    on_house = np.random.default_rng(4).uniform((150, 130), (240, 230), (60, 2))
    assert iou(segment_sky(photo, np.concatenate([on_wall, on_house])), truth) > 0.97


def test_one_stray_point_in_the_sky_changes_nothing():
    photo, truth = made_photo((120, 160, 220), (190, 170, 140))
    points = np.random.default_rng(4).uniform((150, 130), (240, 230), (60, 2))
    stray = np.concatenate([points, [(40.0, 30.0), (60.0, 90.0)]])
    assert iou(segment_sky(photo, stray), truth) > 0.97


def test_a_red_evening_behind_a_tower_is_sky():
    photo, truth = photo_beside_a_wall(0.0, rgb=(225, 150, 95))
    truth[:240, 320:] = True
    assert iou(segment_sky(photo), truth) > 0.95


def test_same_photo_gives_the_same_mask():
    photo, _ = made_photo((120, 160, 220), (190, 170, 140))
    assert np.array_equal(segment_sky(photo), segment_sky(photo))


def test_photo_without_anything_smooth_has_no_sky():
    photo = np.random.default_rng(0).integers(0, 255, (120, 160, 3), dtype=np.uint8)
    assert not segment_sky(photo).any()


def test_holes_in_a_tree_are_sky_and_windows_are_not():
    photo, truth = made_photo((120, 160, 220), (190, 170, 140))
    y, x = np.mgrid[:300, :400]
    tree = (x - 60) ** 2 + (y - 180) ** 2 < 45**2
    rng = np.random.default_rng(1)
    photo[tree] = rng.integers(20, 50, (int(tree.sum()), 3))
    holes = np.zeros_like(tree)
    for centre in ((50, 170), (75, 190), (60, 200)):
        holes |= (x - centre[0]) ** 2 + (y - centre[1]) ** 2 < 6**2
    photo[holes] = (112, 150, 205)
    window = (abs(x - 180) < 10) & (abs(y - 225) < 8)  # below the horizon of this picture
    photo[window] = (112, 150, 205)
    truth &= ~tree | holes
    found = segment_sky(photo)
    assert found[holes].mean() > 0.9
    assert not found[tree & ~cv2.dilate(holes.astype(np.uint8), np.ones((5, 5))).astype(bool)].any()
    assert iou(found, truth) > 0.97
