"""r3gw.evaluation.protocols on photos whose light is known, because a model made them."""

import cv2
import numpy as np
import pytest
import torch

from r3gw.evaluation.protocols.exact import Exact, diffuse_oracle
from r3gw.evaluation.protocols.learned import Learned
from r3gw.evaluation.protocols.published import published_light
from r3gw.evaluation.protocols.registry import PROTOCOLS
from r3gw.evaluation.protocols.swept import FullYaw, NerfOsr, NerfOsrLinear
from r3gw.files import InputError
from r3gw.imaging.files import write_exr, write_image
from r3gw.imaging.masks import erode
from r3gw.imaging.pictures import bytes_from_display
from r3gw.lighting import envmap
from r3gw.lighting.light import Light

BEST_INDEX, SWEEP_RAD = 17, (-1.0, 1.5)


def test_sweep_finds_the_angle_that_lit_the_photo(tiny):
    outcome = NerfOsr().evaluate(tiny.evaluated, tiny.view("c_swept"))
    figures = outcome.figures
    assert int(np.argmax(figures["sweep_psnr"])) == BEST_INDEX
    assert figures["angle_rad"] == pytest.approx(-1.0 + 2.5 * BEST_INDEX / 50, rel=1e-12, abs=0)
    assert figures["psnr"] > 50  # only 8-bit rounding is left
    assert len(figures["sweep_psnr"]) == len(figures["sweep_angles_rad"]) == 51
    assert figures["sweep_psnr"][BEST_INDEX] == pytest.approx(figures["psnr"], rel=1e-9, abs=0)
    assert min(figures["sweep_psnr"]) < 35  # the sun matters


def test_the_whole_circle_holds_the_best_angle_to_its_step(tiny):
    figures = FullYaw().evaluate(tiny.evaluated, tiny.view("c_swept")).figures
    angles = np.array(figures["sweep_angles_rad"])
    np.testing.assert_allclose(np.diff(angles), 2 * np.pi / 48, rtol=1e-9, atol=0)
    assert angles[0] == -np.pi
    true = -1.0 + 2.5 * BEST_INDEX / 50
    assert abs(figures["angle_rad"] - true) <= np.pi / 48
    assert figures["psnr"] == max(figures["sweep_psnr"])
    assert (
        figures["psnr"] < NerfOsr().evaluate(tiny.evaluated, tiny.view("c_swept")).figures["psnr"]
    )


@pytest.mark.parametrize("exposure", [0.25, 0.6])
def test_the_linear_protocol_finds_angle_and_exposure(tiny, exposure):
    """A photo lit by the map's display values to the power 2.2, its sun 20 times as bright."""
    view = tiny.view("c_swept")
    values = cv2.imread(str(tiny.folder / view.evaluation.env_map))[..., ::-1] / 255.0
    linear = torch.from_numpy(np.where(values > 0.95, 20.0, 1.0) * values**2.2)
    angle_rad = -1.0 + 2.5 * BEST_INDEX / 50
    directions = envmap.published_directions(16, 32, -1.6, angle_rad)
    light = exposure * envmap.project(linear, directions, 4)
    picture = tiny.evaluated.render(view, Light(light))
    write_image(tiny.folder / "images" / "linear.png", bytes_from_display(picture))
    photo = view.model_copy(update={"image": "images/linear.png"})
    figures = NerfOsrLinear().evaluate(tiny.evaluated, photo).figures
    assert int(np.argmax(figures["sweep_psnr"])) == BEST_INDEX
    assert figures["angle_rad"] == pytest.approx(angle_rad, rel=1e-12, abs=0)
    assert figures["exposure"] == pytest.approx(exposure, rel=0.01, abs=0)
    assert figures["psnr"] > 48  # only 8-bit rounding is left
    assert min(figures["sweep_psnr"]) < 35


def test_oracles_say_so():
    oracles = {p.facts.name for p in PROTOCOLS if p.facts.is_oracle}
    assert oracles == {"nerf-osr", "full-yaw", "nerf-osr-linear", "half-image"}


def test_exact_light_is_in_the_photos_own_units(tiny):
    outcome = Exact().evaluate(tiny.evaluated, tiny.view("b_exact"))
    assert outcome.figures["psnr"] > 50
    assert outcome.figures["ssim"] > 0.99
    assert outcome.figures["mae"] < 1 / 255


