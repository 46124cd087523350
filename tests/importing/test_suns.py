"""The sun over a photo: its place in the sky by other algorithms, its moment by EXIF and name."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
import torch
from PIL import Image

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.imaging.exif import read_exif_block
from r3gw.importing.clock import Metadata, metadata, moment
from r3gw.importing.settings import parse_scene
from r3gw.importing.source import SourcePoints, SourceScene, SourceView
from r3gw.importing.suns import sun_over, with_suns

SAARBRUECKEN = {"latitude_deg": 49.23, "longitude_deg": 6.99, "time_zone": "Europe/Berlin"}


@pytest.mark.parametrize(
    ("when", "place", "elevation", "azimuth"),
    [
        # The worked example of Reda and Andreas (2004), without its refraction.
        ("2003-10-17T12:30:30-07:00", (39.742476, -105.1786), 39.8720, 194.3402),
        # NREL's algorithm as in pvlib 0.16.1.
        ("2020-08-01T07:30:00+02:00", (49.23, 6.99), 12.1170, 76.5785),
        ("2021-12-21T15:00:00+00:00", (-33.9, 18.4), 33.8820, 262.7634),
        ("2023-06-21T23:30:00+09:00", (35.7, 139.7), -30.7837, 356.5295),
        ("2024-02-29T12:00:00-05:00", (40.7, -74.0), 41.6662, 177.2282),
    ],
)
def test_the_sun_stands_where_other_algorithms_put_it(when, place, elevation, azimuth):
    found = sun_over(datetime.fromisoformat(when), *place)
    assert found.elevation_deg == pytest.approx(elevation, rel=0, abs=0.03)
    assert found.azimuth_deg == pytest.approx(azimuth, rel=0, abs=0.03)


def test_another_year_hardly_matters():
    """For names that tell day and month alone."""
    suns = [sun_over(datetime(y, 3, 21, 9, tzinfo=UTC), 49.23, 6.99) for y in range(2018, 2024)]
    assert np.ptp([sun.elevation_deg for sun in suns]) < 0.5
    assert np.ptp([sun.azimuth_deg for sun in suns]) < 0.5


def exif(**fields) -> bytes:
    """An EXIF block with a clock, an offset, and the satellites' time and place."""
    made = Image.Exif()
    own, gps = made.get_ifd(0x8769), made.get_ifd(0x8825)
    if "clock" in fields:
        own[0x9003] = fields["clock"]
    if "offset" in fields:
        own[0x9011] = fields["offset"]
    if "place" in fields:
        south, west = fields.get("sides", ("N", "E"))
        (gps[1], gps[2]), (gps[3], gps[4]) = zip((south, west), fields["place"], strict=True)
    if "satellite" in fields:
        gps[29], gps[7] = fields["satellite"]
    made[0x010F] = "maker"
    return made.tobytes()


def test_exif_is_read_as_it_is_meant():
    found = metadata(
        exif(
            clock="2021:12:21 17:00:00",
            offset="+02:00",
            place=((33.0, 54.0, 0.0), (18.0, 24.0, 0.0)),
            sides=("S", "E"),
            satellite=("2021:12:21", (15.0, 0.0, 30.0)),
        )
    )
    assert found.clock == datetime(2021, 12, 21, 17)
    assert found.offset == timedelta(hours=2)
    assert found.place == pytest.approx((-33.9, 18.4), rel=0, abs=1e-9)
    assert found.satellite == datetime(2021, 12, 21, 15, 0, 30, tzinfo=UTC)


@pytest.mark.parametrize(
    "block",
    [
        b"",
        b"Exif\0\0garbage",
        exif(clock="0000:00:00 00:00:00", offset="nowhere"),
        exif(clock="yesterday", satellite=("2021:13:40", (1.0, 2.0, 3.0))),
        exif(place=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))),
        exif(place=((49.0, 0.0, 0.0), (7.0, 0.0, 0.0)), sides=("?", "E")),
        exif(place=((149.0, 0.0, 0.0), (7.0, 0.0, 0.0))),
    ],
)
def test_what_exif_does_not_tell_is_unknown(block):
    assert metadata(block) == Metadata()


