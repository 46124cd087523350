"""Who stands in the sun: a map of the scene's depth as the sun sees it (Williams 1978).

The foreground is drawn by the rasterizer from far away in the sun's direction. A point is in the
sun as far as nothing that covers its place on that map lies nearer to the sun.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.model.attributes import LOG_SCALES, MEANS, OPACITY, QUATERNIONS
from r3gw.model.model import SceneModel
from r3gw.raster import RasterResult, rasterize

BOX_QUANTILES = (
    0.01,
    0.99,
)  # of the positions: what lies outside is in the sun, and casts no shadow
MARGIN = 0.02  # around that box, in its longest sides
MAP_SIDE_PX = 512  # longer side of the map
DISTANCE = 100.0  # of the camera, in half diagonals of the box: its rays are nearly parallel
# A surface is a layer of Gaussians, not a sheet: what lies nearer to the sun by less than this
# share of the box's longest side is the same surface. SOFTNESS is how gradually that ends.
BIAS, SOFTNESS = 0.015, 0.002
SMALLEST_ALPHA = 1e-3


class Gaussians(NamedTuple):
    """Gaussians as the rasterizer takes them; no gradient goes to them."""

    means: Float[Tensor, "n 3"]
    quaternions: Float[Tensor, "n 4"]
    scales: Float[Tensor, "n 3"]
    opacities: Float[Tensor, "n"]

    def drawn(self, features: Float[Tensor, "n c"], camera: Camera) -> RasterResult:
        """Composite values of them as a camera sees them."""
        return rasterize(
            self.means.detach(),
            self.quaternions.detach(),
            self.scales.detach(),
            self.opacities.detach(),
            features,
            camera.cam_from_world.float(),
            camera.intrinsics,
            camera.width,
            camera.height,
        )


@dataclass(frozen=True, eq=False)
class SunShadow:
    """The scene as the sun sees it.

    Attributes:
        camera: Far away in the sun's direction.
        depth: Camera z of what it sees, less `nearest`.
        alpha: How much of the sun that holds back.
        nearest: Camera z of the nearest Gaussian; depths are counted from there.
        bias: By how much the same surface may lie nearer, world units.
        softness: World units.
    """

    camera: Camera
    depth: Float[Tensor, "h w"]
    alpha: Float[Tensor, "h w"]
    nearest: float
    bias: float
    softness: float

    @torch.no_grad()
    def visibility(self, points: Float[Tensor, "n 3"]) -> Float[Tensor, "n"]:
        """Share of the sun that reaches points in the world: 1 in the sun, 0 in the shade."""
        pose, (fx, fy, cx, cy) = self.camera.cam_from_world, self.camera.intrinsics
        # Counted from `nearest`, the points' depths are small numbers, which float32 tells apart.
        offset = pose[:3, 3] - pose.new_tensor([0.0, 0.0, self.nearest])
        x, y, depth = (points @ pose[:3, :3].T.float() + offset.float()).unbind(-1)
        far = depth + self.nearest
        height, width = self.depth.shape
        column = (x / far * fx + (cx - 0.5)).clamp(-1.0, width)
        row = (y / far * fy + (cy - 0.5)).clamp(-1.0, height)
        left, top = column.floor(), row.floor()
        right, down = column - left, row - top
        stride, ends, held = self._bordered
        place = ((top + 1) * stride + (left + 1)).long()[:, None]
        place = place + torch.tensor([0, 1, stride, stride + 1])
        level, steep = torch.stack([1 - right, right], -1), torch.stack([1 - down, down], -1)
        weights = (steep[:, :, None] * level[:, None, :]).flatten(1)
        # `take` is several times as fast as indexing.
        is_behind = torch.sigmoid((depth / self.softness)[:, None] - ends.take(place))
        return 1 - (weights * held.take(place) * is_behind).sum(-1)

    @cached_property
    def _bordered(self) -> tuple[int, Float[Tensor, "places"], Float[Tensor, "places"]]:
        """The map with a border that holds nothing back, row by row: columns of a row, up to where
        a place's surface reaches, in `softness`, and how much of the sun it holds back."""
        border = (1, 2, 1, 2)  # a place is the first of two by two
        held = torch.nn.functional.pad(self.alpha, border)
        ends = torch.nn.functional.pad((self.depth + self.bias) / self.softness, border)
        return held.shape[1], ends.flatten(), held.flatten()

    @torch.no_grad()
    def seen_from(
        self, camera: Camera, depth: Float[Tensor, "h w"], is_covered: Bool[Tensor, "h w"]
    ) -> Float[Tensor, "h w"]:
        """Share of the sun that reaches what a camera's pixels show.

        Args:
            camera: The view.
            depth: Camera z of its pixels' surfaces.
            is_covered: True where a pixel shows any; the sun reaches all others.
        """
        pose = camera.cam_from_world.float()
        places = is_covered.flatten().nonzero().squeeze(-1)
        rays = pixel_rays(camera).reshape(-1, 3).index_select(0, places)
        local = rays * depth.detach().flatten().index_select(0, places)[:, None]
        lit = torch.ones(depth.numel())
        lit.index_copy_(0, places, self.visibility((local - pose[:3, 3]) @ pose[:3, :3]))
        return lit.reshape(depth.shape)


