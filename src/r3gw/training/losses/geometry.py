"""Normal consistency (Eq. 13) and flatness (Eq. 14) of the foreground."""

import torch
from jaxtyping import Bool, Float, Int8
from torch import Tensor

from r3gw.geometry.cameras import Camera, pixel_rays


def normals_from_depth(depth: Float[Tensor, "h w"], camera: Camera) -> Float[Tensor, "h w 3"]:
    """Unit world normals that face the camera, by central differences of back-projected depth.

    Border pixels use one-sided differences. The gradient reaches the depth.

    Args:
        depth: Camera z, world units.
        camera: The view; its true intrinsics are used.
    """
    points = pixel_rays(camera).to(depth.device) * depth[..., None]
    down, right = torch.gradient(points, dim=(0, 1))
    # In camera axes (y down, z forward) down x right points back at the camera.
    normals = torch.nn.functional.normalize(torch.cross(down, right, dim=-1), dim=-1, eps=1e-12)
    world_from_cam = camera.cam_from_world[:3, :3].T.to(normals)
    return normals @ world_from_cam.T


def normal_loss(
    rendered: Float[Tensor, "h w 3"],
    from_depth: Float[Tensor, "h w 3"],
    is_foreground: Bool[Tensor, "h w"],
) -> Float[Tensor, ""]:
    """Mean of ``1 - N_rendered . N_depth`` over foreground pixels; 0 if there are none."""
    mismatch = 1 - (rendered * from_depth).sum(-1)
    return torch.where(is_foreground, mismatch, 0.0).sum() / is_foreground.sum().clamp_min(1)


def given_normal_loss(
    rendered: Float[Tensor, "h w 3"],
    given: Int8[Tensor, "h w 3"],
    is_foreground: Bool[Tensor, "h w"],
) -> Float[Tensor, ""]:
    """Mean of ``1 - N_rendered . N_given`` over foreground pixels with a normal; 0 without any.

    Args:
        rendered: Composited normals, world axes, not normalised.
        given: Unit normals times 127, world axes; 0 where there is none.
        is_foreground: True where surfaces are seen.
    """
    is_given = (given != 0).any(dim=-1) & is_foreground
    mismatch = 1 - (rendered * given.to(rendered)).sum(-1) / 127
    return torch.where(is_given, mismatch, 0.0).sum() / is_given.sum().clamp_min(1)


def flatness_loss(
    smallest_scales: Float[Tensor, "n"], is_visible: Bool[Tensor, "n"]
) -> Float[Tensor, ""]:
    """Mean smallest scale of the visible foreground, world units; 0 if nothing is visible."""
    return torch.where(is_visible, smallest_scales, 0.0).sum() / is_visible.sum().clamp_min(1)
