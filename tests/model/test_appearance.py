"""Light per photo or per session: who shares what, and what a model file keeps."""

from math import pi, sqrt

import pytest
import torch

from r3gw.lighting.outdoor import outdoor_light
from r3gw.model.initial import InitialPoints
from r3gw.model.light_models.outdoor import OutdoorLight
from r3gw.model.model_file import load_model, save_model
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.training.start import initial_model

PHOTOS = ("a_1", "b_1", "a_2")
SESSIONS = ("a", "b", "a")
SUN_POWER, REFLECTANCE = 1.3, 0.25


@pytest.fixture
def make_model(settings):
    """Build a model of three photos in two sessions."""

    def make(share: bool, skies: torch.Tensor | None = None):
        generator = torch.Generator().manual_seed(0)
        dome = SkyDome(torch.zeros(3), 9.0, (-1.5, 1.5))
        points = InitialPoints(
            torch.randn(20, 3, generator=generator), dome, sample_dome(dome, 10, generator)
        )
        kind = settings.model.model_copy(update={"share_session_light": share})
        changed = settings.model_copy(update={"model": kind})
        light_model = None if skies is None else OutdoorLight(skies, SUN_POWER, REFLECTANCE, 4)
        return initial_model(points, PHOTOS, changed, SESSIONS, light_model=light_model)

    return make


def test_photos_of_a_session_share_light_up_to_exposure(make_model):
    """Equal at first; an exposure scales one photo's light and leaves its sky colour alone."""
    appearance = make_model(True).appearance
    assert appearance.embedding.shape[0] == 2
    with torch.no_grad():
        appearance.log_exposure[2] = torch.log(torch.tensor(1.5))
        (first, sky), (other, _), (third, third_sky) = (appearance(i)[:2] for i in range(3))
    torch.testing.assert_close(third, 1.5 * first, rtol=1e-6, atol=0)
    torch.testing.assert_close(third_sky, sky, rtol=0, atol=0)
    assert float((other - first).abs().max()) > 1e-4


@pytest.mark.parametrize("dropout", [0.0, 0.3])
def test_the_kernel_equals_the_modules(make_model, dropout):
    """Light, sky colour and every gradient; under dropout the same draws are dropped."""
    appearance = make_model(False).appearance
    generator = torch.Generator().manual_seed(3)
    with torch.no_grad():
        for value in appearance.parameters():
            value.add_(0.1 * torch.randn(value.shape, generator=generator))
    appearance.dropout.p = dropout
    outcomes = []
    for run in (appearance, lambda photo: plain_light(appearance, photo)):
        torch.manual_seed(5)
        light, sky, *_ = run(1)
        pull = torch.linspace(-1, 2, light.numel()).view_as(light)
        loss = (pull * light).sum() + sky.square().sum()
        gradients = torch.autograd.grad(loss, list(appearance.parameters()))
        outcomes.append([light.detach(), sky.detach(), *gradients])
    for found, expected in zip(*outcomes, strict=True):
        largest = float(expected.abs().max())
        assert largest > 0
        torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-6 * largest)


def plain_light(appearance, photo):
    """What the forward pass computes, module by module."""
    features = appearance.trunk(appearance.embedding[appearance.rows[photo]])
    return appearance.light_head(features).view(-1, 3), appearance.sky_head(features).view(-1, 3)


@torch.no_grad()
def test_by_default_every_photo_has_its_own_light(make_model):
    appearance = make_model(False).appearance
    assert appearance.embedding.shape[0] == 3
    assert appearance.log_exposure is None
    assert float((appearance(0)[0] - appearance(2)[0]).abs().max()) > 1e-4


def test_model_file_keeps_sessions(make_model, tmp_path):
    model = make_model(True)
    with torch.no_grad():
        model.appearance.log_exposure[2] = 0.3
    save_model(model, tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    assert again.sessions == SESSIONS
    for i in range(3):
        for found, expected in zip(again.appearance(i)[:2], model.appearance(i)[:2], strict=True):
            torch.testing.assert_close(found, expected, rtol=0, atol=0)


@torch.no_grad()
def test_an_outdoor_light_starts_from_its_sky_and_a_sun_overhead(make_model):
    """At first, up to the MLP's small variation: the light of the sky given and of the sun."""
    skies = torch.zeros(2, 4, 3)
    skies[:, 0] = torch.tensor([[0.3], [0.6]]) * sqrt(4 * pi)
    model = make_model(True, skies)
    up, power = torch.tensor([0.0, -1.0, 0.0]), torch.full((3,), SUN_POWER)
    for photo, row in enumerate((0, 1, 0)):
        light, _, open_sky = model.appearance(photo)[:3]
        torch.testing.assert_close(
            open_sky.radiance - open_sky.change, skies[row], rtol=1e-5, atol=1e-6
        )
        assert 1e-5 < float(open_sky.change.abs().max()) < 0.2
        expected = outdoor_light(open_sky.radiance, up, power, REFLECTANCE, 4)
        torch.testing.assert_close(light, expected, rtol=1e-5, atol=1e-5)


@torch.no_grad()
def test_an_exposure_scales_sun_and_sky(make_model):
    appearance = make_model(True, torch.ones(2, 4, 3)).appearance
    appearance.log_exposure[2] = torch.log(torch.tensor(1.5))
    first, third = appearance(0), appearance(2)
    torch.testing.assert_close(third.light, 1.5 * first.light, rtol=1e-5, atol=1e-5)
    torch.testing.assert_close(third.open_sky.radiance, 1.5 * first.open_sky.radiance)


def test_an_outdoor_model_file_keeps_sun_and_sky(make_model, tmp_path):
    model = make_model(True, torch.rand(2, 4, 3, generator=torch.Generator().manual_seed(1)))
    with torch.no_grad():
        model.appearance.light_model.sun_directions[1] = torch.tensor([0.5, -0.5, 0.1])
        model.appearance.light_model.log_sun_powers[1] = 0.7
    save_model(model, tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    for i in range(3):
        found, expected = again.appearance(i), model.appearance(i)
        torch.testing.assert_close(found.light, expected.light, rtol=0, atol=0)
        torch.testing.assert_close(found.open_sky, expected.open_sky, rtol=0, atol=0)
