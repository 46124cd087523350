"""The kernel from parameters to splats against its plain form in float64, forward and backward."""

from copy import deepcopy
from dataclasses import fields

import pytest
import torch

from r3gw.geometry.cameras import Camera
from r3gw.geometry.rotations import rotation_about_axis
from r3gw.model.initial import InitialPoints
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.rendering import reference, splats
from r3gw.rendering.channels import CHANNELS, NUM_LEARNED, Layers
from r3gw.rendering.splat_set import Splats
from r3gw.training.start import initial_model

NAMES = [field.name for field in fields(Splats) if field.name != "layers"]


@pytest.fixture
def turned_camera():
    """Off the origin and turned, so that no axis of the world is one of the camera's."""
    pose = torch.eye(4, dtype=torch.float64)
    pose[:3, :3] = rotation_about_axis(1, 0.3) @ rotation_about_axis(0, -0.2)
    pose[:3, 3] = torch.tensor([0.4, -0.3, 0.7])
    return Camera(pose, (40.0, 42.0, 25.0, 18.0), 48, 36)


def scene(settings, rows, *, specular, seed=0):
    """A model whose rows are random, some colours outside [0, 1], some lights negative."""
    generator = torch.Generator().manual_seed(seed)
    chosen = settings.model.model_copy(update={"specular": specular})
    dome = SkyDome(torch.tensor([0.3, 0.1, 4.0]), 9.0, (-1.5, 1.5))
    points = torch.randn(rows[0], 3, generator=generator) + torch.tensor([0.0, 0.0, 4.0])
    initial = InitialPoints(points, dome, sample_dome(dome, rows[1], generator))
    model = initial_model(initial, ("a",), settings.model_copy(update={"model": chosen}))
    with torch.no_grad():
        for part in (model.foreground, model.sky.rows):
            for name, value in part.values.items():
                spread = 0.1 if name in ("means", "angles") else 1.0
                value.add_(spread * torch.randn(value.shape, generator=generator))
    return model


def outcome(splats_of, model, camera, light, sky_light, layers=Layers.COLOUR):
    """All outputs, and the gradients of a random weighting of them."""
    light = light.clone().requires_grad_()
    leaves = [light]
    if sky_light is not None:
        sky_light = sky_light.clone().requires_grad_()
        leaves.append(sky_light)
    result = splats_of(model, camera, light, sky_light, layers)
    generator = torch.Generator().manual_seed(1)
    total = 0.0
    for name in NAMES:
        value = getattr(result, name)
        weight = torch.randn(value.shape, generator=generator).to(value)
        if name == "features":
            weight[:, NUM_LEARNED:] = 0.0  # the sets' own channels send no gradient
        total = total + (weight * value).sum()
    parameters = [*model.foreground.parameters(), *model.sky.parameters()]
    for parameter in parameters:
        parameter.grad = None
    total.backward()
    gradients = [torch.zeros_like(p) if p.grad is None else p.grad for p in parameters + leaves]
    return [getattr(result, name).detach() for name in NAMES], gradients


@pytest.mark.parametrize("rows", [(0, 5), (1, 0), (16, 16), (500, 70)])
@pytest.mark.parametrize(("coefficients", "specular"), [(25, True), (9, True), (9, False)])
@pytest.mark.parametrize(("white_sky", "layers"), [(False, Layers.COLOUR), (True, Layers.OPACITY)])
def test_equals_the_plain_form(
    settings, turned_camera, rows, coefficients, specular, white_sky, layers
):
    model = scene(settings, rows, specular=specular)
    generator = torch.Generator().manual_seed(2)
    light = 0.5 * torch.randn(coefficients, 3, generator=generator)
    light[0] += 1.5
    sky_light = None if white_sky else 0.6 * torch.randn(4, 3, generator=generator)
    ours = outcome(splats.splats_of, model, turned_camera, light, sky_light, layers)
    exact = deepcopy(model)
    exact.foreground.double()
    exact.sky.double()
    theirs = outcome(
        reference.splats_of,
        *(exact, turned_camera, light.double()),
        None if sky_light is None else sky_light.double(),
        layers,
    )
    for found, expected in zip(ours[0] + ours[1], theirs[0] + theirs[1], strict=True):
        size = float(expected.abs().max()) if expected.numel() else 0.0
        torch.testing.assert_close(found.double(), expected, rtol=2e-3, atol=3e-5 * max(size, 1.0))


def test_bytes_do_not_depend_on_threads(settings, turned_camera):
    model = scene(settings, (9000, 5000), specular=True)
    light, sky_light = torch.randn(25, 3), torch.randn(4, 3)
    outcomes = []
    for threads in (1, 2, 3):
        torch.set_num_threads(threads)
        values, gradients = outcome(splats.splats_of, model, turned_camera, light, sky_light)
        outcomes.append([value.numpy().tobytes() for value in values + gradients])
    torch.set_num_threads(1)
    assert outcomes[0] == outcomes[1] == outcomes[2]


@pytest.mark.parametrize("name", ["means", "log_scales", "albedo_logits", "roughness_logits"])
def test_nan_reaches_the_splats(settings, turned_camera, name):
    """The rasterizer's check has to see what went wrong."""
    model = scene(settings, (40, 3), specular=True)
    with torch.no_grad():
        model.foreground[name].view(-1)[7] = torch.nan
    light = torch.zeros(25, 3)
    light[0] = 3.0
    found = splats.splats_of(model, turned_camera, light, None)
    assert any(bool(torch.isnan(getattr(found, each)).any()) for each in NAMES)


def test_a_degree_without_a_kernel_takes_the_plain_form(model, camera):
    """Degree 3 with nothing in band 3 is degree 2."""
    light = torch.zeros(16, 3)
    light[:9] = torch.randn(9, 3, generator=torch.Generator().manual_seed(0))
    light[0] += 2.0
    found = splats.splats_of(model, camera, light, None).colours
    expected = splats.splats_of(model, camera, light[:9], None).colours
    torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-5)


def test_both_languages_know_the_same_channels(model, camera):
    """The plain form fills the columns by the names that channels.h gives them."""
    light = torch.full((9, 3), 0.3)
    features = [form.splats_of(model, camera, light, None).features for form in (splats, reference)]
    first = 0
    for columns in CHANNELS.values():
        assert columns.start == first
        first = columns.stop
    assert features[0].shape[1] == features[1].shape[1] == first
