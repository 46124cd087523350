"""A folder's state changes with what is in it, and with nothing else."""

import os
import shutil

import pytest

from r3gw.pipeline.source_state import source_state


@pytest.fixture
def folder(tmp_path):
    photos = tmp_path / "photos"
    (photos / "sparse/0").mkdir(parents=True)
    (photos / "sparse/0/images.bin").write_bytes(b"model")
    (photos / "a.jpg").write_bytes(b"one")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "mask.png").write_bytes(b"mask")
    (photos / "masks").symlink_to(elsewhere)
    return photos


def touched(path):
    status = path.stat()
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns + 1))


CHANGES = {
    "a photo replaced by one of its size": lambda f: touched(f / "a.jpg"),
    "a longer photo of the same time": lambda f: _grown(f / "a.jpg"),
    "a photo more": lambda f: (f / "b.jpg").write_bytes(b"two"),
    "a photo less": lambda f: (f / "a.jpg").unlink(),
    "another name": lambda f: (f / "a.jpg").rename(f / "c.jpg"),
    "a file two folders down": lambda f: touched(f / "sparse/0/images.bin"),
    "a file behind a link": lambda f: touched(f / "masks/mask.png"),
    "the folder gone": shutil.rmtree,
}


def _grown(path):
    status = path.stat()
    path.write_bytes(path.read_bytes() + b"!")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_of_the_data_changes_the_state(folder, change):
    before = source_state(folder)
    CHANGES[change](folder)
    assert source_state(folder) != before


def test_what_is_no_data_changes_nothing(folder):
    before = source_state(folder, [folder / "results"])
    (folder / ".DS_Store").write_bytes(b"desktop")
    (folder / "Thumbs.db").write_bytes(b"desktop")
    (folder / "@eaDir").mkdir()
    (folder / "@eaDir/a.jpg").write_bytes(b"thumbnail")
    (folder / "results").mkdir()
    (folder / "results/table1.csv").write_text("ours")
    assert source_state(folder, [folder / "results"]) == before


def test_links_in_a_circle_or_to_nowhere_end(folder):
    (folder / "sparse/again").symlink_to(folder)
    (folder / "gone.jpg").symlink_to(folder / "nowhere")
    before = source_state(folder)
    assert source_state(folder) == before
    (folder / "gone.jpg").unlink()
    assert source_state(folder) != before


def test_a_file_alone_has_a_state(folder):
    video = folder / "a.jpg"
    before = source_state(video)
    assert before == source_state(video)
    touched(video)
    assert source_state(video) != before


@pytest.mark.parametrize("name", ["a b", "it's", "{scene}", "$HOME", "*", "(1)", "é", b"\xff.jpg"])
def test_names_of_every_kind_count(folder, name):
    before = source_state(folder)
    with open(os.path.join(os.fsencode(folder), os.fsencode(name)), "wb"):  # noqa: PTH118, PTH123
        pass
    assert source_state(folder) != before
