"""Taking one photo: its passers-by, its exposure, its masks and its ground truth."""

from dataclasses import dataclass

import cv2
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from r3gw.benchmark import passersby, render
from r3gw.benchmark.cameras import WORLD_FROM_BUILDING
from r3gw.benchmark.devices import Device
from r3gw.benchmark.lights import Session
from r3gw.benchmark.materials import Kind, Material
from r3gw.benchmark.meshes import Part
from r3gw.benchmark.meshes import place as placed
from r3gw.benchmark.place import Place
from r3gw.benchmark.seeds import stream
from r3gw.benchmark.write import Shot
from r3gw.geometry.cameras import Camera
from r3gw.lighting.daylight import Map, solid_angles

EVALUATED = (Kind.BUILDING, Kind.GROUND)
KEY = 0.18  # Geometric mean of linear values that the camera's metering aims at
MASK_MARGIN_PX = 3  # Side of the square that occluder masks are grown by


@dataclass(frozen=True)
class Plan:
    """One photo before rendering.

    Attributes:
        stem: File name without extension.
        session: Its light.
        camera: Its camera.
        has_passersby: Whether people or cars stand in the way.
        device: What took it; None where every photo has a pinhole camera of its own.
    """

    stem: str
    session: Session
    camera: Camera
    has_passersby: bool
    device: Device | None = None


class Exposure:
    """A session's camera settings: one metering and white balance, small scatter per photo."""

    def __init__(self, light: Map, random: np.random.Generator) -> None:
        weight = solid_angles(light.shape[0])
        total = (light * weight).sum((0, 1))
        balance = (total.mean() / total) ** 0.75 * random.uniform(0.96, 1.04, 3)
        red, green, blue = balance / balance[1]
        self.white_balance = (float(red), float(green), float(blue))
        self._random = random
        self._bias = float(random.uniform(0.88, 1.14))
        self._metered: float | None = None

    def of(self, radiance: NDArray[np.float32]) -> float:
        """Exposure of the next photo; the first photo of a session meters for all."""
        if self._metered is None:
            grey = radiance.mean(axis=-1)
            self._metered = KEY / float(np.exp(np.log(grey + 1e-4 * grey.mean()).mean()))
        return self._metered * self._bias * float(self._random.uniform(0.93, 1.07))


class Studio:
    """A place built once, to be photographed in any light."""

    def __init__(self, place: Place, seed: int, samples: int, *, is_denoised: bool) -> None:
        parts, materials = place.build(stream(seed, place.name, "build"))
        self._place, self._seed, self._samples = place, seed, samples
        self._is_denoised = is_denoised
        self._solids = render.shapes(parts, materials)
        self._kinds = [materials[name].kind for name in self._solids]

    def lit(self, emitter: mi.Emitter) -> mi.Scene:
        """The place without passers-by under a light."""
        return render.scene(emitter, self._solids)

    def shoot(self, plan: Plan, lit: mi.Scene, emitter: mi.Emitter, exposure: Exposure) -> Shot:
        """Render a photo with its masks and ground truth.

        Args:
            plan: What to photograph.
            lit: The place under the session's light, from `lit`.
            emitter: That light.
            exposure: The session's camera settings.
        """
        random = stream(self._seed, self._place.name, plan.stem)
        truth = render.truth(lit, plan.camera, self._kinds)
        is_kept = np.ones(truth.depth.shape, dtype=bool)
        if plan.has_passersby:
            crowd = render.shapes(*_crowd(self._place, plan.camera, random))
            lit = render.scene(emitter, self._solids | crowd)
            kinds = [*self._kinds, *(Kind.OCCLUDER for _ in crowd)]
            is_hit = render.touches(lit, plan.camera, kinds, Kind.OCCLUDER)
            grown = cv2.dilate(is_hit.astype(np.uint8), np.ones((MASK_MARGIN_PX,) * 2, np.uint8))
            is_kept = grown == 0
        radiance = render.photo(lit, plan.camera, self._samples, int(random.integers(2**31)))
        evaluated = [render.KINDS.index(kind) for kind in EVALUATED]
        return Shot(
            plan.stem,
            plan.session,
            plan.camera,
            radiance,
            exposure.of(radiance),
            exposure.white_balance,
            is_kept,
            np.isin(truth.kind, evaluated) & is_kept,
            truth,
            plan.device,
            self._is_denoised,
        )


def _crowd(
    place: Place, camera: Camera, random: np.random.Generator
) -> tuple[list[Part], dict[str, Material]]:
    """Two to four people, or a car and a person, between the camera and the building."""
    eye = WORLD_FROM_BUILDING.T @ camera.centre.numpy()
    ahead = (np.asarray(place.walk.focus) - eye)[:2]
    reach = np.linalg.norm(ahead)
    ahead /= reach
    aside = np.array([ahead[1], -ahead[0]])

    def spot(low: float, high: float, spread: float) -> tuple[float, float, float]:
        x, y = eye[:2] + ahead * reach * random.uniform(low, high)
        x, y = np.array([x, y]) + aside * random.uniform(-spread, spread)
        return float(x), float(y), 0.0

    parts: list[Part] = []
    people = int(random.integers(2, 5))
    if random.uniform() < 0.35:
        people = 1
        heading = float(np.degrees(np.arctan2(aside[1], aside[0])) + random.uniform(-12, 12))
        parts += placed(passersby.car(), heading, spot(0.42, 0.5, 1.6))
    for _ in range(people):
        turn = float(random.uniform(0, 360))
        parts += placed(passersby.person(random), turn, spot(0.38, 0.62, 1.9))
    return parts, passersby.materials(random)
