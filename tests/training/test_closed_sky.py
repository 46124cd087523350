"""A closed sky: no camera under it sees a hole, and training opens none."""

from math import pi

import pytest
import torch
from support.flat_world import NAMES, flat_photos, flat_points
from support.settings import train_settings

from r3gw.geometry.cameras import Camera
from r3gw.model.initial import InitialPoints
from r3gw.model.sky import SkyDome, even_dome, sample_dome
from r3gw.rendering.compose import shaded_splats
from r3gw.rendering.sun_shadow import Gaussians
from r3gw.training.loop import train
from r3gw.training.objective import sky_slopes
from r3gw.training.start import initial_model

DOME = SkyDome(torch.tensor([0.0, 0.5, 0.0]), 8.0, (-pi, pi))
COUNT = 2000  # the fewest of config/photos.yaml
CLOSED = {"is_closed": True, "least_opacity": 0.95}
# From the middle, from half way to the rim, and near the ground.
PLACES = ((0.0, 0.5, 0.0), (2.5, 0.4, -3.0), (-3.5, 0.0, 1.0))


def model_under(angles, **sky):
    settings = train_settings(sky={**CLOSED, **sky})
    return initial_model(InitialPoints(torch.zeros(4, 3), DOME, angles), NAMES, settings)


def least_covered(model) -> float:
    """Smallest opacity of the sky in pictures that look up a quarter of a right angle or more."""
    found = []
    for x, y, z in PLACES:
        for azimuth in range(0, 360, 45):
            turn = torch.deg2rad(torch.tensor(float(azimuth)))
            ahead = torch.stack([turn.sin(), torch.tensor(-1.2), turn.cos()])
            camera = Camera.looking_at(
                torch.tensor([x, y, z]) + ahead, position=(x, y, z), width=80, height=60
            )
            with torch.no_grad():
                lit = model.appearance(0)
                splats = shaded_splats(model, camera, lit.light, lit.sky_light)
            sky = Gaussians(splats.means, splats.quaternions, splats.scales, splats.opacities)
            is_sky = torch.ones(len(splats.means), 1)
            is_sky[: len(model.foreground)] = 0.0
            found.append(float(sky.drawn(is_sky, camera).planes[0].min()))
    return min(found)


def test_even_dome_covers_every_pixel_where_a_random_one_does_not():
    assert 0.99 < least_covered(model_under(even_dome(DOME, COUNT))) <= 1.0
    scattered = sample_dome(DOME, COUNT, torch.Generator().manual_seed(0))
    assert least_covered(model_under(scattered)) < 0.97


@pytest.mark.parametrize("is_closed", [True, False])
def test_training_leaves_a_closed_sky_as_it_is(is_closed):
    """All Gaussians are densified, which without closing the sky moves and splits it."""
    settings = train_settings(
        iterations=60,
        rates={"short_run_boost": 5.0},
        density={"reset_interval": 3000, "threshold_first": 1e-12, "threshold_last": 1e-12},
        sky={"is_closed": is_closed, "least_opacity": 0.95},
    )
    model = initial_model(flat_points(), NAMES, settings)
    before = {name: value.detach().clone() for name, value in model.sky.rows.values.items()}
    before["radius"] = model.sky.radius.detach().clone()
    many = len(model.foreground)
    state = train(model, flat_photos(), settings)
    after = {**state.model.sky.rows.values, "radius": state.model.sky.radius}
    is_same = {
        name: value.shape == after[name].shape and bool((value == after[name]).all())
        for name, value in before.items()
    }
    assert all(is_same.values()) == is_closed, is_same
    assert len(state.model.foreground) > many


def test_a_closed_sky_that_would_stay_thin_is_refused():
    with pytest.raises(ValueError, match=r"'least_opacity' to at least 0\.9, it is 0\.5"):
        train_settings(sky={"is_closed": True, "least_opacity": 0.5})


def test_price_of_slopes_by_hand():
    light = torch.tensor(
        [[9.0, 9.0, 9.0], [1.0, 0.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]], requires_grad=True
    )
    ((name, loss),) = sky_slopes(light, 0.3)
    assert name == "sky_slope"
    torch.testing.assert_close(loss, torch.tensor(0.3 * 6.0 / 9.0))
    (gradient,) = torch.autograd.grad(loss, light)
    torch.testing.assert_close(gradient[0], torch.zeros(3), rtol=0, atol=0)  # its mean is free
    torch.testing.assert_close(gradient[1:], 0.3 * 2 / 9 * light.detach()[1:])
    assert list(sky_slopes(light, 0.0)) == []
