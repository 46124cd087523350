"""The training objective of one photo (Eq. 17) with its named parts."""

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.model.model import SceneModel
from r3gw.rendering.compose import Rendering, draw, silhouette_marks
from r3gw.rendering.splats import splats_of
from r3gw.training.lights.kinds import training_of
from r3gw.training.losses.known_gradient import KnownLoss, sum_of
from r3gw.training.losses.picture import PictureWeights, picture_losses
from r3gw.training.losses.regularisers import flatness_loss, sky_depth_loss
from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule
from r3gw.training.settings import TrainSettings, WeightSettings


def objective(
    model: SceneModel,
    settings: TrainSettings,
    photo: Photo,
    index: int,
    iteration: int,
    schedule: Schedule,
    generator: torch.Generator,
) -> tuple[Rendering, Float[Tensor, ""], dict[str, float]]:
    """Render a training photo; return the loss and its weighted parts that are active now.

    Args:
        model: The scene.
        settings: The settings of the run.
        photo: The target.
        index: The photo's row in the appearance embedding.
        iteration: Counts from 1.
        schedule: Says which losses act.
        generator: Light noise and positivity directions.
    """
    weights, silhouette = settings.weights, settings.silhouette
    lit = model.appearance(index)
    noise = torch.randn(lit.light.shape, generator=generator)
    noisy = torch.add(lit.light, noise, alpha=settings.model.light_noise)
    splats = splats_of(model, photo.camera, noisy, lit.sky_light)
    if silhouette.enabled:
        splats = splats.with_channel_sums(silhouette_marks(model, silhouette.solid))
    rendering = draw(splats, photo.camera)
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
    if silhouette.enabled:
        separation += silhouette.solid * photo.solid_share
    parts = {"separation": acting.separation * separation}
    if iteration <= schedule.warm_up:
        return rendering, sum_of(known), parts

    parts["reconstruction"] = acting.l1 * pixels.l1 + acting.dissimilarity * pixels.dissimilarity
    parts["normal"] = acting.normal * pixels.normal

    def add(name: str, loss: KnownLoss) -> None:
        known.append(loss)
        parts[name] = loss.value

    others: list[Tensor] = []  # losses whose gradients torch finds
    for name, loss in training_of(model.appearance.light_model).losses(
        lit, photo, settings, generator
    ):
        if isinstance(loss, KnownLoss):
            add(name, loss)
        else:
            others.append(loss)
            parts[name] = float(loss.detach())
    radii_px = rendering.radii_px
    if weights.sky_depth > 0:
        num_foreground, gamma = len(model.foreground), weights.sky_depth_gamma
        loss = sky_depth_loss(splats.depths, radii_px, num_foreground, gamma, weights.sky_depth)
        add("sky_depth", loss)
    if iteration > schedule.geometry_losses_from:
        add("scale", flatness_loss(splats.smallest_scales, radii_px, weights.scale))
    total = sum_of(known)
    for other in others:
        total = total + other
    return rendering, total, parts


def acting_weights(weights: WeightSettings, schedule: Schedule, iteration: int) -> PictureWeights:
    """Weights of a picture's losses at an iteration: warm-up knows the separation alone."""
    if iteration <= schedule.warm_up:
        return PictureWeights(0.0, 0.0, 0.0, weights.separation)
    normal = weights.normal if iteration > schedule.geometry_losses_from else 0.0
    return PictureWeights(1 - weights.ssim, weights.ssim, normal, weights.separation)