def test_the_moment_is_the_surest_one():
    from zoneinfo import ZoneInfo

    zone = ZoneInfo("Europe/Berlin")
    clock, satellite = datetime(2019, 7, 1, 12), datetime(2019, 7, 1, 9, tzinfo=UTC)
    offset = timedelta(hours=1)
    everything = Metadata(clock, offset, satellite)
    named = "site/01-08_07_30_IMG_6710.jpg"
    summer = datetime(2020, 8, 1, 5, 30, tzinfo=UTC)  # clocks of Berlin are two hours ahead
    assert moment(named, everything, zone) == summer
    assert moment(named, everything, None) == clock.replace(tzinfo=timezone(offset))
    assert moment("a.jpg", everything, zone) == clock.replace(tzinfo=timezone(offset))
    assert moment("a.jpg", Metadata(clock, None, satellite), zone) == satellite
    assert moment("a.jpg", Metadata(clock), zone) == clock.replace(tzinfo=zone)
    assert moment("a.jpg", Metadata(clock), None) is None
    assert moment("29-02_12_00_a.jpg", Metadata(), zone) is not None
    assert moment("31-02_12_00_a.jpg", Metadata(), zone) is None


def scene_of(tmp_path, blocks: dict[str, bytes]) -> SourceScene:
    """Photos with EXIF blocks, all from one place in space."""
    camera = Camera(torch.eye(4, dtype=torch.float64), (50.0, 50.0, 4.0, 3.0), 8, 6)
    views = []
    for name, block in blocks.items():
        path = tmp_path / name
        Image.fromarray(np.zeros((6, 8, 3), np.uint8)).save(path, exif=block)
        views.append(SourceView(name, path, camera, "train"))
    return SourceScene(tuple(views), SourcePoints(np.zeros((1, 3)), np.zeros((1, 3), np.uint8)))


BERLIN = ((52.0, 30.0, 0.0), (13.0, 24.0, 0.0))


def test_photos_get_their_suns_and_notes_say_what_is_missing(tmp_path):
    found = scene_of(
        tmp_path,
        {
            "whole.jpg": exif(clock="2022:06:21 13:00:00", offset="+02:00", place=BERLIN),
            "night.jpg": exif(clock="2022:06:21 01:00:00", offset="+02:00", place=BERLIN),
            "zoneless.jpg": exif(clock="2022:06:21 13:00:00", place=BERLIN),
            "placeless.jpg": exif(clock="2022:06:21 13:00:00", offset="+02:00"),
            "silent.jpg": b"",
        },
    )
    assert read_exif_block(found.views[0].photo)
    settings = parse_scene({"format": "colmap", "path": "."}, "test")
    made = with_suns(found, settings)
    whole, night, *others = [view.sun for view in made.views]
    # Noon of the longest day: 90 - 52.5 + 23.44 degrees, a little east of south.
    assert whole.elevation_deg == pytest.approx(60.9, rel=0, abs=0.2)
    assert night.elevation_deg < 0
    assert others == [None, None, None]
    notes = "\n".join(made.notes)
    for said in ("2 of 5 photos", "below the horizon", "(night.jpg)", "no time zone", "zoneless"):
        assert said in notes
    assert "their place" in notes
    assert "placeless" in notes
    assert "silent" not in notes


def test_the_entry_stands_in_for_what_photos_do_not_say(tmp_path):
    found = scene_of(
        tmp_path,
        {
            "01-08_07_30_IMG_6710.jpg": b"",
            "zoneless.jpg": exif(clock="2020:08:01 07:30:00", place=BERLIN),
        },
    )
    settings = parse_scene({"format": "nerf-osr", "path": ".", "place": SAARBRUECKEN}, "test")
    made = with_suns(found, settings)
    named, berlin = (view.sun for view in made.views)
    assert named.elevation_deg == pytest.approx(12.117, rel=0, abs=0.03)
    assert named.azimuth_deg == pytest.approx(76.5785, rel=0, abs=0.03)
    # The photo's own place comes before the entry's: further east, the sun is higher.
    assert berlin.elevation_deg > named.elevation_deg + 2
    assert "latitude_deg 49.23" in made.notes[0]
    assert "Europe/Berlin" in made.notes[0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"time_zone": "Saarland"}, "'Saarland' is no time zone; write a name such as"),
        ({"latitude_deg": 149.0}, "place.latitude_deg"),
    ],
)
def test_a_place_that_is_none_is_refused_in_one_sentence(change, said):
    entry = {"format": "colmap", "path": ".", "place": SAARBRUECKEN | change}
    with pytest.raises(InputError) as error:
        parse_scene(entry, "config.yaml")
    assert said in str(error.value)
    assert "\n" not in str(error.value)
