"""r3gw.lighting.maps: linear in the map, turned the right way, display values made linear."""

from math import pi

import numpy as np
import torch

from r3gw.geometry.rotations import rotation_about_axis
from r3gw.imaging.files import write_exr, write_image
from r3gw.lighting import sh
from r3gw.lighting.light import Light
from r3gw.lighting.sh_rotation import rotate


def test_light_of_a_map_is_linear_and_turns_to_the_right(tmp_path):
    env_map = np.random.default_rng(0).random((16, 32, 3), dtype=np.float32)
    write_exr(tmp_path / "map.exr", env_map)
    write_exr(tmp_path / "rolled.exr", np.roll(env_map, 4, axis=1) * np.float32(2.5))
    turn = rotation_about_axis(1, 2 * pi * 4 / 32)
    first, rolled = (Light.from_map(tmp_path / f"{name}.exr").sh for name in ("map", "rolled"))
    torch.testing.assert_close(2.5 * rotate(first, turn), rolled, rtol=1e-5, atol=1e-5)


def test_display_maps_are_made_linear(tmp_path):
    write_image(tmp_path / "grey.png", np.full((32, 64, 3), 128, np.uint8))
    light = Light.from_map(tmp_path / "grey.png", degree=2).sh
    expected = torch.full((3,), (128 / 255) ** 2.2)
    seen = sh.radiance(light, torch.tensor([0.0, 0.0, 1.0]))
    torch.testing.assert_close(seen, expected, rtol=0.01, atol=0)
