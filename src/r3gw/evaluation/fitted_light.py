"""Light, sky, exposure and white balance of a photo that was held out, fitted to it.

The scene stays as it is. Exposure and white balance are three free factors; the light's shape may
leave that of a learned light where the photo asks for it, at a price: half a photo says little of
the light from where none of its surfaces look.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.imaging.colour import GAMMA
from r3gw.lighting.gains import sky_with_gains
from r3gw.lighting.light import DARKEST, Light
from r3gw.lighting.skies import LearnedSky
from r3gw.model.model import SceneModel
from r3gw.rendering.compose import render, sunlight_of

# What a squared change of the light by its own mean radiance costs, in squared display values: with
# an error of 0.1 over a hundred independent pixels, it expects changes of 0.3.
LIGHT_PRIOR = 1e-3
SKY_PRIOR = 1e-3
ITERATIONS = 30


class Target(NamedTuple):
    """The part of a photo that is fitted to.

    Attributes:
        camera: Sees that part alone.
        photo: Display values.
        is_valid: Which pixels count.
    """

    camera: Camera
    photo: Float[Tensor, "h w 3"]
    is_valid: Bool[Tensor, "h w"]


def fitted_light(model: SceneModel, target: Target, starts: Sequence[Light]) -> Light:
    """The light and learned sky under which the scene looks most like the photo.

    Minimises the mean squared error of display values over valid pixels, plus the price of
    changes, from the start that suits best once its exposure and white balance do.

    Args:
        model: The scene, which is not changed.
        target: What to fit to; at least one pixel is valid.
        starts: Lights with learned skies, one or more.
    """
    with _held(model):
        start = min((_balanced(model, target, light) for light in starts), key=lambda each: each[0])
        return _refined(model, target, start[1])


def _refined(model: SceneModel, target: Target, start: Light) -> Light:
    """Descend from ``start`` in gains, light and sky."""
    log_gains = torch.zeros(3, requires_grad=True)
    change = torch.zeros_like(start.sh, requires_grad=True)
    sky_change = torch.zeros(4, 3, requires_grad=True)
    optimizer = torch.optim.LBFGS(
        [log_gains, change, sky_change], max_iter=ITERATIONS, line_search_fn="strong_wolfe"
    )
    scale = max(start.strength, DARKEST)

    def light() -> Light:
        shaped = Light(start.sh + scale * change, _sky(start, sky_change), start.point)
        return times_gains(shaped, log_gains.exp())

    def loss() -> Tensor:
        optimizer.zero_grad()
        price = LIGHT_PRIOR * change.square().sum() + SKY_PRIOR * sky_change.square().sum()
        value = _squared_error(model, target, light()) + price
        torch.autograd.backward(value)
        return value

    optimizer.step(loss)  # type: ignore[no-untyped-call]
    with torch.no_grad():
        return light()


@torch.no_grad()
def _balanced(model: SceneModel, target: Target, light: Light) -> tuple[float, Light]:
    """A light with the gains that suit the photo, nearly, and its squared error."""
    seen = _picture(model, target, light)[target.is_valid]
    wanted = target.photo[target.is_valid]
    factors = (seen * wanted).sum(0) / seen.square().sum(0).clamp_min(DARKEST)
    balanced = times_gains(light, factors.clamp_min(DARKEST) ** GAMMA)
    return float(_squared_error(model, target, balanced)), balanced


def times_gains(light: Light, gains: Float[Tensor, "3"]) -> Light:
    """A light and its learned sky as a camera of other gains per channel sees them.

    Shading is linear in the light, so gains on it are gains on the picture.
    """
    assert isinstance(light.sky, LearnedSky)  # the caller's choice
    sky = LearnedSky(sky_with_gains(light.sky.coefficients, gains))
    return Light(light.sh * gains, sky, None if light.point is None else light.point.times(gains))


def _sky(start: Light, change: Float[Tensor, "4 3"]) -> LearnedSky:
    assert isinstance(start.sky, LearnedSky)  # the caller's choice
    return LearnedSky(start.sky.coefficients + change)


def _squared_error(model: SceneModel, target: Target, light: Light) -> Float[Tensor, ""]:
    picture = _picture(model, target, light)
    return (picture - target.photo)[target.is_valid].square().mean()


def _picture(model: SceneModel, target: Target, light: Light) -> Float[Tensor, "h w 3"]:
    lit, sunlight = (
        (light.sh, light.sky_coefficients),
        sunlight_of(model, target.camera, light.point),
    )
    return render(model, target.camera, *lit, sunlight=sunlight).colour.clamp(0.0, 1.0)


@contextmanager
def _held(model: SceneModel) -> Iterator[None]:
    """Let no gradient go to the scene, and let it again afterwards."""
    rows = (*model.foreground.values.values(), *model.sky.rows.values.values(), model.sky.radius)
    learned = [parameter for parameter in rows if parameter.requires_grad]
    for parameter in learned:
        parameter.requires_grad_(False)
    try:
        yield
    finally:
        for parameter in learned:
            parameter.requires_grad_(True)
