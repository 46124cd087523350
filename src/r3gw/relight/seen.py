"""How well the training photos saw what a camera shows.

A surface is well seen if two photos see it from about where the camera stands (within 30 degrees as
seen from the surface): two fix where it is, and near ones how it looks from there. What fewer saw
is a guess, however sharp it looks.
"""

from collections.abc import Sequence
from math import cos, radians

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from r3gw.geometry.cameras import Camera
from r3gw.relight.gaussians import Relightable
from r3gw.relight.visibility import is_seen

NEAR_DEG = 30.0
ENOUGH_PHOTOS = 2
MOST_ASKED = 32  # Photos that a camera asks, the nearest first.
SMALLEST_OPACITY = 1e-3
GUESSED_BRIGHTNESS, GUESSED_COLOUR = 0.35, 0.25  # What `dimmed` leaves.
POOR_SHARE = 0.5  # Below, most of a picture's surfaces are guessed.


class Coverage:
    """What the training photos saw of a scene; each photo is looked through when first needed."""

    def __init__(self, gaussians: Relightable, cameras: Sequence[Camera]) -> None:
        """What was trained, and the cameras of the photos that it was trained on."""
        self._gaussians = gaussians
        self._cameras = tuple(cameras)
        self._seen: dict[int, Bool[Tensor, f]] = {}

    def is_well_seen(self, place: Float[Tensor, "3"]) -> Bool[Tensor, "f"]:
        """Whether enough photos see each foreground Gaussian from near a place's direction."""
        means = self._gaussians.means[: self._gaussians.num_foreground]
        towards = torch.nn.functional.normalize(place.to(means) - means, dim=-1)
        count = torch.zeros(len(means), dtype=torch.int64)
        for number in self._nearest(place):
            centre = self._cameras[number].centre.to(means)
            photos = torch.nn.functional.normalize(centre - means, dim=-1)
            is_near = (photos * towards).sum(-1) >= cos(radians(NEAR_DEG))
            count += self._seen_by(number) & is_near
        return count >= ENOUGH_PHOTOS

    def planes(self, camera: Camera) -> tuple[Float[Tensor, "h w"], Float[Tensor, "h w"]]:
        """Opacities that the well-seen and that all foreground Gaussians contribute to a picture.

        A pixel of a surface that was well seen has the two alike.
        """
        gaussians = self._gaussians
        features = torch.zeros(len(gaussians.means), 2)
        features[: gaussians.num_foreground, 0] = self.is_well_seen(camera.centre).float()
        features[: gaussians.num_foreground, 1] = 1.0
        drawn = gaussians.drawn(features, camera)
        return drawn.planes[0], drawn.planes[1]

    def share(self, camera: Camera) -> float | None:
        """Share of the surfaces in a picture that was well seen; None where it shows none."""
        well, surfaces = self.planes(camera)
        total = float(surfaces.sum())
        return float(well.sum()) / total if total > SMALLEST_OPACITY * surfaces.numel() else None

    def _nearest(self, place: Float[Tensor, "3"]) -> list[int]:
        distances = [float((camera.centre - place).norm()) for camera in self._cameras]
        return sorted(range(len(distances)), key=distances.__getitem__)[:MOST_ASKED]

    def _seen_by(self, number: int) -> Bool[Tensor, "f"]:
        if number not in self._seen:
            gaussians = self._gaussians
            points = gaussians.means[: gaussians.num_foreground]
            self._seen[number] = is_seen(gaussians, self._cameras[number], points)
        return self._seen[number]


def dimmed(colours: Float[Tensor, "f 3"], is_well: Bool[Tensor, "f"]) -> Float[Tensor, "f 3"]:
    """Colours of which those of guessed Gaussians are dark and nearly grey.

    Args:
        colours: Values of a tone curve.
        is_well: `Coverage.is_well_seen` from where the camera stands.
    """
    grey = colours.mean(dim=-1, keepdim=True)
    pale = GUESSED_BRIGHTNESS * (grey + GUESSED_COLOUR * (colours - grey))
    return torch.where(is_well[:, None], colours, pale)


def remark(share: float | None) -> str | None:
    """A sentence for who looks at a picture of which little was well seen; None otherwise."""
    if share is None or share >= POOR_SHARE:
        return None
    return (
        f"{round(100 * share)} % of the surfaces in view were seen by {ENOUGH_PHOTOS} photos from "
        f"within {NEAR_DEG:.0f} degrees; the rest is guessed"
    )
