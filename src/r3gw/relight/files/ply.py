"""Gaussian PLY files: what viewers of 3D Gaussian splatting open, and a superset of it.

Little-endian float32, one vertex per Gaussian, in the order of `STANDARD`: the form that 3DGS
(Kerbl et al. 2023) made common. ``f_dc`` is (display colour - 0.5) / Y_00, scales are logs,
opacity is a logit, rot is wxyz. A relightable file adds `RELIGHTABLE`; viewers pass over that.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import torch
from jaxtyping import Float
from numpy.typing import NDArray
from pydantic import Field
from torch import Tensor

from r3gw.files import InputError
from r3gw.files.ply import read_vertices, write_vertices
from r3gw.files.strict import Strict, validated
from r3gw.geometry.similarity import Similarity
from r3gw.model.attributes import (
    LOG_SCALES,
    MATERIALS,
    MEANS,
    OPACITY,
    QUATERNIONS,
    Attribute,
)
from r3gw.relight.files.lights_file import HIGHEST_DEGREE, read_lights
from r3gw.relight.gaussians import Relightable
from r3gw.relight.move import moved
from r3gw.scene.scene import Gauge

Y_00 = 0.28209479
POSITION, NORMAL = MEANS.columns, ("nx", "ny", "nz")
COLOUR = ("f_dc_0", "f_dc_1", "f_dc_2")
SCALE, ROTATION = LOG_SCALES.columns, QUATERNIONS.columns
STANDARD = (*POSITION, *NORMAL, *COLOUR, *OPACITY.columns, *SCALE, *ROTATION)
MATERIAL = tuple(column for material in MATERIALS.values() for column in material.columns)
RELIGHTABLE = (*MATERIAL, "is_sky")  # is_sky is an unsigned byte
OCCLUSION = "occlusion_"  # and a number: SH transfer, where the scene models shadows

COMMENT = "r3gw "
Coordinates = Literal["scene", "source"]


@dataclass(frozen=True)
class Baked:
    """Colours of a scene under one light.

    Attributes:
        colours: ``[N, 3]`` display values.
        normals: ``[N, 3]`` unit, facing the cameras; 0 for the sky.
    """

    colours: Float[Tensor, "n 3"]
    normals: Float[Tensor, "n 3"]


@dataclass(frozen=True)
class Placement:
    """The coordinates that a file is in; the scene's similarity leads from one to the other."""

    coordinates: Coordinates
    scene_from_source: Similarity


class _Facts(Strict):
    """What the header's comments say of a relightable file."""

    coordinates: Coordinates
    scene_from_source: Gauge
    light_degree: int = Field(ge=0, le=HIGHEST_DEGREE)
    with_specular: bool
    point_sun: bool = False
    sun_bounce: float = Field(0.0, ge=0, le=1)
    sharp: float = Field(1.0, ge=0, le=1)


def write_ply(
    path: Path, gaussians: Relightable, baked: Baked, placement: Placement, *, relightable: bool
) -> None:
    """Write a scene.

    Args:
        path: File to write.
        gaussians: The scene, already in the placement's coordinates.
        baked: Its colours and normals.
        placement: Recorded in the header's comments.
        relightable: Whether to add albedo, roughness and is_sky.
    """
    shadows = gaussians.occlusion if relightable else None
    transfer = () if shadows is None else _occlusion_names(shadows.shape[1])
    names = STANDARD + (RELIGHTABLE if relightable else ()) + transfer
    rows = np.empty(len(gaussians.means), [(n, "u1" if n == "is_sky" else "<f4") for n in names])
    _fill(rows, POSITION, gaussians.means)
    _fill(rows, NORMAL, baked.normals)
    _fill(rows, COLOUR, (baked.colours - 0.5) / Y_00)
    _fill(rows, OPACITY.columns, gaussians.opacity_logits)
    _fill(rows, SCALE, gaussians.log_scales)
    _fill(rows, ROTATION, gaussians.quaternions)
    if relightable:
        for name, material in MATERIALS.items():
            _fill(rows, material.columns, getattr(gaussians, name))
        rows["is_sky"] = np.arange(len(rows)) >= gaussians.num_foreground
        if shadows is not None:
            _fill(rows, transfer, shadows)
    facts: dict[str, Any] = {
        "coordinates": placement.coordinates,
        "scene_from_source": Gauge.of(placement.scene_from_source).model_dump(mode="json"),
        "light_degree": gaussians.light_degree,
        "with_specular": gaussians.with_specular,
    }
    if gaussians.has_point_sun:
        facts |= {"point_sun": True, "sun_bounce": gaussians.sun_bounce, "sharp": gaussians.sharp}
    comments = [f"{COMMENT}{name} {json.dumps(value)}" for name, value in facts.items()]
    write_vertices(path, rows, comments)