@torch.no_grad()
def sun_shadow(gaussians: Gaussians, direction: Float[Tensor, "3"]) -> SunShadow:
    """Draw the foreground as the sun sees it.

    Args:
        gaussians: The foreground.
        direction: Unit vector towards the sun.
    """
    means = gaussians.means.detach()
    camera, longest = _sun_camera(means, direction)
    z = means.double() @ camera.cam_from_world[2, :3] + camera.cam_from_world[2, 3]
    nearest = float(z.min()) if len(z) else 0.0
    features = torch.stack([(z - nearest).float(), torch.ones_like(gaussians.opacities)], dim=-1)
    drawn = gaussians.drawn(features, camera)
    alpha = drawn.planes[1]
    depth = drawn.planes[0] / alpha.clamp_min(SMALLEST_ALPHA)
    return SunShadow(camera, depth, alpha, nearest, BIAS * longest, SOFTNESS * longest)


def _sun_camera(means: Float[Tensor, "n 3"], direction: Float[Tensor, "3"]) -> tuple[Camera, float]:
    """A far camera whose picture the scene's box fills; the box's longest side."""
    low, high = torch.quantile(means, means.new_tensor(BOX_QUANTILES), dim=0).double()
    longest = float((high - low).max().clamp_min(1e-6))
    low, high = low - MARGIN * longest, high + MARGIN * longest
    forward = -torch.nn.functional.normalize(direction.detach().double(), dim=0)
    aside = torch.eye(3, dtype=torch.float64)[int(forward.abs().argmin())]
    right = torch.nn.functional.normalize(torch.linalg.cross(aside, forward), dim=0)
    pose = torch.eye(4, dtype=torch.float64)
    pose[:3, :3] = torch.stack([right, torch.linalg.cross(forward, right), forward])
    away = DISTANCE * float((high - low).norm()) / 2
    pose[:3, 3] = -pose[:3, :3] @ ((low + high) / 2 - away * forward)
    sides = torch.stack([low, high])
    corners = torch.cartesian_prod(*sides.T) @ pose[:3, :3].T + pose[:3, 3]
    places = corners[:, :2] / corners[:, 2:]
    first, last = places.min(dim=0).values, places.max(dim=0).values
    focal = MAP_SIDE_PX / float((last - first).max())
    width, height = (max(1, ceil(focal * float(side))) for side in last - first)
    centre = (-focal * float(first[0]), -focal * float(first[1]))
    return Camera(pose, (focal, focal, *centre), width, height), longest


def reach(gaussians: Gaussians, cameras: Sequence[Camera], shadow: SunShadow) -> Float[Tensor, "n"]:
    """Share of the sun that reaches each Gaussian of the foreground, as cameras see it.

    It is the mean over the pixels in which cameras see a Gaussian, weighted by how much of it they
    see, of the share that reaches the pixel: depths of single pixels err more than their mean over
    a Gaussian. What none sees takes the share at its middle.

    Args:
        gaussians: The foreground. The sky lies behind it, and would only lend its distance to
            pixels of the outline.
        cameras: One or more.
        shadow: Who stands in the sun.
    """
    total = torch.zeros(len(gaussians.means), 2)
    for camera in cameras:
        pose = camera.cam_from_world.float()
        depths = gaussians.means.detach() @ pose[2, :3] + pose[2, 3]
        with torch.enable_grad():
            # A Gaussian's share of a pixel is how the pixel changes with what the Gaussian holds.
            held = torch.zeros(len(total), 2, requires_grad=True)
            drawn = gaussians.drawn(torch.cat([depths[:, None], held], dim=-1), camera)
            depth = drawn.planes[0] / drawn.alpha.clamp_min(SMALLEST_ALPHA)
            lit = shadow.seen_from(camera, depth, drawn.alpha > SMALLEST_ALPHA)
            sums = (drawn.planes[1:] * torch.stack([lit, torch.ones_like(lit)])).sum()
            total += torch.autograd.grad(sums, held)[0]
    is_unseen = total[:, 1] <= SMALLEST_ALPHA
    reached = total[:, 0] / total[:, 1].clamp_min(SMALLEST_ALPHA)
    reached[is_unseen] = shadow.visibility(gaussians.means.detach()[is_unseen])
    return reached


@torch.no_grad()
def shadow_in(model: SceneModel, direction: Float[Tensor, "3"]) -> SunShadow:
    """A model's foreground as a sun in some direction sees it."""
    return sun_shadow(foreground_of(model), direction)


@torch.no_grad()
def reach_in(model: SceneModel, camera: Camera, shadow: SunShadow) -> Float[Tensor, "f"]:
    """Share of the sun that reaches each Gaussian of a model's foreground in a camera's picture."""
    return reach(foreground_of(model), [camera], shadow)


def foreground_of(model: SceneModel) -> Gaussians:
    """A model's foreground as the rasterizer takes it."""
    foreground = model.foreground
    return Gaussians(
        foreground[MEANS.name],
        foreground[QUATERNIONS.name],
        LOG_SCALES.of(foreground),
        OPACITY.of(foreground),
    )
