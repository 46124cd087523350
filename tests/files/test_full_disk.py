"""Full, read-only and refused: a sentence with the reason, and the files of before stay whole."""

import contextlib
import errno
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support import nerf_osr_layout

import r3gw.__main__ as command_line
from r3gw.files import InputError, atomic_path, sentence_of, write_bytes, write_json
from r3gw.files.npz import write_npz
from r3gw.files.ply import read_vertices, write_vertices
from r3gw.imaging.files import read_linear, read_rgb, write_exr, write_image
from r3gw.scene import load_scene

PAGE = 4096
PAGES = 96


@pytest.fixture
def small_disk(tmp_path_factory):
    """A file system of its own, of 384 KiB."""
    folder = tmp_path_factory.mktemp("disk")
    options = ["mount", "-t", "tmpfs", "-o", f"size={PAGES * PAGE}", "tmpfs", str(folder)]
    try:
        done = subprocess.run(options, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        pytest.skip("no mount command here")
    if done.returncode:
        pytest.skip(f"a small file system cannot be mounted here: {done.stderr.strip()}")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def fill(disk: Path, pages_left: int) -> None:
    """Leave room for a number of pages."""
    with (disk / "ballast").open("wb", buffering=0) as stream, contextlib.suppress(OSError):
        while True:
            stream.write(bytes(PAGE))
    keep = (disk / "ballast").stat().st_size - pages_left * PAGE
    os.truncate(disk / "ballast", max(0, keep))


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


RNG = np.random.default_rng(0)
RGB = RNG.integers(0, 256, (120, 160, 3), dtype=np.uint8)
LIGHT = RNG.random((60, 80, 3), dtype=np.float32)
ROWS = np.zeros(12_000, [("x", "<f4"), ("y", "<f4")])
ROWS["x"] = RNG.random(12_000)


def same_vertices(path):
    rows, _ = read_vertices(path)
    return rows.tobytes() == ROWS.tobytes()


WRITERS = {
    "a.png": (
        lambda path: write_image(path, RGB),
        lambda path: np.array_equal(read_rgb(path), RGB),
    ),
    "a.exr": (
        lambda path: write_exr(path, LIGHT),
        lambda path: np.array_equal(read_linear(path), LIGHT),
    ),
    "a.npz": (
        lambda path: write_npz(path, {"x": LIGHT}),
        lambda path: np.array_equal(np.load(path)["x"], LIGHT),
    ),
    "a.ply": (lambda path: write_vertices(path, ROWS, []), same_vertices),
    "a.json": (
        lambda path: write_json(path, ["x" * 80] * 600),
        lambda path: path.read_text().count("x") == 48_000,
    ),
}


def failure_of(write, path):
    try:
        write(path)
    except OSError as error:
        return sentence_of(error)
    return None


@pytest.mark.slow
@pytest.mark.parametrize("name", WRITERS)
def test_a_file_is_whole_or_not_there_at_every_fill_level(small_disk, name):
    write, is_whole = WRITERS[name]
    path, refused = small_disk / name, 0
    for pages_left in range(60):
        path.unlink(missing_ok=True)
        write_bytes(path, b"old")
        fill(small_disk, pages_left)
        sentence = failure_of(write, path)
        if sentence is None:
            assert is_whole(path)
        else:
            refused += 1
            assert path.read_bytes() == b"old"
            assert name in sentence
            assert "full" in sentence
        assert names_in(small_disk) == sorted([name, "ballast"])
        (small_disk / "ballast").unlink()
    path.unlink()
    assert 5 < refused < 60


def run(capsys, monkeypatch, *arguments):
    """Exit status and what stood on standard error, of the command in this process."""
    monkeypatch.setattr(sys, "argv", ["r3gw", *arguments])
    with pytest.raises(SystemExit) as stopped:
        command_line.main()
    # Progress bars go before the sentence, with carriage returns and a cursor that moves up.
    said = re.split(r"[\r\n]|\x1b\[A", capsys.readouterr().err.strip())
    return stopped.value.code, said[-1]


@pytest.mark.slow
def test_an_import_is_told_of_a_full_disk_and_repeated_when_there_is_room(
    small_disk, tmp_path, capsys, monkeypatch
):
    source = nerf_osr_layout.build(tmp_path / "place", points=8000).folder
    entry = '{"format": "nerf-osr", "path": "."}'
    target = small_disk / "scene"
    arguments = ["import", "--scene", "s", "--entry", entry, "--source", str(source)]
    arguments += ["--target", str(target)]
    refused = 0
    for pages_left in range(55):
        fill(small_disk, pages_left)
        status, sentence = run(capsys, monkeypatch, *arguments)
        if status:
            refused += 1
            assert status == 2
            assert sentence.startswith("r3gw: ")
            assert sentence.endswith("the disk is full; make room and run the command again")
            # scene.json comes last: without it nothing takes the folder for an imported scene.
            assert not (target / "scene.json").exists()
        else:
            assert load_scene(target).views
        (small_disk / "ballast").unlink()
    assert 20 < refused < 55
    assert run(capsys, monkeypatch, *arguments)[0] == 0
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    try:
        status, sentence = run(capsys, monkeypatch, *arguments)
        assert status == 2
        assert "the file system is read-only; choose another folder" in sentence
        assert load_scene(target).views
    finally:
        subprocess.run(["mount", "-o", "remount,rw", str(small_disk)], check=True)


def test_a_limit_on_the_size_of_files(tmp_path):
    write_bytes(tmp_path / "a.png", b"old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        for limit in range(1000, 50_000, 7000):
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
            with pytest.raises(OSError, match=r"a\.png") as caught:
                write_image(tmp_path / "a.png", RGB)
            assert "the file would be larger than is allowed here" in sentence_of(caught.value)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (tmp_path / "a.png").read_bytes() == b"old"
    assert names_in(tmp_path) == ["a.png"]


@pytest.mark.parametrize("number", [errno.EACCES, errno.EPERM, errno.EROFS, errno.EIO])
def test_a_refused_rename_leaves_the_old_file(tmp_path, monkeypatch, number):
    target = tmp_path / "a.txt"
    target.write_text("old")

    def refuse(self, _target):
        raise OSError(number, os.strerror(number), str(self))

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(OSError, match=r"a\.txt") as caught:
        write_bytes(target, b"new")
    assert sentence_of(caught.value).startswith(f"{target}: ")
    assert target.read_text() == "old"
    assert names_in(tmp_path) == ["a.txt"]


def test_a_file_cut_on_its_way_does_not_get_its_name(tmp_path, monkeypatch):
    """As on a network disk that takes more than it keeps."""
    write = Path.write_bytes
    monkeypatch.setattr(Path, "write_bytes", lambda path, data: write(path, data[:-1]))
    with pytest.raises(OSError, match=r"a\.bin: only 4 of 5 bytes were written"):
        write_bytes(tmp_path / "a.bin", b"12345")
    assert not list(tmp_path.iterdir())


def test_errors_of_other_files_keep_their_name(tmp_path):
    with (
        pytest.raises(FileNotFoundError, match=r"nowhere"),
        atomic_path(tmp_path / "a.txt"),
    ):
        (tmp_path / "nowhere").read_text()


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (OSError(errno.ENOSPC, "x", "/a/b.png"), "r3gw: /a/b.png: the disk is full; make room"),
        (OSError(errno.EDQUOT, "x", "/a"), "r3gw: /a: your quota on this disk is used up"),
        (PermissionError(errno.EACCES, "x", "/a"), "r3gw: /a: permission denied; change its"),
        (OSError(errno.EBUSY, "Device or resource busy", "/a"), "r3gw: /a: device or resource"),
        (OSError("a reason\nof a library"), "r3gw: a reason of a library"),
        (MemoryError(), "r3gw: there is not enough memory"),
        (InputError("bad"), "r3gw: bad"),
    ],
)
def test_the_command_ends_in_one_sentence(capsys, monkeypatch, error, sentence):
    def fail():
        raise error

    monkeypatch.setattr(command_line, "cli", fail)
    with pytest.raises(SystemExit) as stopped:
        command_line.main()
    assert stopped.value.code == 2
    printed = capsys.readouterr().err
    assert printed.startswith(sentence)
    assert printed.count("\n") == 1
