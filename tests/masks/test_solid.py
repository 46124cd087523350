"""Where the scene's points lie in a photo, by hand."""

import numpy as np
from support.made_up_runs import view

from r3gw.masks.solid import FARTHEST, solid_positions

PHOTO = view("a", "train")  # 16 x 12 px, focal length 10 px, centre (8, 6), at the origin


def positions(*points):
    return solid_positions(PHOTO, np.array(points, np.float32))


def test_points_before_the_camera_by_hand():
    found = positions((0.1, -0.2, 1.0), (0.2, 0.4, -1.0), (3.0, 0.0, 1.0), (1.0, 1.0, 2.0))
    np.testing.assert_allclose(found, [(9.0, 4.0), (13.0, 11.0)], rtol=0, atol=1e-5)


def test_what_is_very_far_away_does_not_count():
    near = [(0.0, 0.0, 1.0)] * 5
    assert len(positions(*near, (0.0, 0.0, 0.99 * FARTHEST))) == 6
    assert len(positions(*near, (0.0, 0.0, 1.01 * FARTHEST))) == 5


def test_no_point_in_sight():
    assert positions((0.0, 0.0, -1.0)).shape == (0, 2)
    assert solid_positions(PHOTO, np.zeros((0, 3), np.float32)).shape == (0, 2)
