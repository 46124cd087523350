"""Where the sun stood over each photo, where its date, time and place are known (beyond the paper).

Only elevation and azimuth over the earth follow from these; how the scene lies to the north is
solved in training (r3gw.training.known_suns).
"""

from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from zoneinfo import ZoneInfo

from astral import Observer
from astral.sun import zenith_and_azimuth

from r3gw.imaging.exif import read_exif_block
from r3gw.importing.clock import has_clock, metadata, moment
from r3gw.importing.named_files import listed
from r3gw.importing.settings import Place, SceneSettings
from r3gw.importing.source import SourceScene, SourceView
from r3gw.scene.sun_position import SunPosition


def sun_over(when: datetime, latitude_deg: float, longitude_deg: float) -> SunPosition:
    """The sun's centre over a place, without refraction, by the algorithm of NOAA's calculator.

    Args:
        when: With its time zone.
        latitude_deg, longitude_deg: Of the place; north and east are positive.
    """
    observer = Observer(latitude_deg, longitude_deg)
    zenith, azimuth = zenith_and_azimuth(observer, when, with_refraction=False)
    return SunPosition(elevation_deg=90.0 - zenith, azimuth_deg=azimuth % 360.0)


def with_suns(found: SourceScene, settings: SceneSettings) -> SourceScene:
    """The scene with the sun of each photo whose moment and place are known, and notes of it.

    Args:
        found: What a reader found; photos whose sun it knows keep it.
        settings: The scene's entry, whose ``place`` stands in for what photos do not say.
    """
    place: Place | None = getattr(settings, "place", None)
    zone = None if place is None or place.time_zone is None else ZoneInfo(place.time_zone)
    views, without_zone, without_place = [], [], []
    for view in found.views:
        if view.sun is not None:
            views.append(view)
            continue
        told = metadata(read_exif_block(view.photo) if view.exif is None else view.exif)
        when = moment(view.path, told, zone)
        where = told.place
        if where is None and place is not None:
            where = (place.latitude_deg, place.longitude_deg)
        if when is not None and where is not None:
            view = replace(view, sun=sun_over(when, *where))
        elif when is None and where is not None and has_clock(view.path, told):
            without_zone.append(view.path)
        elif when is not None:
            without_place.append(view.path)
        views.append(view)
    notes = _notes(views, without_zone, without_place, found, place)
    return replace(found, views=tuple(views), notes=(*found.notes, *notes))


def _notes(
    views: list[SourceView],
    without_zone: list[str],
    without_place: list[str],
    found: SourceScene,
    place: Place | None,
) -> list[str]:
    """What was assumed, and what is missing where a time is known and the sun is not."""
    known = [
        view.path
        for view, before in zip(views, found.views, strict=True)
        if view.sun is not None and before.sun is None
    ]
    night = [view.path for view in views if view.sun is not None and view.sun.elevation_deg <= 0]
    notes = []
    if known:
        assumed = "" if place is None else f", assumed where photos do not say: {_said(place)}"
        notes.append(f"the sun of {len(known)} of {len(views)} photos is known by time{assumed}")
    if night:
        notes.append(
            f"by time and place the sun of {len(night)} photos is below the horizon, so that they "
            f"have none ({listed(night, 3)}); if that is wrong, so is their clock or time zone"
        )
    if without_zone:
        notes.append(
            f"{len(without_zone)} photos tell their time but no time zone, so their sun is learned "
            f"({listed(without_zone, 3)}); give the entry's place a time_zone"
        )
    if without_place:
        notes.append(
            f"{len(without_place)} photos tell their time but not their place, so their sun is "
            f"learned ({listed(without_place, 3)}); give the entry a place"
        )
    return notes


def _said(place: Place) -> str:
    values: Mapping[str, object] = place.model_dump(exclude_none=True)
    return ", ".join(f"{key} {value}" for key, value in values.items())