def read_ply(path: Path) -> Relightable:
    """Read a relightable file, and the lights of ``lights.json`` beside it, as a scene to relight.

    A file in scene coordinates comes back bit for bit; one in source coordinates is carried back
    to the scene's, to float32 rounding.

    Raises:
        InputError: If the file is missing, no PLY file, or without the relightable properties.
    """
    rows, facts = _parsed(path)
    names = rows.dtype.names or ()
    transfer = _occlusion_names(sum(name.startswith(OCCLUSION) for name in names))
    needed = (*POSITION, *ROTATION, *SCALE, *OPACITY.columns, *RELIGHTABLE, *transfer)
    if lacking := [name for name in needed if name not in names]:
        raise InputError(
            f"{path}: no relightable scene (it lacks r3gw's property {lacking[0]}); "
            "give the relightable.ply of `python -m r3gw export`"
        )
    if len(transfer) not in (0, (facts.light_degree + 1) ** 2):
        raise InputError(
            f"{path}: has {len(transfer)} occlusion properties, which light of degree "
            f"{facts.light_degree} does not need; export the scene again"
        )
    if not _columns(rows, ROTATION).any(dim=1).all():
        raise InputError(f"{path}: has an orientation (rot) of zeros; export the scene again")
    numbers = [name for name in needed if name != "is_sky"]
    if not all(np.isfinite(rows[name]).all() for name in numbers):
        raise InputError(f"{path}: holds NaN or infinite values; export the scene again")
    is_sky = torch.from_numpy(rows["is_sky"] > 0)
    if bool((is_sky[1:] < is_sky[:-1]).any()):
        raise InputError(f"{path}: the sky's Gaussians must come last; do not reorder the file")
    count = int((~is_sky).sum())
    lights = read_lights(path.parent)
    for photo, light in lights.items():
        if len(light.sh) != (facts.light_degree + 1) ** 2:
            raise InputError(
                f"{path}: its lights have degree {facts.light_degree}, but that of {photo} in "
                "lights.json beside it has another; export the scene again"
            )
    gaussians = Relightable(
        means=_attribute(rows, MEANS),
        quaternions=_attribute(rows, QUATERNIONS),
        log_scales=_attribute(rows, LOG_SCALES),
        opacity_logits=_attribute(rows, OPACITY),
        **{name: _attribute(rows[:count], each) for name, each in MATERIALS.items()},
        lights=lights,
        light_degree=facts.light_degree,
        with_specular=facts.with_specular,
        occlusion=_columns(rows[:count], transfer) if transfer else None,
        has_point_sun=facts.point_sun,
        sun_bounce=facts.sun_bounce,
        sharp=facts.sharp,
        origin=str(path),
    )
    if facts.coordinates == "scene":
        return gaussians
    return moved(gaussians, facts.scene_from_source.similarity)


def _occlusion_names(count: int) -> tuple[str, ...]:
    return tuple(f"{OCCLUSION}{i}" for i in range(count))


def _fill(rows: NDArray[Any], names: tuple[str, ...], values: Float[Tensor, "n ..."]) -> None:
    """Write values of all Gaussians, or of the foreground alone; the sky's are then 0."""
    columns = values.detach().numpy().reshape(len(values), len(names)).T
    for name, column in zip(names, columns, strict=True):
        rows[name] = 0
        rows[name][: len(column)] = column


def _attribute(rows: NDArray[Any], attribute: Attribute) -> Float[Tensor, "n ..."]:
    return _columns(rows, attribute.columns).reshape(len(rows), *attribute.shape)


def _columns(rows: NDArray[Any], names: tuple[str, ...]) -> Float[Tensor, "n c"]:
    return torch.from_numpy(np.stack([rows[name].astype(np.float32) for name in names], axis=-1))


def _parsed(path: Path) -> tuple[NDArray[Any], _Facts]:
    """The vertices, and what r3gw's own comments in the header say; those of others are theirs."""
    if not path.is_file():
        raise InputError(f"{path}: no such file; export the scene first")
    try:
        rows, comments = read_vertices(path)
        own = (text.removeprefix(COMMENT) for text in comments if text.startswith(COMMENT))
        facts = {
            name: json.loads(value) for name, _, value in (text.partition(" ") for text in own)
        }
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a PLY file of Gaussians ({error})") from error
    if not facts:
        raise InputError(
            f"{path}: no relightable scene (it lacks r3gw's comments in the header); "
            "give the relightable.ply of `python -m r3gw export`"
        )
    return rows, validated(_Facts, facts, f"{path}: header")
