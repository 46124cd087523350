"""How much of the sky each foreground Gaussian sees past the others (beyond the paper).

The foreground's opacity goes into a voxel grid, and from every Gaussian rays are cast through it
towards the upper hemisphere. The result is one matrix row per Gaussian, its *occlusion*: what
blocked directions take from the irradiance of an SH light, linear in the light's coefficients
(precomputed radiance transfer; Sloan, Kautz and Snyder, SIGGRAPH 2002). Directions below the
horizon stay open: there the light shows the ground, which sends back what falls on it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi, sqrt

import torch
from jaxtyping import Float
from scipy.spatial import cKDTree
from torch import Tensor

from r3gw.geometry.rotations import rotation_from_quaternion, shortest_axes
from r3gw.lighting import sh
from r3gw.model.rows import OCCLUSION, Rows
from r3gw.model.settings import OcclusionSettings

SAMPLES = 32  # Points that spread a Gaussian's opacity over voxels.
BOX_QUANTILES = (0.02, 0.98)  # Of the positions: what lies outside casts no shadow.
BOX_MARGIN = 3  # Voxels around that box.
PART = 8192  # Gaussians whose samples and rays are held at a time.
STEPS_BETWEEN = 16  # after which rays that have left the grid are put aside
DENSEST = 0.99  # Opacities are cut here, so that their optical depth stays finite.


@dataclass(frozen=True)
class OpacityGrid:
    """Optical depth of one step through each voxel.

    Attributes:
        corner: World position of the first voxel's outer corner.
        voxel: Edge, world units.
        depth: ``[x, y, z]`` optical depth per voxel edge travelled, at least 0.
    """

    corner: Float[Tensor, "3"]
    voxel: float
    depth: Float[Tensor, "x y z"]


@torch.no_grad()
def update_occlusion(
    rows: Rows, camera_centres: Sequence[Float[Tensor, "3"]], settings: OcclusionSettings
) -> None:
    """Cast the foreground's shadows anew; ``rows`` hold the result under `OCCLUSION`.

    Args:
        rows: The foreground, with an `OCCLUSION` entry ``[N, coeff]``; changed in place.
        camera_centres: The training cameras; they say which side of a Gaussian is its outside.
        settings: Grid, rays and smoothing.
    """
    grid = opacity_grid(rows, settings.voxels)
    means, reach = rows["means"].detach(), settings.reach
    normals = shortest_axes(rows["quaternions"], rows["log_scales"]).detach()
    directions = upper_directions(settings.directions).to(means)
    occlusion = torch.empty_like(rows[OCCLUSION])
    degree = int(sqrt(occlusion.shape[1])) - 1
    for part in parts(len(means)):
        axes, centre = normals[part], means[part]
        outer = outer_normals(grid, centre, axes, camera_centres, settings.offset, reach)
        starts = centre + settings.offset * grid.voxel * outer
        seen = visibility(grid, starts, directions, reach, outer)
        lost = (1 - settings.bounce) * (1 - seen)
        occlusion[part] = blocked_irradiance(lost, outer, directions, degree)
        normals[part] = outer
    opacities = rows["opacity_logits"].detach().sigmoid()
    rows[OCCLUSION].copy_(smoothed(occlusion, means, normals, opacities, settings.neighbours))


def parts(count: int) -> Iterator[slice]:
    """Gaussians in parts of at most `PART`, so that samples and rays of few are held at a time."""
    return (slice(first, first + PART) for first in range(0, count, PART))


def upper_directions(count: int) -> Float[Tensor, "{count} 3"]:
    """Spread unit vectors evenly over the upper hemisphere: a Fibonacci spiral."""
    index = torch.arange(count) + 0.5
    height, azimuth = 1 - index / count, pi * (1 + sqrt(5)) * index
    level = torch.sqrt(1 - height.square())
    return torch.stack([level * torch.cos(azimuth), -height, level * torch.sin(azimuth)], dim=-1)


def opacity_grid(rows: Rows, voxels: int) -> OpacityGrid:
    """Spread the Gaussians' opacity over a grid of ``voxels`` along its longest side.

    A Gaussian's optical depth, integrated over its face, is shared out evenly between sample
    points drawn from it; divided by a voxel's face it becomes depth per voxel edge.
    """
    means = rows["means"].detach()
    low, high = torch.quantile(means, means.new_tensor(BOX_QUANTILES), dim=0)
    voxel = float((high - low).max().clamp_min(1e-6)) / voxels
    corner = low - BOX_MARGIN * voxel
    size = ((high - low) / voxel).ceil().long() + 2 * BOX_MARGIN
    scales = rows["log_scales"].detach().exp()
    rotations = rotation_from_quaternion(rows["quaternions"].detach())
    normal = torch.randn(SAMPLES, 3, generator=torch.Generator().manual_seed(0)).to(means)
    widest = scales.sort(dim=-1, descending=True).values
    face = 2 * pi * widest[:, 0] * widest[:, 1]
    opacity = rows["opacity_logits"].detach().sigmoid().clamp(max=DENSEST)
    share = -torch.log1p(-opacity) * face / (voxel**2 * SAMPLES)
    depth = means.new_zeros(int(size.prod()))
    for part in parts(len(means)):
        local = normal * scales[part][:, None]
        points = means[part][:, None] + local @ rotations[part].transpose(1, 2)
        cell = ((points - corner) / voxel).floor().long()
        is_inside = ((cell >= 0) & (cell < size)).all(-1)
        flat = (cell[..., 0] * size[1] + cell[..., 1]) * size[2] + cell[..., 2]
        depth.index_add_(0, flat[is_inside], share[part][:, None].expand_as(flat)[is_inside])
    return OpacityGrid(corner, voxel, depth.reshape(*size.tolist()))


def visibility(
    grid: OpacityGrid,
    starts: Float[Tensor, "n 3"],
    directions: Float[Tensor, "k 3"],
    reach: int,
    normals: Float[Tensor, "n 3"],
) -> Float[Tensor, "n k"]:
    """Transmittance from each start towards each direction, over ``reach`` voxels.

    Rays of one direction step through the same chain of voxels, moved to the start's voxel; the
    first step leaves that voxel. Starts outside the grid see everything. Behind a surface,
    from where nothing lights it, no ray is cast: that counts as seen.
    """
    edge = reach + 1
    padded = torch.nn.functional.pad(grid.depth, (edge,) * 6)
    size = torch.tensor(padded.shape, device=padded.device)
    cell = ((starts - grid.corner) / grid.voxel).floor().long() + edge
    is_inside = ((cell >= edge) & (cell < size - edge)).all(-1)
    cell = torch.where(is_inside[:, None], cell, edge)
    stride = torch.stack([size[1] * size[2], size[2], torch.ones_like(size[0])])
    first = (cell @ stride).int()
    steps = torch.arange(1, edge, device=starts.device)[:, None]
    flat = padded.reshape(-1)
    columns = []
    for direction in directions:
        chain = ((steps * direction).round().long() @ stride).int()
        is_before = normals @ direction > 0
        column = starts.new_zeros(len(starts))
        column[is_before] = flat[first[is_before, None] + chain].sum(dim=1)
        columns.append(column)
    transmitted = torch.exp(-torch.stack(columns, dim=1))
    return torch.where(is_inside[:, None], transmitted, 1.0)


def outer_normals(
    grid: OpacityGrid,
    means: Float[Tensor, "n 3"],
    axes: Float[Tensor, "n 3"],
    camera_centres: Sequence[Float[Tensor, "3"]],
    offset: float,
    reach: int,
) -> Float[Tensor, "n 3"]:
    """Turn each Gaussian's axis to the side from which the cameras see it.

    A camera counts by the cosine of its view times what reaches it through the grid.
    """
    score = means.new_zeros(len(means))
    for centre in camera_centres:
        towards = torch.nn.functional.normalize(centre.to(means) - means, dim=-1)
        cosine = (axes * towards).sum(-1)
        starts = means + (offset * grid.voxel * cosine.sign())[:, None] * axes
        score += cosine * _transmitted(grid, starts, towards, 2 * reach)
    return torch.where(score[:, None] < 0, -axes, axes)


def _transmitted(
    grid: OpacityGrid, starts: Float[Tensor, "n 3"], directions: Float[Tensor, "n 3"], reach: int
) -> Float[Tensor, "n"]:
    """Transmittance along one ray per start; outside the grid nothing holds light back."""
    # One empty voxel all around, into which whatever lies outside is moved.
    padded = torch.nn.functional.pad(grid.depth, (1,) * 6)
    last = torch.tensor(grid.depth.shape, device=padded.device)[:, None]
    first = ((starts - grid.corner) / grid.voxel).T.contiguous()
    towards = directions.T.contiguous()
    flat, (_, height, depth) = padded.reshape(-1), padded.shape
    total, rays = starts.new_zeros(len(starts)), torch.arange(len(starts), device=starts.device)
    for step in range(reach):
        # A place far outside would overflow an integer.
        place = (first + step * towards).floor().clamp(min=-1).minimum(last)
        x, y, z = (place + 1).int()
        total[rays] += flat[(x * height + y) * depth + z]
        if step % STEPS_BETWEEN == STEPS_BETWEEN - 1:
            # A ray that is past the grid's end in some direction does not come back.
            has_left = ((place < 0) & (towards <= 0)) | ((place == last) & (towards >= 0))
            stays = ~has_left.any(dim=0)
            rays, first, towards = rays[stays], first[:, stays], towards[:, stays]
    return torch.exp(-total)


def blocked_irradiance(
    lost: Float[Tensor, "n k"],
    normals: Float[Tensor, "n 3"],
    directions: Float[Tensor, "k 3"],
    degree: int,
) -> Float[Tensor, "n coeff"]:
    """Minus the irradiance that each SH light coefficient loses to blocked directions.

    Args:
        lost: Share of each direction's light that does not arrive, 0 to 1.
        normals: Unit normals.
        directions: Directions that are evenly spread over the upper hemisphere.
        degree: SH degree of the light.
    """
    cosine = (normals @ directions.T).clamp_min(0)
    area = 2 * pi / len(directions)
    return -area * (lost * cosine) @ sh.basis(directions, degree)


def smoothed(
    values: Float[Tensor, "n c"],
    means: Float[Tensor, "n 3"],
    normals: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    neighbours: int,
) -> Float[Tensor, "n c"]:
    """Mean over the nearest Gaussians of like normal, weighted by opacity.

    Layers of thin Gaussians make one surface: those that lie a little deeper must not look
    darker than what covers them.
    """
    count = min(neighbours, len(means))
    points = means.double().cpu().numpy()
    nearest = cKDTree(points).query(points, k=list(range(1, count + 1)))[1]
    index = torch.from_numpy(nearest).to(means.device)
    result = torch.empty_like(values)
    for part in parts(len(means)):
        near = index[part]
        likeness = (normals[near] * normals[part][:, None]).sum(-1).clamp_min(0).square()
        weight = opacities[near] * likeness + 1e-6
        result[part] = (values[near] * weight[..., None]).sum(1) / weight.sum(1, keepdim=True)
    return result
