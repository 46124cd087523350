"""r3gw.lighting.envmap against closed forms, SciPy's rotations and the conventions in words."""

from math import pi

import cv2
import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from r3gw.files import InputError
from r3gw.imaging.files import write_exr, write_image
from r3gw.lighting import envmap, sh
from r3gw.lighting.irradiance import irradiance
from r3gw.rendering.cook_torrance import specular

HEIGHT, WIDTH = 64, 128
# A clamped cosine in bands 0 to 4 (Ramamoorthi and Hanrahan 2001, Eq. 8).
CLAMPED_COSINE = (pi, 2 * pi / 3, pi / 4, 0.0, -pi / 24)
PATCHES = [(0.3, -0.8, 0.5), (-0.9, -0.2, 0.1), (0.1, 0.6, -0.8), (0.0, -1.0, 0.0)]


def unit(vector) -> torch.Tensor:
    """Normalised float64 vector."""
    return torch.nn.functional.normalize(torch.tensor(vector, dtype=torch.float64), dim=-1)


def sphere(count: int = 4000) -> torch.Tensor:
    """Nearly even directions (Fibonacci), float32; neighbours are about 3 degrees apart."""
    index = torch.arange(count) + 0.5
    z, turn = 1 - 2 * index / count, pi * (1 + 5**0.5) * index
    s = torch.sqrt(1 - z * z)
    return torch.stack([s * torch.cos(turn), s * torch.sin(turn), z], dim=-1)


def patch_light(direction: torch.Tensor) -> torch.Tensor:
    """SH light of a black map with one small bright patch."""
    directions = envmap.pixel_directions(HEIGHT, WIDTH)
    bright = (directions @ direction > 0.995).float()[..., None] * 100.0
    return envmap.project(bright.expand(-1, -1, 3), directions, 4)


