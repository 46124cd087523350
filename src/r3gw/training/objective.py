"""The training objective of one photo (Eq. 17) with its named parts."""

from collections.abc import Iterator

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.model.model import SceneModel
from r3gw.rendering.channels import Layers
from r3gw.rendering.compose import Rendering, draw, shaded_splats
from r3gw.rendering.splat_set import Splats
from r3gw.training.dropping import dropped, share_at
from r3gw.training.lights.base import NamedLoss
from r3gw.training.lights.kinds import training_of
from r3gw.training.losses.choice import FORMS
from r3gw.training.losses.forms import PictureWeights
from r3gw.training.losses.geometry import given_normal_loss
from r3gw.training.losses.lighting import unlikeness
from r3gw.training.losses.weighted import sum_of, value_of
from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule
from r3gw.training.settings import TrainSettings
from r3gw.training.sun_shadows import SunShadows


def objective(
    model: SceneModel,
    settings: TrainSettings,
    photo: Photo,
    index: int,
    iteration: int,
    schedule: Schedule,
    generator: torch.Generator,
    sun_shadows: SunShadows,
) -> tuple[Rendering, Float[Tensor, ""], dict[str, float]]:
    """Render a training photo; return the loss and its weighted parts that are active now.

    Args:
        model: The scene.
        settings: The settings of the run.
        photo: The target.
        index: The photo's row in the appearance embedding.
        iteration: Counts from 1.
        schedule: Says which losses act.
        generator: Draws light noise, directions of the positivity loss, and dropped Gaussians.
        sun_shadows: Those that were cast a short while ago; changed in place.
    """
    losses = FORMS[settings.losses]
    lit = model.appearance(index)
    noise = torch.randn(lit.light.shape, generator=generator).to(lit.light)
    # Noise is on the scene's light: the camera of a dark photo makes it as much darker.
    noise = noise * model.appearance.gains()[index].detach()
    noisy = torch.add(lit.light, noise, alpha=settings.model.light_noise)
    layers = Layers.OPACITY if settings.silhouette.enabled else Layers.COLOUR
    sunlight = None
    if lit.sun is not None:
        sunlight = sun_shadows.of(model, index, photo.camera, lit.sun, iteration, schedule)
    splats = shaded_splats(model, photo.camera, noisy, lit.sky_light, layers, sunlight)
    share = share_at(iteration, settings.iterations, settings.dropping.share)
    rendering = draw(dropped(splats, share, generator), photo.camera, pulls(splats, settings))
    acting = acting_weights(settings, schedule, iteration)
    pixels = losses.picture(
        rendering.planes,
        rendering.alpha,
        photo.planes,
        photo.is_valid,
        photo.is_sky,
        photo.camera,
        acting,
        solid_weight(photo, settings),
    )
    if settings.silhouette.enabled:
        parts = {"silhouette": acting.silhouette * pixels.silhouette}
    else:
        parts = {"separation": acting.separation * pixels.separation}
    if iteration <= schedule.warm_up:
        return rendering, sum_of([pixels.total]), parts

    parts["reconstruction"] = acting.l1 * pixels.l1 + acting.dissimilarity * pixels.dissimilarity
    parts["normal"] = acting.normal * pixels.normal
    light_training = training_of(model.appearance.light_model)
    others = [
        *light_training.losses(lit, photo, settings, generator),
        *gains_losses(model, settings, index, generator),
        *sky_slopes(lit.sky_light, settings.weights.sky_slope),
        *given_normals(rendering, photo, settings, schedule, iteration),
        *regularisers(rendering, settings, schedule, iteration),
    ]
    parts |= {name: value_of(loss) for name, loss in others}
    return rendering, sum_of([pixels.total, *(loss for _, loss in others)]), parts


def solid_weight(photo: Photo, settings: TrainSettings) -> float:
    """Weight of what the foreground lets through where no sky is marked.

    0 in a photo without any marked sky: it shows none, or its sky was not found, and then
    foreground that had to be solid there would stand before the other photos as fog.
    """
    return settings.silhouette.solid if bool(photo.is_sky.any()) else 0.0


