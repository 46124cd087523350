"""The training objective of one photo (Eq. 17) with its named parts."""

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.model.model import SceneModel
from r3gw.model.outdoor import OpenSky
from r3gw.model.settings import OutdoorSettings, WeightSettings
from r3gw.rendering.compose import Rendering, render
from r3gw.training.losses.known_gradient import KnownLoss, sum_of
from r3gw.training.losses.lighting import random_directions, visible_sky_loss
from r3gw.training.losses.picture import PictureWeights, picture_losses
from r3gw.training.losses.regularisers import flatness_loss, positivity_loss, sky_depth_loss
from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule


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
    weights = model.settings.weights
    light, sky_light, open_sky = model.appearance(index)
    noisy = model.appearance.noisy(light, generator)
    rendering = render(model, photo.camera, noisy, sky_light)
    acting = acting_weights(weights, schedule, iteration)
    pixels = picture_losses(
        rendering.planes,
        rendering.alpha,
        photo.planes,
        photo.is_valid,
        photo.is_sky,
        photo.camera,
        acting,
    )
    known = [pixels.total]
    separation = pixels.separation
    if model.settings.silhouette.enabled:
        separation += model.settings.silhouette.solid * photo.solid_share
    parts = {"separation": acting.separation * separation}
    if iteration <= schedule.warm_up:
        return rendering, sum_of(known), parts

    parts["reconstruction"] = acting.l1 * pixels.l1 + acting.dissimilarity * pixels.dissimilarity
    parts["normal"] = acting.normal * pixels.normal

    def add(name: str, loss: KnownLoss) -> None:
        known.append(loss)
        parts[name] = loss.value

    if open_sky is None:
        directions = random_directions(weights.light_directions, weights.light_domain, generator)
        add("light", positivity_loss(light, directions, weights.light))
    splats, radii_px = rendering.splats, rendering.radii_px
    if weights.sky_depth > 0:
        num_foreground, gamma = len(model.foreground), weights.sky_depth_gamma
        loss = sky_depth_loss(splats.depths, radii_px, num_foreground, gamma, weights.sky_depth)
        add("sky_depth", loss)
    if iteration > schedule.geometry_losses_from:
        add("scale", flatness_loss(splats.smallest_scales, radii_px, weights.scale))
    total = sum_of(known)
    if open_sky is not None:
        outdoor = open_sky_loss(open_sky, photo, model.settings.outdoor)
        parts["light"] = float(outdoor.detach())
        total = total + outdoor
    return rendering, total, parts


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


def acting_weights(weights: WeightSettings, schedule: Schedule, iteration: int) -> PictureWeights:
    """Weights of a picture's losses at an iteration: warm-up knows the separation alone."""
    if iteration <= schedule.warm_up:
        return PictureWeights(0.0, 0.0, 0.0, weights.separation)
    normal = weights.normal if iteration > schedule.geometry_losses_from else 0.0
    return PictureWeights(1 - weights.ssim, weights.ssim, normal, weights.separation)