def test_centre_looks_along_z_right_half_towards_x_top_is_up():
    directions = envmap.pixel_directions(HEIGHT, WIDTH)
    middle = directions[HEIGHT // 2 - 1 : HEIGHT // 2 + 1, WIDTH // 2 - 1 : WIDTH // 2 + 1]
    torch.testing.assert_close(middle.mean(dim=(0, 1)), unit([0.0, 0.0, 1.0]), rtol=0, atol=2e-3)
    assert (directions[:, WIDTH // 2 :, 0] > 0).all()
    assert (directions[: HEIGHT // 2, :, 1] < 0).all()
    torch.testing.assert_close(
        directions.norm(dim=-1), torch.ones(HEIGHT, WIDTH).double(), rtol=0, atol=1e-12
    )


def test_constant_map_is_a_constant():
    colour = torch.tensor([0.2, 0.5, 1.5])
    light = envmap.project(
        colour.expand(HEIGHT, WIDTH, 3), envmap.pixel_directions(HEIGHT, WIDTH), 4
    )
    torch.testing.assert_close(light[0], colour * (4 * pi) ** 0.5, rtol=1e-6, atol=0)
    torch.testing.assert_close(light[1:], torch.zeros(24, 3), rtol=0, atol=2e-3)


@pytest.mark.parametrize("patch", PATCHES)
def test_clamped_cosine_map(patch):
    axis = unit(patch)
    directions = envmap.pixel_directions(HEIGHT, WIDTH)
    lobe = (directions @ axis).clamp_min(0).float()[..., None].expand(-1, -1, 3)
    factors = torch.tensor([CLAMPED_COSINE[int(i**0.5)] for i in range(25)], dtype=torch.float64)
    expected = (factors * sh.basis(axis, 4)).float()
    got = envmap.project(lobe, directions, 4)
    torch.testing.assert_close(got, expected[:, None].expand(-1, 3), rtol=0, atol=2e-3)


def test_projection_inverts_drawing():
    coefficients = torch.randn(25, 3, generator=torch.Generator().manual_seed(0))
    drawn = envmap.draw(coefficients, HEIGHT)
    back = envmap.project(drawn, envmap.pixel_directions(HEIGHT, WIDTH), 4)
    torch.testing.assert_close(back, coefficients, rtol=0, atol=5e-3)


@pytest.mark.parametrize("patch", PATCHES)
def test_diffuse_and_specular_light_come_from_the_same_side(patch):
    source = unit(patch)
    light, candidates = patch_light(source), sphere()
    brightest = candidates[irradiance(light, candidates)[:, 0].argmax()].double()
    assert brightest @ source > np.cos(np.radians(4))

    # The view is 40 degrees from the normal throughout, so that only the reflection varies.
    reflected, angle = candidates, np.radians(40)
    tangent = torch.linalg.cross(reflected, torch.tensor([0.3, 0.5, -0.8]).expand_as(reflected))
    tangent = torch.nn.functional.normalize(tangent, dim=-1)
    normals = reflected * np.cos(angle) + tangent * np.sin(angle)
    to_camera = 2 * np.cos(angle) * normals - reflected
    radiance = specular(normals, to_camera, torch.full((len(normals),), 0.1), light)
    assert reflected[radiance[:, 0].argmax()].double() @ source > np.cos(np.radians(4))


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.1])
def test_published_mapping_at_minus_a_quarter_turn(angle):
    # d = (-sin t cos(p + a), -cos t, -sin t sin(p + a)), as the published protocol has it.
    theta = pi * (np.arange(8) + 0.5) / 8
    phi = 2 * pi * (np.arange(16) + 0.5) / 16 + angle
    t, p = np.meshgrid(theta, phi, indexing="ij")
    expected = np.stack([-np.sin(t) * np.cos(p), -np.cos(t), -np.sin(t) * np.sin(p)], -1)
    got = envmap.published_directions(8, 16, -pi / 2, angle)
    np.testing.assert_allclose(got.numpy(), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("x_deg", "angle"), [(-95.0, 0.4), (-95.0, -1.3), (-60.0, 2.0)])
def test_published_mapping_at_any_tilt(x_deg, angle):
    theta = pi * (np.arange(8) + 0.5) / 8
    phi = 2 * pi * (np.arange(16) + 0.5) / 16
    t, p = np.meshgrid(theta, phi, indexing="ij")
    own = np.stack([-np.sin(t) * np.cos(p), -np.sin(t) * np.sin(p), np.cos(t)], -1)
    turn = Rotation.from_euler("y", -angle) * Rotation.from_euler("x", -x_deg, degrees=True)
    expected = turn.apply(own.reshape(-1, 3)).reshape(own.shape)
    got = envmap.published_directions(8, 16, np.radians(x_deg), angle)
    np.testing.assert_allclose(got.numpy(), expected, rtol=0, atol=1e-12)


def test_published_mapping_is_a_mirrored_panorama():
    # From left to right the azimuth (+z to +x) rises in ours and falls in the published map.
    ours = envmap.pixel_directions(8, 16)[4]
    theirs = envmap.published_directions(8, 16, -pi / 2, 0.0)[4]
    for row, sign in ((ours, 1.0), (theirs, -1.0)):
        azimuth = torch.atan2(row[:, 0], row[:, 2]).numpy()
        assert (np.sign(np.diff(np.unwrap(azimuth))) == sign).all()


def test_reads_linear_and_8_bit_maps(tmp_path):
    linear = np.random.default_rng(0).random((4, 8, 3), dtype=np.float32) * 20
    write_exr(tmp_path / "map.exr", linear)
    np.testing.assert_array_equal(envmap.read_env_map(tmp_path / "map.exr").numpy(), linear)
    cv2.imwrite(str(tmp_path / "map.hdr"), np.ascontiguousarray(linear[..., ::-1]))
    np.testing.assert_allclose(
        envmap.read_env_map(tmp_path / "map.hdr").numpy(), linear, rtol=0.02, atol=0.1
    )
    bytes_ = np.arange(96, dtype=np.uint8).reshape(4, 8, 3)
    write_image(tmp_path / "map.png", bytes_)
    np.testing.assert_allclose(
        envmap.read_env_map(tmp_path / "map.png").numpy(), bytes_ / 255.0, rtol=0, atol=1e-7
    )


def test_map_errors_name_file_and_remedy(tmp_path):
    write_image(tmp_path / "square.png", np.zeros((8, 8, 3), np.uint8))
    with pytest.raises(InputError, match=r"square\.png.*twice as wide.*8x8"):
        envmap.read_env_map(tmp_path / "square.png")
    with pytest.raises(InputError, match=r"missing\.exr: no such environment map"):
        envmap.read_env_map(tmp_path / "missing.exr")
    with pytest.raises(InputError, match=r"map\.txt: environment maps are \.exr"):
        envmap.read_env_map(tmp_path / "map.txt")