def pulls(splats: Splats, settings: TrainSettings) -> Float[Tensor, "n 2"] | None:
    """Where densification wants gradients without signs, what collects them."""
    if settings.density.gradient == "net":
        return None
    return splats.means.new_zeros(len(splats.means), 2).requires_grad_()


def gains_losses(
    model: SceneModel, settings: TrainSettings, index: int, generator: torch.Generator
) -> Iterator[NamedLoss]:
    """What tells a photo's exposure and white balance from its light, where it has them.

    Args:
        model: The scene.
        settings: The settings of the run.
        index: The photo's row.
        generator: Draws the photo whose light this one's is compared with.
    """
    if not settings.gains.enabled:
        return
    appearance, weights = model.appearance, settings.gains
    other = int(torch.randint(len(model.photos), (), generator=generator))
    first, second = (appearance.scene_light(photo).light for photo in (index, other))
    loss = weights.steady * appearance.gains()[index].log().square().sum()
    yield NamedLoss("gains", loss + weights.alike * unlikeness(first, second, weights.warmth))


def sky_slopes(sky_light: Float[Tensor, "4 3"], weight: float) -> Iterator[NamedLoss]:
    """A price on how much a photo's sky differs between one side and the other.

    Where no photo in this light looks, the sky goes on as it begins in the part that one shows: a
    slope too steep is black or white there.
    """
    if weight > 0:
        yield NamedLoss("sky_slope", weight * sky_light[1:].square().mean())


def given_normals(
    rendering: Rendering, photo: Photo, settings: TrainSettings, schedule: Schedule, iteration: int
) -> Iterator[NamedLoss]:
    """Surfaces are turned as the normal map says that came with a photo, if one did.

    Args:
        rendering: The Gaussians as the photo's camera sees them.
        photo: The photo.
        settings: The settings of the run.
        schedule: Says which losses act.
        iteration: Counts from 1.
    """
    weight = settings.weights.given_normal
    if photo.normals is None or weight == 0 or iteration <= schedule.geometry_losses_from:
        return
    loss = given_normal_loss(rendering.normal, photo.normals, photo.is_valid & ~photo.is_sky)
    yield NamedLoss("given_normal", weight * loss)


def regularisers(
    rendering: Rendering, settings: TrainSettings, schedule: Schedule, iteration: int
) -> Iterator[NamedLoss]:
    """Losses of the Gaussians themselves, after the warm-up; each comes times its weight.

    Args:
        rendering: The Gaussians as a photo's camera sees them.
        settings: The settings of the run.
        schedule: Says which losses act.
        iteration: Counts from 1.
    """
    weights, losses = settings.weights, FORMS[settings.losses]
    splats, radii_px = rendering.splats, rendering.radii_px
    if weights.sky_depth > 0:
        num_foreground, gamma = len(splats.smallest_scales), weights.sky_depth_gamma
        depths, weight = splats.depths, weights.sky_depth
        loss = losses.sky_depth(depths, radii_px, num_foreground, gamma, weight)
        yield NamedLoss("sky_depth", loss)
    if iteration > schedule.geometry_losses_from:
        loss = losses.flatness(splats.smallest_scales, radii_px, weights.scale)
        yield NamedLoss("scale", loss)


def acting_weights(settings: TrainSettings, schedule: Schedule, iteration: int) -> PictureWeights:
    """Weights of a picture's losses at an iteration: warm-up knows the separation alone."""
    weights = settings.weights
    if settings.silhouette.enabled:
        separating = PictureWeights(silhouette=weights.separation)
    else:
        separating = PictureWeights(separation=weights.separation)
    if iteration <= schedule.warm_up:
        return separating
    normal = weights.normal if iteration > schedule.geometry_losses_from else 0.0
    return separating._replace(l1=1 - weights.ssim, dissimilarity=weights.ssim, normal=normal)
