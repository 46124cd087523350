"""What lies in a folder of photos: every file is a picture, or is named with the reason."""

import cv2
import numpy as np
import pytest

from r3gw.files import InputError
from r3gw.importing.named_files import (
    notes_on,
    other_files,
    pictures_below,
    refuse_undeveloped,
)
from r3gw.importing.readers.photos import PhotosReader
from r3gw.importing.settings import PhotosScene


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "photos"
    for name in ("a.JPG", "b.HEIC", "deep/c.tiff", "raw/d.jpg", "masks/a.png", ".e.jpg"):
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(tmp_path / "any.png"), np.zeros((4, 4), np.uint8))
        (place / name).write_bytes((tmp_path / "any.png").read_bytes())
    return place


def test_links_are_followed_once(folder, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (folder / "a.JPG").rename(tmp_path / "elsewhere" / "a.JPG")
    (folder / "linked").symlink_to(tmp_path / "elsewhere")
    (folder / "again").symlink_to(folder)
    (folder / "f.webp").symlink_to(tmp_path / "elsewhere" / "a.JPG")
    found = set(pictures_below(folder, without=("masks",)))
    assert found == {"linked/a.JPG", "b.HEIC", "deep/c.tiff", "raw/d.jpg", "f.webp"}


def test_every_other_file_is_named(folder):
    for name in ("notes.txt", "b.MOV", "raw/d.CR2", "LICENSE", "a.gif"):
        (folder / name).write_bytes(b"x")
    (folder / "gone.jpg").symlink_to(folder / "nowhere.jpg")
    others = other_files(folder, without=("masks",))
    assert others == {
        "notes.txt": "no picture (.txt)",
        "b.MOV": "no picture (.mov)",
        "raw/d.CR2": "RAW beside its developed picture",
        "LICENSE": "no picture (without suffix)",
        "a.gif": "no picture (.gif)",
        "gone.jpg": "a link that leads nowhere",
    }
    (note,) = notes_on(others)
    assert note.startswith("6 files beside the photos not read: 1 RAW beside its developed picture")
    assert "b.MOV" in note
    facts = PhotosReader(PhotosScene(format="photos", path="."), folder).facts()
    assert facts == {"photos": "4", "left out": note}
    assert notes_on({}) == ()


def test_undeveloped_raw_is_refused(folder):
    (folder / "e.dng").write_bytes(b"x")
    with pytest.raises(InputError, match=r"one RAW file is among the photos \(e\.dng\); develop"):
        refuse_undeveloped(folder, other_files(folder))
    with pytest.raises(InputError, match=r"RAW"):
        PhotosReader(PhotosScene(format="photos", path="."), folder).facts()
