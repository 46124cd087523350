"""Everything that a page knows, as JSON and named blobs of bytes (web/src/payload.ts)."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi, sqrt
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.files import InputError
from r3gw.lighting.light import Light
from r3gw.relight.cameras import focus
from r3gw.relight.gaussians import Relightable
from r3gw.relight.lights import learned_strength
from r3gw.scene import Scene
from r3gw.view.buffers import buffers_of, most_important
from r3gw.view.constants import constants, split_sum_table
from r3gw.view.coverage import coverage
from r3gw.view.daylight import BUNDLE, daylight_tables
from r3gw.view.photos import photo_record
from r3gw.view.seen import seen_bits
from r3gw.view.witnesses import witness_records

LICENCES = ("LICENCES.txt", "HOSEK_WILKIE.txt")
DEPTH_QUANTILES = (0.02, 0.98)
LIGHT_DIGITS = 6


@dataclass(frozen=True)
class PageOptions:
    """What goes into a page.

    Attributes:
        title: Heading; None is the scene's name.
        most_gaussians: More are thinned out, the least visible first.
        most_pictures: Photos to fade to; further photos are cameras and thumbnails alone.
        facts: Lines about the run, shown as they are.
        start: The state in which it opens (r3gw.view.start), over the page's own.
    """

    title: str | None = None
    most_gaussians: int = 300_000
    most_pictures: int = 60
    facts: tuple[str, ...] = ()
    start: Mapping[str, Any] = field(default_factory=dict)


DEFAULTS = PageOptions()


@dataclass(frozen=True)
class Payload:
    """JSON for the element ``payload``, and the bytes of the other blobs."""

    facts: dict[str, Any]
    blobs: dict[str, bytes]


def payload_of(
    gaussians: Relightable, scene: Scene, scene_folder: Path, options: PageOptions = DEFAULTS
) -> Payload:
    """Collect a page's content.

    Args:
        gaussians: The trained scene.
        scene: Its photos' cameras.
        scene_folder: Where their pictures are.
        options: What goes in.

    Raises:
        InputError: If the scene has no photos or the model no Gaussians.
    """
    if not scene.views:
        raise InputError(f"{scene_folder}: the scene has no photos, so no camera to start from")
    if len(gaussians.means) == 0:
        raise InputError(f"{scene_folder}: the model has no Gaussians to show")
    shown = most_important(gaussians, options.most_gaussians)
    views = [*scene.split("train"), *scene.split("test")]
    cameras = [view.camera for view in scene.split("train")]
    middle = shown.middle if shown.num_foreground else shown.means.mean(dim=0)
    buffers, table = buffers_of(shown), split_sum_table()
    blobs = {
        "place": buffers.place.tobytes(),
        "shape": buffers.shape.tobytes(),
        "surface": buffers.surface.tobytes(),
        "table": table.tobytes(),
    }
    if buffers.transfer is not None:
        blobs["transfer"] = buffers.transfer.tobytes()
    asked, bits = seen_bits(shown, cameras, len(buffers.place))
    blobs["seen"] = bits.tobytes()
    witnesses, dark = witness_records(gaussians, cameras)
    if dark:
        blobs["dark"] = dark
    facts = {
        "title": options.title or scene.name,
        "numForeground": shown.num_foreground,
        "numSky": shown.num_sky,
        "numLeftOut": len(gaussians.means) - len(shown.means),
        "rows": len(buffers.place),
        "withSpecular": shown.with_specular,
        "lightDegree": shown.light_degree,
        "hasShadows": shown.occlusion is not None,
        "transferScale": buffers.transfer_scale.tolist(),
        "tableSize": len(table),
        "constants": constants(),
        "daylight": daylight_tables(),
        **_learned(shown),
        "photos": [
            photo_record(view, scene_folder, with_picture=i < options.most_pictures)
            for i, view in enumerate(views)
        ],
        "focus": focus(cameras or [views[0].camera], middle).tolist(),
        "depthRange": _depth_range(shown, cameras),
        "coverage": coverage(shown, cameras),
        "asked": asked,
        "witnesses": witnesses,
        "facts": list(options.facts),
        "start": dict(options.start),
        "licences": "\n\n".join((BUNDLE / name).read_text() for name in LICENCES),
    }
    return Payload(json.loads(json.dumps(facts)), blobs)


def _learned(gaussians: Relightable) -> dict[str, Any]:
    """Learned lights and what exposure ``auto`` aims at (r3gw.relight.lights)."""
    if not gaussians.lights:
        return {"lights": [], "learnedMean": None}
    lights = [
        {"photo": photo, "light": _rows(light.sh), "sky": _rows(_sky(light))}
        for photo, light in gaussians.lights.items()
    ]
    return {"lights": lights, "learnedMean": learned_strength(gaussians)}


def _sky(light: Light) -> Float[Tensor, "skycoeff 3"]:
    """Coefficients of a learned light's sky; a white one has the colour 1 everywhere."""
    if light.sky_coefficients is None:
        return torch.cat([torch.full((1, 3), 0.5 * sqrt(4 * pi)), torch.zeros(3, 3)])
    return light.sky_coefficients


def _rows(values: Float[Tensor, "coeff 3"]) -> list[list[float]]:
    return [[round(value, LIGHT_DIGITS) for value in row] for row in values.tolist()]


def _depth_range(gaussians: Relightable, cameras: list[Any]) -> list[float]:
    """Depths of the foreground over the training cameras, without the outermost."""
    means = gaussians.means[: gaussians.num_foreground]
    if not cameras or not len(means):
        return [0.0, 1.0]
    centres = torch.stack([camera.centre for camera in cameras]).to(means)
    forwards = torch.stack([camera.cam_from_world[2, :3] for camera in cameras]).to(means)
    picked = means[:: max(1, len(means) // 2000)]
    depths = ((picked[:, None] - centres) * forwards).sum(-1)
    ahead = depths[depths > 0]
    if not len(ahead):
        return [0.0, 1.0]
    some = ahead[:: max(1, len(ahead) // 100_000)]
    low, high = torch.quantile(some, torch.tensor(DEPTH_QUANTILES)).tolist()
    return [low, max(high, low + 1e-3)]
