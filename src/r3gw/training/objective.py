"""The training objective of one photo (Eq. 17) with its named parts."""

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.model.model import SceneModel
from r3gw.model.outdoor import OpenSky
from r3gw.model.settings import OutdoorSettings, TrainSettings
from r3gw.rendering.channels import Layers
from r3gw.rendering.compose import Rendering, render
from r3gw.training.losses import fused, plain
from r3gw.training.losses.forms import FormName, LossForms, PictureWeights
from r3gw.training.losses.lighting import random_directions, visible_sky_loss
from r3gw.training.losses.weighted import Weighted, sum_of, value_of
from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule

FORMS: dict[FormName, LossForms] = {"fused": fused, "plain": plain}


def objective(
    model: SceneModel,
    photo: Photo,
    index: int,
    iteration: int,
    schedule: Schedule,
    generator: torch.Generator,
) -> tuple[Rendering, Float[Tensor, ""], dict[str, float]]:
    """Render a training photo; return the loss and its weighted parts that are active now.

    Args:
        model: The scene.
        photo: The target.
        index: The photo's row in the appearance embedding.
        iteration: Counts from 1.
        schedule: Says which losses act.
        generator: Light noise and positivity directions.
    """
    settings, weights = model.settings, model.settings.weights
    losses = FORMS[settings.losses]
    light, sky_light, open_sky = model.appearance(index)
    noisy = model.appearance.noisy(light, generator)
    layers = Layers.OPACITY if settings.silhouette.enabled else Layers.COLOUR
    rendering = render(model, photo.camera, noisy, sky_light, layers)
    acting = acting_weights(settings, schedule, iteration)
    pixels = losses.picture(
        rendering.planes,
        rendering.alpha,
        photo.planes,
        photo.is_valid,
        photo.is_sky,
        photo.camera,
        acting,
        settings.silhouette.solid,
    )
    weighted = [pixels.total]
    separation = "silhouette" if settings.silhouette.enabled else "separation"
    parts = {separation: getattr(acting, separation) * getattr(pixels, separation)}
    if iteration <= schedule.warm_up:
        return rendering, sum_of(weighted), parts

    parts["reconstruction"] = acting.l1 * pixels.l1 + acting.dissimilarity * pixels.dissimilarity
    parts["normal"] = acting.normal * pixels.normal

    def add(name: str, loss: Weighted) -> None:
        weighted.append(loss)
        parts[name] = value_of(loss)

    if open_sky is None:
        directions = random_directions(weights.light_directions, weights.light_domain, generator)
        add("light", losses.positivity(light, directions.to(light), weights.light))
    splats, radii_px = rendering.splats, rendering.radii_px
    if weights.sky_depth > 0:
        num_foreground, gamma = len(model.foreground), weights.sky_depth_gamma
        depths, weight = splats.depths, weights.sky_depth
        add("sky_depth", losses.sky_depth(depths, radii_px, num_foreground, gamma, weight))
    if iteration > schedule.geometry_losses_from:
        add("scale", losses.flatness(splats.smallest_scales, radii_px, weights.scale))
    if open_sky is not None:
        add("light", open_sky_loss(open_sky, photo, settings.outdoor))
    return rendering, sum_of(weighted), parts


def open_sky_loss(open_sky: OpenSky, photo: Photo, settings: OutdoorSettings) -> Float[Tensor, ""]:
    """What keeps the sky near what its photo shows, its gradient near the first (not in the paper).

    It stands in for the positivity loss: a point sun in SH of degree 4 is negative in places.
    """
    steady = settings.sky_gradient * open_sky.change[1:].square().sum()
    if photo.seen_sky is None:
        return steady
    seen = photo.seen_sky
    return steady + settings.visible_sky * visible_sky_loss(
        open_sky.radiance, seen.basis, seen.radiance, seen.is_clipped
    )


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
