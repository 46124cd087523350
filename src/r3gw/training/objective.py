"""The training objective of one photo (Eq. 17) with its named parts."""

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.gaussians.compose import Rendering, render
from r3gw.gaussians.model import SceneModel
from r3gw.losses.geometry import normal_loss, normals_from_depth, scale_loss
from r3gw.losses.lighting import ground_loss, positivity_loss, random_directions
from r3gw.losses.reconstruction import reconstruction_loss
from r3gw.losses.separation import separation_loss, sky_depth_loss
from r3gw.training.photos import Photo
from r3gw.training.schedule import Schedule


def objective(
    model: SceneModel,
    photo: Photo,
    index: int,
    iteration: int,
    schedule: Schedule,
    generator: torch.Generator,
) -> tuple[Rendering, dict[str, Float[Tensor, ""]]]:
    """Render a training photo and return the weighted losses that are active now.

    Args:
        model: The scene.
        photo: The target.
        index: The photo's row in the appearance embedding.
        iteration: Counts from 1.
        schedule: Says which losses act.
        generator: Light noise and positivity directions.
    """
    weights = model.settings.weights
    light, sky_light = model.appearance(index)
    noisy = model.appearance.noisy(light, generator)
    rendering = render(model, photo.camera, noisy, sky_light)
    parts: dict[str, Tensor] = {}
    if weights.separation > 0:
        parts["separation"] = weights.separation * separation_loss(
            rendering.foreground, rendering.sky, photo.is_sky, photo.is_valid
        )
    if iteration <= schedule.warm_up:
        return rendering, parts
    parts["reconstruction"] = reconstruction_loss(
        rendering.colour, photo.target(), photo.is_valid, weights.ssim
    )
    directions = random_directions(weights.light_directions, weights.light_domain, generator)
    parts["light"] = weights.light * positivity_loss(light, directions)
    if weights.ground > 0:
        below = -random_directions(weights.light_directions, "hemisphere", generator)
        parts["ground"] = weights.ground * ground_loss(light, below, weights.ground_reflectance)
    is_visible = rendering.radii_px > 0
    num_foreground = len(model.foreground)
    if weights.sky_depth > 0:
        parts["sky_depth"] = weights.sky_depth * sky_depth_loss(
            rendering.depths, is_visible, num_foreground, weights.sky_depth_gamma
        )
    if iteration > schedule.geometry_losses_from:
        is_foreground = photo.is_valid & ~photo.is_sky
        from_depth = normals_from_depth(rendering.depth, photo.camera)
        parts["normal"] = weights.normal * normal_loss(rendering.normal, from_depth, is_foreground)
        parts["scale"] = weights.scale * scale_loss(
            model.foreground["log_scales"], is_visible[:num_foreground]
        )
    return rendering, parts
