"""What rounding into textures costs, and which Gaussians a page keeps."""

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from r3gw.geometry.rotations import rotation_from_quaternion, shortest_axes
from r3gw.view.buffers import TEXTURE_WIDTH, buffers_of, most_important, shortest_last


def covariances(rotations, log_scales):
    """Covariances of Gaussians, float64."""
    axes = rotations * np.exp(log_scales)[:, None, :]
    return axes @ axes.transpose(0, 2, 1)


def test_axes_in_another_order_are_the_same_ellipsoid_with_the_normal_last(gaussians):
    turned, scales = shortest_last(gaussians.quaternions, gaussians.log_scales)
    before = covariances(
        rotation_from_quaternion(gaussians.quaternions.double()).numpy(),
        gaussians.log_scales.double().numpy(),
    )
    after = Rotation.from_quat(turned).as_matrix()
    np.testing.assert_allclose(covariances(after, scales), before, rtol=0, atol=1e-5)
    count = gaussians.num_foreground
    normals = shortest_axes(gaussians.quaternions[:count], gaussians.log_scales[:count])
    cosines = np.abs((after[:count, :, 2] * normals.numpy()).sum(-1))
    np.testing.assert_allclose(cosines, 1.0, rtol=0, atol=1e-5)
    assert (np.argmin(scales, axis=1) == 2).all()


def test_textures_hold_the_scene_to_their_rounding(gaussians):
    made = buffers_of(gaussians)
    count, foreground = len(gaussians.means), gaussians.num_foreground
    texels = made.place.reshape(-1, 4)
    np.testing.assert_array_equal(texels[:count, :3], gaussians.means.numpy())
    np.testing.assert_allclose(texels[:count, 3], gaussians.opacities.numpy(), rtol=1e-6)
    assert not texels[count:].any()
    assert made.place.shape[1] == TEXTURE_WIDTH
    words = made.shape.reshape(-1, 4)[:count]
    xyzw = words[:, :2].copy().view("<i2") / 32767
    logs = words[:, 2:].copy().view("<f2")[:, :3].astype(np.float64)
    quaternions, scales = shortest_last(gaussians.quaternions, gaussians.log_scales)
    np.testing.assert_allclose(xyzw, quaternions, rtol=0, atol=2e-5)
    np.testing.assert_allclose(logs, scales, rtol=1e-3, atol=1e-3)
    surface = made.surface.reshape(-1, 4)[:foreground] / 255
    np.testing.assert_allclose(surface[:, :3] ** 2.2, gaussians.albedo, rtol=0, atol=0.005)
    np.testing.assert_allclose(surface[:, 3], gaussians.roughness, rtol=0, atol=0.002)


def test_transfer_comes_back_within_half_a_step(gaussians):
    made = buffers_of(gaussians)
    levels = np.concatenate(list(made.transfer.reshape(7, -1, 4)), axis=1)
    values = (levels[: gaussians.num_foreground].astype(float) - 128) / 127 * made.transfer_scale
    expected = gaussians.occlusion.numpy()
    step = made.transfer_scale[:25] / 127
    assert (np.abs(values[:, :25] - expected) <= 0.5 * step + 1e-7).all()
    assert not values[:, 25:].any()


def test_thinning_keeps_the_sky_and_what_covers_most(gaussians):
    kept = most_important(gaussians, gaussians.num_sky + 10)
    assert (kept.num_sky, kept.num_foreground) == (gaussians.num_sky, 10)
    torch.testing.assert_close(kept.means[10:], gaussians.means[gaussians.num_foreground :])
    count = gaussians.num_foreground
    area = gaussians.scales[:count].sort(dim=-1).values[:, 1:].prod(-1)
    cover = gaussians.opacities[:count] * area
    least_kept = cover.sort(descending=True).values[9]
    expected = torch.nonzero(cover >= least_kept)[:, 0]
    torch.testing.assert_close(kept.albedo, gaussians.albedo[expected])
    torch.testing.assert_close(kept.occlusion, gaussians.occlusion[expected])


@pytest.mark.parametrize("most", [0, 5])
def test_a_limit_below_the_sky_leaves_the_sky_alone(gaussians, most):
    kept = most_important(gaussians, most)
    assert (kept.num_foreground, kept.num_sky) == (0, gaussians.num_sky)


def test_a_small_scene_is_kept_whole(gaussians):
    assert most_important(gaussians, len(gaussians.means)) is gaussians
