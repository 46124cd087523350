"""Undistortion of photos and masks: pictures of a known pattern, distorted by OpenCV."""

import cv2
import numpy as np
import pytest

from r3gw.imaging.files import read_grey, read_rgb
from r3gw.importing.gauge import scene_from_source
from r3gw.importing.lens import Lens
from r3gw.importing.posed import camera_of
from r3gw.importing.source import SourceMask, SourcePoints, SourceScene, SourceView
from r3gw.importing.write import write_scene

SIZE = (200, 150)
PINHOLE = [160.0, 165.0, 98.0, 77.0]
LENSES = {
    "OPENCV": [-0.15, 0.03, 0.002, -0.001],
    "OPENCV_FISHEYE": [0.05, -0.01, 0.002, 0.0],
    "SIMPLE_RADIAL": [0.12],
}


def pattern(x, y):
    """Grey value of a direction (x / z, y / z); smooth, so that warping twice costs little."""
    return 127 + 60 * np.sin(30 * x) + 60 * np.cos(25 * y + 2 * x)


def directions(model, extra):
    """Directions of a distorted photo's pixel centres, by OpenCV."""
    pixels = np.mgrid[: SIZE[1], : SIZE[0]][::-1].reshape(2, -1).T.astype(np.float64)
    fx, fy, cx, cy = PINHOLE if len(extra) == 4 else [PINHOLE[0], *[PINHOLE[0]], *PINHOLE[2:]]
    # OpenCV counts pixel centres from 0, COLMAP from 0.5.
    matrix = np.array([[fx, 0, cx - 0.5], [0, fy, cy - 0.5], [0, 0, 1]])
    if model == "OPENCV_FISHEYE":
        found = cv2.fisheye.undistortPoints(pixels[:, None], matrix, np.array(extra))
    else:
        coefficients = np.array([*extra, 0, 0, 0, 0][:4])
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)
        found = cv2.undistortPoints(pixels[:, None], matrix, coefficients, criteria=criteria)
    return found.reshape(SIZE[1], SIZE[0], 2).transpose(2, 0, 1)


@pytest.fixture(params=LENSES)
def written(request, tmp_path):
    """A distorted photo with two masks, imported."""
    extra = LENSES[request.param]
    x, y = directions(request.param, extra)
    photo = np.repeat(pattern(x, y)[..., None], 3, axis=2).round().astype(np.uint8)
    cv2.imwrite(str(tmp_path / "a.png"), photo)
    cv2.imwrite(str(tmp_path / "valid.png"), ((x > 0.1) * 255).astype(np.uint8))
    cv2.imwrite(str(tmp_path / "not_sky.png"), ((y > -0.2) * 255).astype(np.uint8))
    parameters = [*PINHOLE, *extra] if len(extra) == 4 else [PINHOLE[0], *PINHOLE[2:], *extra]
    lens = Lens(request.param, *SIZE, tuple(parameters))
    assert not lens.is_pinhole
    camera = camera_of(np.eye(4), lens, "a")
    masks = {
        "is_valid": SourceMask(tmp_path / "valid.png"),
        "is_sky": SourceMask(tmp_path / "not_sky.png", white_means=False),
    }
    view = SourceView("a", tmp_path / "a.png", camera, "train", masks=masks, lens=lens)
    points = SourcePoints(np.eye(3), np.zeros((3, 3), np.uint8))
    scene = write_scene(
        SourceScene((view,), points),
        scene_from_source(points, None, None),
        tmp_path / "scene",
        name="a",
        source_format="colmap",
        max_image_px=1600,
    )
    return scene.views[0], tmp_path / "scene"


def test_pattern_and_masks_are_where_the_pinhole_camera_sees_them(written):
    view, folder = written
    fx, fy, cx, cy = view.intrinsics
    down, right = np.mgrid[: view.height, : view.width] + 0.5
    x, y = (right - cx) / fx, (down - cy) / fy
    photo = read_rgb(folder / view.image)[..., 0].astype(float)
    assert view.width > 0.7 * SIZE[0]
    error = np.abs(photo - pattern(x, y))[2:-2, 2:-2]
    assert error.max() < 2  # grey values; half a pixel off would give 5
    for kind, expected in (("is_valid", x > 0.1), ("is_sky", y <= -0.2)):
        mask = read_grey(folder / "given" / kind / "a.png") >= 128
        distance = np.abs(x - 0.1) * fx if kind == "is_valid" else np.abs(y + 0.2) * fy
        assert np.array_equal(mask[distance > 1], expected[distance > 1])  # px from the edge
