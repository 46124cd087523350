"""Rotations against SciPy, cameras against pycolmap, similarity and angles against closed forms."""

from math import pi

import numpy as np
import pycolmap
import pytest
import torch
from scipy.spatial.transform import Rotation

from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.geometry.rotations import rotation_about_axis, rotation_from_quaternion
from r3gw.geometry.similarity import Similarity
from r3gw.geometry.spherical import angles_from_direction, direction_from_angles


def test_quaternions_match_scipy():
    quaternions = np.random.default_rng(0).normal(size=(20, 4))
    expected = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    found = rotation_from_quaternion(torch.from_numpy(quaternions))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_axis_rotations_match_scipy(axis):
    expected = Rotation.from_euler("xyz"[axis], 0.7).as_matrix()
    np.testing.assert_allclose(rotation_about_axis(axis, 0.7), expected, rtol=0, atol=1e-15)


def camera():
    matrix = torch.eye(4, dtype=torch.float64)
    matrix[:3, :3] = torch.from_numpy(Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix())
    matrix[:3, 3] = torch.tensor([0.1, -2.0, 3.0])
    return Camera(matrix, (50.0, 60.0, 15.0, 11.0), 32, 24)


def test_pixel_rays_match_pycolmap():
    model = pycolmap.Camera(model="PINHOLE", width=32, height=24, params=[50, 60, 15, 11])
    y, x = np.mgrid[:24, :32] + 0.5
    expected = model.cam_from_img(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(24, 32, 2)
    rays = pixel_rays(camera())
    np.testing.assert_allclose(rays[..., :2], expected, rtol=0, atol=1e-6)
    assert (rays[..., 2] == 1).all()


def test_scaled_camera_sees_the_same_rays_at_the_frame_corners():
    half = camera().scaled(16, 12)
    full, small = pixel_rays(camera()), pixel_rays(half)
    pooled = full[::2, ::2] / 2 + full[1::2, 1::2] / 2  # rays are linear in the pixel
    np.testing.assert_allclose(small, pooled, rtol=0, atol=1e-6)


def test_centre_is_where_the_camera_sees_zero():
    matrix = camera().cam_from_world
    seen = matrix[:3, :3] @ camera().centre + matrix[:3, 3]
    np.testing.assert_allclose(seen, np.zeros(3), rtol=0, atol=1e-12)


def test_similarity_keeps_projections_and_inverts():
    rotation = torch.from_numpy(Rotation.from_rotvec([1.0, 2.0, -0.5]).as_matrix())
    similarity = Similarity(3.5, rotation, torch.tensor([1.0, -2.0, 0.3], dtype=torch.float64))
    points = torch.from_numpy(np.random.default_rng(1).normal(size=(30, 3)))
    before = points @ camera().cam_from_world[:3, :3].T + camera().cam_from_world[:3, 3]
    cam_from_target = similarity.camera(camera().cam_from_world)
    after = similarity.points(points) @ cam_from_target[:3, :3].T + cam_from_target[:3, 3]
    np.testing.assert_allclose(after, 3.5 * before, rtol=0, atol=1e-11)
    back = similarity.inverse().points(similarity.points(points))
    np.testing.assert_allclose(back, points, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("theta", "phi", "direction"),
    [
        (0.0, 0.0, (0, -1, 0)),
        (pi / 2, 0.0, (0, 0, 1)),
        (pi / 2, pi / 2, (1, 0, 0)),
        (pi, 0.0, (0, 1, 0)),
    ],
)
def test_named_directions(theta, phi, direction):
    found = direction_from_angles(torch.tensor(theta), torch.tensor(phi))
    np.testing.assert_allclose(found, direction, rtol=0, atol=1e-6)


def test_angles_invert_directions_of_any_length():
    rng = np.random.default_rng(2)
    theta, phi = torch.from_numpy(rng.uniform([0.01, -3.1], [3.1, 3.1], (50, 2))).unbind(-1)
    found = angles_from_direction(7.0 * direction_from_angles(theta, phi))
    np.testing.assert_allclose(torch.stack(found), torch.stack([theta, phi]), rtol=0, atol=1e-12)