def test_learned_light_and_sky(tiny):
    outcome = Learned().evaluate(tiny.evaluated, tiny.view("a_1"))
    assert outcome.figures["psnr"] > 50
    assert outcome.figures["psnr_foreground"] > 50


def test_figures_are_means_over_the_eroded_mask_alone(tiny):
    view = tiny.view("b_exact")
    outcome = Exact().evaluate(tiny.evaluated, view)
    photo = cv2.imread(str(tiny.folder / view.image))[..., ::-1] / 255.0
    mask = cv2.imread(str(tiny.folder / view.evaluation.mask), cv2.IMREAD_GRAYSCALE) > 127
    mask = erode(mask, 5)
    assert not mask[15].any()
    assert mask[16].all()
    expected = ((outcome.picture - photo)[mask] ** 2).mean()
    assert outcome.figures["mse"] == pytest.approx(expected, rel=1e-9, abs=0)


def test_which_views_are_covered(tiny):
    covered = {
        protocol.facts.name: [
            v.name for v in tiny.evaluated.scene.views if protocol.facts.covers(v)
        ]
        for protocol in PROTOCOLS
    }
    assert covered == {
        "nerf-osr": ["b_exact", "c_swept"],
        "full-yaw": ["b_exact", "c_swept"],
        "nerf-osr-linear": ["b_exact", "c_swept"],
        "exact": ["b_exact"],
        "half-image": ["b_exact", "c_swept"],
        "learned": ["a_0", "a_1"],
    }


def test_oracle_under_uniform_light(tiny, uniform_oracle):
    light = torch.zeros(25, 3)
    light[0] = 0.6 * (4 * np.pi) ** 0.5
    picture = diffuse_oracle(tiny.evaluated, tiny.view("b_exact").truth, light)
    np.testing.assert_allclose(picture[14:], uniform_oracle, rtol=1e-5, atol=0)
    np.testing.assert_array_equal(picture[:14], 1.0)  # white sky


@pytest.mark.parametrize(
    ("is_linear", "radiance"), [(False, 3 * 247 / 255), (True, 3 * (247 / 255) ** 2.2)]
)
def test_clipped_is_a_display_value_in_both_protocols(tiny, is_linear, radiance):
    """247 / 255 is above the threshold of 0.95, though its linear value is not."""
    write_image(tiny.folder / "envmaps" / "bright.png", np.full((8, 16, 3), 247, np.uint8))
    view = tiny.view("c_swept")
    entry = view.evaluation.model_copy(update={"env_map": "envmaps/bright.png", "scale": 3.0})
    light = published_light(tiny.evaluated, view, entry, is_linear=is_linear)
    expected = torch.full((3,), radiance * (4 * np.pi) ** 0.5)
    torch.testing.assert_close(light.sh[0], expected, rtol=1e-5, atol=0)


def test_a_linear_file_is_linear_already(tiny):
    write_exr(tiny.folder / "envmaps" / "half.exr", np.full((8, 16, 3), 0.5, np.float32))
    view = tiny.view("c_swept")
    entry = view.evaluation.model_copy(update={"env_map": "envmaps/half.exr"})
    expected = torch.full((3,), 0.5 * (4 * np.pi) ** 0.5)
    for is_linear in (False, True):
        light = published_light(tiny.evaluated, view, entry, is_linear=is_linear)
        torch.testing.assert_close(light.sh[0], expected, rtol=1e-5, atol=0)


def test_a_black_map_is_refused(tiny):
    write_image(tiny.folder / "envmaps" / "black.png", np.zeros((8, 16, 3), np.uint8))
    view = tiny.view("c_swept")
    entry = view.evaluation.model_copy(update={"env_map": "envmaps/black.png"})
    with pytest.raises(InputError, match=r"black\.png: is black.*c_swept.*replace"):
        published_light(tiny.evaluated, view, entry)


def test_a_turn_about_y_or_z_is_refused(tiny):
    view = tiny.view("c_swept")
    entry = view.evaluation.model_copy(update={"rotation_rad": (-1.5, 0.2, 0.0)})
    with pytest.raises(InputError, match=r"c_swept.*y=0\.2 and z=0.*about x alone"):
        published_light(tiny.evaluated, view, entry)
