"""The writer's size rule: width counts, as in the published runs."""

import cv2
import numpy as np
import pytest
import torch

from r3gw.geometry.cameras import Camera
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.files import read_rgb
from r3gw.importing.source import SourcePoints, SourceScene, SourceView
from r3gw.importing.write import write_scene


@pytest.mark.parametrize(
    ("size", "expected"), [((90, 40), (60, 27)), ((40, 90), (40, 90)), ((80, 160), (60, 120))]
)
def test_photos_wider_than_allowed_shrink_to_the_width(tmp_path, size, expected):
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((size[1], size[0], 3), np.uint8))
    pose = torch.eye(4, dtype=torch.float64)
    camera = Camera(pose, (50.0, 50.0, size[0] / 2, size[1] / 2), *size)
    points = SourcePoints(np.zeros((1, 3)), np.zeros((1, 3), np.uint8))
    view = write_scene(
        SourceScene((SourceView("a.png", tmp_path / "a.png", camera, "train"),), points),
        Similarity.identity(),
        tmp_path / "scene",
        name="a",
        source_format="colmap",
        max_image_px=60,
    ).views[0]
    assert (view.width, view.height) == expected
    assert read_rgb(tmp_path / "scene" / view.image).shape == (*expected[::-1], 3)
    shrink = expected[0] / size[0]
    np.testing.assert_allclose(view.intrinsics[0], 50 * shrink, rtol=1e-12, atol=0)
    assert view.source_size_px == (None if shrink == 1 else size)
