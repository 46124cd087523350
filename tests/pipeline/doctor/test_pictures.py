"""The arrows of up against a finite projection of a point that is moved up."""

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from r3gw.geometry.cameras import Camera
from r3gw.pipeline.doctor.pictures import image_of_up


@pytest.mark.parametrize("angles_deg", [(0, 0, 0), (20, 30, 5), (-35, 120, 40)])
@pytest.mark.parametrize("pixel", [(50.0, 40.0), (200.0, 160.0)])
def test_arrow_follows_the_projection(angles_deg, pixel):
    cam_from_world = np.eye(4)
    cam_from_world[:3, :3] = Rotation.from_euler("xyz", angles_deg, degrees=True).as_matrix()
    cam_from_world[:3, 3] = (0.3, -0.2, 1.0)
    fx, fy, cx, cy = 210.0, 190.0, 118.0, 91.0
    camera = Camera(torch.from_numpy(cam_from_world), (fx, fy, cx, cy), 240, 180)

    def projected(world):
        x, y, z = cam_from_world[:3, :3] @ world + cam_from_world[:3, 3]
        return np.array([fx * x / z + cx, fy * y / z + cy])

    ray = np.array([(pixel[0] - cx) / fx, (pixel[1] - cy) / fy, 1.0]) * 7.0
    world = cam_from_world[:3, :3].T @ (ray - cam_from_world[:3, 3])
    assert projected(world) == pytest.approx(np.array(pixel), rel=0, abs=1e-9)
    moved = projected(world + 1e-5 * np.array([0.0, -1.0, 0.0])) - projected(world)
    expected = moved / np.linalg.norm(moved)
    np.testing.assert_allclose(image_of_up(camera, *pixel), expected, rtol=0, atol=1e-5)
