"""Training of daylight (beyond the paper): the sky is as bright as photos show it.

Photos show the sky where it is darkest, away from the sun and low; the CIE's skies say how much
brighter it is elsewhere.
"""

from collections.abc import Iterator, Sequence
from math import sqrt

import torch
from jaxtyping import Float
from torch import Tensor

from r3gw.lighting.cie_sky import PARTS, covered_sky, skies
from r3gw.model.appearance import PhotoLight
from r3gw.model.light_models.base import DaySky, LightModel
from r3gw.model.light_models.daylight import Daylight
from r3gw.training.first_values import first_radiance
from r3gw.training.known_suns import Suns, turned, yaw_by_skies
from r3gw.training.lights.base import NamedLoss, Seen, SunTraining
from r3gw.training.photos import Photo
from r3gw.training.settings import OutdoorSettings, TrainSettings
from r3gw.training.sun_from_sky import sun_from_sky
from r3gw.training.visible_sky import VisibleSky, cover_of

# Mean of `covered_sky` over the upper half: what turns the radiance of an even sky into a covered
# one's at the horizon.
COVERED_MEAN = 2.0


def first_daylight(settings: TrainSettings, seen: Seen, suns: Suns = ()) -> Daylight:
    """Skies as the photos show them, per embedding; suns where clear skies say, else overhead.

    Args:
        settings: The settings of the run.
        seen: For each embedding, the skies that its photos show.
        suns: For each embedding, its sun if that is known; with the yaw that clear skies say it
            comes before the sun of its own sky.
    """
    outdoor, degree = settings.outdoor, settings.model.light_degree
    light = Daylight(
        len(seen),
        outdoor.sun_power,
        outdoor.ground_reflectance,
        settings.daylight.sun_bounce,
        settings.daylight.sharp,
        degree,
    )
    light.sky_colours[:, PARTS.index("covered")] = first_radiance(settings) / COVERED_MEAN
    with torch.no_grad():
        known = _known(suns, seen) if settings.daylight.suns == "known" else [None] * len(seen)
        for row, photos in enumerate(seen):
            sun = known[row]
            if sun is None and photos:
                sun = sun_from_sky(photos)
            if photos:
                light.sky_colours[row] = _colours(photos, sun)
            if sun is not None:
                light.sun_directions[row] = sun
                light.sky_suns[row] = sun
    return light


def _known(suns: Suns, seen: Seen) -> Suns:
    """Suns in the world, where time tells them and clear skies tell how the scene lies to north."""
    yaw_deg = yaw_by_skies(suns, seen)
    if yaw_deg is None:
        return [None] * len(seen)
    return [None if sun is None else turned(sun[None], yaw_deg)[0] for sun in suns]


class DaylightTraining(SunTraining):
    """Direction and power of the sun are learned beside the MLP."""

    @torch.no_grad()
    def renew(self, light_model: LightModel, seen: Seen) -> None:
        """Let the skies follow the suns, and be as bright as photos show them."""
        assert isinstance(light_model, Daylight)  # `TRAININGS` pairs them
        suns = torch.nn.functional.normalize(light_model.sun_directions, dim=-1)
        light_model.sky_suns.copy_(suns)
        for row, photos in enumerate(seen):
            if photos:
                light_model.sky_colours[row] = _colours(photos, suns[row])

    def losses(
        self,
        lit: PhotoLight,
        photo: Photo,
        settings: TrainSettings,
        generator: torch.Generator,  # noqa: ARG002
    ) -> Iterator[NamedLoss]:
        """The photo's sky is as bright as the photo shows it, the change of its gradient small."""
        assert isinstance(lit.open_sky, DaySky)  # a Daylight gives it
        yield NamedLoss("light", day_sky_loss(lit.open_sky, photo, settings.outdoor))


def day_sky_loss(sky: DaySky, photo: Photo, settings: OutdoorSettings) -> Float[Tensor, ""]:
    """What keeps the sky near what its photo shows, the learned gradient small."""
    steady = settings.sky_gradient * sky.change[1:].square().sum()
    if photo.seen_sky is None:
        return steady
    seen = photo.seen_sky
    shown = _shapes(seen, sky.sun).T @ sky.colours + seen.basis @ sky.change
    missing = seen.radiance - shown
    missing = torch.where(seen.is_clipped, missing.clamp_min(0.0), missing)
    return steady + settings.visible_sky * missing.square().sum(-1).mean()


def _colours(
    photos: Sequence[VisibleSky], sun: Float[Tensor, "3"] | None
) -> Float[Tensor, "parts 3"]:
    """Colours of the parts of a sky that photos show.

    Haze is white: cameras balance their photos to the light, which is mostly the sun's. So of a
    clear sky the brightness that photos show settles haze, and the rest of their colour is air's.

    Args:
        photos: At least one.
        sun: Where it stands; None where that is not known yet, and a clear sky counts as even.
    """
    radiance = torch.cat([photo.radiance for photo in photos])
    air, haze, covered = torch.cat([_shapes(photo, sun) for photo in photos], dim=1)
    cover = cover_of(radiance.median(dim=0).values)
    white = (radiance.mean(dim=-1) / (air + haze)).median()
    blue = (radiance / air[:, None]).median(dim=0).values - white * (haze / air).median()
    grey = (radiance / covered[:, None]).median(dim=0).values
    clear = (1 - cover) * torch.stack([blue.clamp_min(0.0), white.expand(3)])
    return torch.cat([clear, cover * grey[None]])


def _shapes(seen: VisibleSky, sun: Float[Tensor, "3"] | None) -> Float[Tensor, "parts k"]:
    """How bright the parts of the CIE's skies are in a photo's sky pixels."""
    # Bands 1 of the basis are a factor times y, z and x.
    looks = seen.basis[:, [3, 1, 2]] / sqrt(3 / (4 * torch.pi))
    if sun is not None:
        return skies(looks, sun)
    even = torch.ones_like(looks[:, 0])
    return torch.stack([even, torch.zeros_like(even), covered_sky(looks)])
