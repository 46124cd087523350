"""When and where a photo was taken, from its EXIF or its name.

A moment is known only with its time zone. EXIF tells it by an offset or by the satellites' own
time; else the entry of the scene must name the zone that the clocks were set to. A name of
NeRF-OSR's kind (``dd-mm_hh_mm_...``) has day, month and clock time; its year does not matter,
because on the same day of another year the sun stands within half a degree of where it did.
"""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta, timezone
from typing import Any
from zoneinfo import ZoneInfo

from PIL import Image

from r3gw.importing.folders import session_of

NAMES_YEAR = 2020  # a leap year: the 29th of February is a day, too
_EXIF_IFD, _GPS_IFD = 0x8769, 0x8825
_TAKEN, _OFFSET = 0x9003, 0x9011  # DateTimeOriginal, OffsetTimeOriginal
_LATITUDE, _LONGITUDE, _GPS_TIME, _GPS_DATE = (1, 2), (3, 4), 7, 29


@dataclass(frozen=True)
class Metadata:
    """What a photo's EXIF tells of when and where it was taken.

    Attributes:
        clock: What the camera's clock showed.
        offset: Of that clock from UTC.
        satellite: UTC by the satellites.
        place: Latitude and longitude in degrees.
    """

    clock: datetime | None = None
    offset: timedelta | None = None
    satellite: datetime | None = None
    place: tuple[float, float] | None = None


def metadata(exif: bytes) -> Metadata:
    """Read an EXIF block; what is missing or malformed is None."""
    if not exif:
        return Metadata()
    fields = Image.Exif()
    try:
        fields.load(exif)
        own, gps = fields.get_ifd(_EXIF_IFD), fields.get_ifd(_GPS_IFD)
    except Exception:  # broken EXIF does not make a photo unreadable, and raises anything
        return Metadata()
    return Metadata(
        _clock(own.get(_TAKEN)), _offset(own.get(_OFFSET)), _satellite(gps), _place(gps)
    )


def moment(photo: str, found: Metadata, zone: ZoneInfo | None) -> datetime | None:
    """When a photo was taken, with its time zone; None where that is not known.

    The time in a photo's name comes first: who writes it there, with a time zone in the scene's
    entry, means it. Then the camera's clock with its own offset, then the satellites' time, then
    the camera's clock in the entry's zone.

    Args:
        photo: The photo's path.
        found: What its EXIF tells.
        zone: Time zone of clocks that do not say it themselves.
    """
    named = _named(photo)
    if named is not None and zone is not None:
        return named.replace(tzinfo=zone)
    if found.clock is not None and found.offset is not None:
        return found.clock.replace(tzinfo=timezone(found.offset))
    if found.satellite is not None:
        return found.satellite
    if found.clock is not None and zone is not None:
        return found.clock.replace(tzinfo=zone)
    return None


def has_clock(photo: str, found: Metadata) -> bool:
    """Whether anything says what time it was, in whatever time zone."""
    return _named(photo) is not None or found.clock is not None or found.satellite is not None


def _named(photo: str) -> datetime | None:
    session = session_of(photo)
    if session is None:
        return None
    try:
        return datetime.strptime(f"{NAMES_YEAR} {session}", "%Y %d-%m_%H_%M")
    except ValueError:  # looks like a date and is none
        return None


def _clock(text: Any) -> datetime | None:
    try:
        return datetime.strptime(str(text).strip("\0 "), "%Y:%m:%d %H:%M:%S")
    except ValueError:
        return None


def _offset(text: Any) -> timedelta | None:
    try:
        return datetime.strptime(str(text).strip("\0 "), "%z").utcoffset()
    except ValueError:
        return None


def _satellite(gps: dict[int, Any]) -> datetime | None:
    try:
        hours, minutes, seconds = (float(part) for part in gps[_GPS_TIME])
        day = datetime.strptime(str(gps[_GPS_DATE]).strip("\0 "), "%Y:%m:%d").replace(tzinfo=UTC)
        return day + timedelta(hours=hours, minutes=minutes, seconds=seconds)
    except (KeyError, TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None


def _place(gps: dict[int, Any]) -> tuple[float, float] | None:
    try:
        latitude, longitude = (_degrees(gps, *tags) for tags in (_LATITUDE, _LONGITUDE))
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        return None
    # A receiver without a fix writes zeros.
    is_one = abs(latitude) <= 90 and abs(longitude) <= 180 and (latitude, longitude) != (0, 0)
    return (latitude, longitude) if is_one else None


def _degrees(gps: dict[int, Any], side_tag: int, value_tag: int) -> float:
    degrees, minutes, seconds = (float(part) for part in gps[value_tag])
    value = degrees + minutes / 60 + seconds / 3600
    side = str(gps[side_tag]).strip("\0 ").upper()
    if side not in ("N", "S", "E", "W"):
        raise ValueError(side)
    return -value if side in "SW" else value
