"""COLMAP models that are damaged or say what cannot be: each gets its one sentence."""

import shutil
import struct

import numpy as np
import pytest
from support import dots

from r3gw.files import InputError
from r3gw.importing.settings import ColmapScene
from r3gw.importing.stage import import_scene
from r3gw.scene import load_points


def imported(folder):
    target = folder.parent / "scene"
    entry = ColmapScene(format="colmap", path=".")
    return import_scene("dots", entry, folder, target, num_threads=1), target


def edit(path, change):
    path.write_text(change(path.read_text()))


def words_of_first(folder, change):
    path = folder / "sparse" / "0" / "images.txt"
    lines = path.read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if line.endswith(".png"))
    lines[first] = " ".join(change(lines[first].split()))
    path.write_text("\n".join(lines) + "\n")


def scaled_quaternion(factor):
    def change(words):
        return [words[0], *(str(float(word) * factor) for word in words[1:5]), *words[5:]]

    return lambda folder: words_of_first(folder, change)


def camera_line(change):
    def damage(folder):
        path = folder / "sparse" / "0" / "cameras.txt"
        lines = path.read_text().splitlines()
        lines[-1] = " ".join(change(lines[-1].split()))
        path.write_text("\n".join(lines) + "\n")

    return damage


def latin_1(folder):
    path = folder / "sparse" / "0" / "images.txt"
    path.write_bytes(path.read_bytes().replace(b"photo_0", b"caf\xe9"))


def twice(folder):
    edit(folder / "sparse" / "0" / "images.txt", lambda t: t.replace("photo_1", "photo_0"))


def no_such_camera(words):
    return [*words[:8], "7", words[9]]


def not_rotation(words):
    return [words[0], "0", "0", "0", "0", *words[5:]]


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (scaled_quaternion(2.0), r"photo_0\.png: the pose's quaternion has the length 2 instead"),
        (lambda f: words_of_first(f, not_rotation), r"has the length 0 instead of 1"),
        (lambda f: words_of_first(f, lambda w: [*w[:5], "inf", *w[6:]]), r"holds NaN or infinity"),
        (lambda f: words_of_first(f, no_such_camera), r"its camera 7 is not in the model"),
        (lambda f: words_of_first(f, lambda w: w[:6]), r"images\.txt: line \d+ is damaged"),
        (lambda f: words_of_first(f, lambda w: [*w[:5], "1e300", *w[6:]]), r"1e\+300 units away"),
        (twice, r"photo_0\.png: is in the model twice"),
        (latin_1, r"images\.txt: line \d+ is not text in UTF-8 \(a photo's name in Latin-1\?\)"),
        (camera_line(lambda w: [w[0], "LOCUST", *w[2:]]), r"cameras\.txt: line \d+ is damaged"),
        (camera_line(lambda w: w[:-1]), r"the camera is PINHOLE with 3 parameters"),
        (camera_line(lambda w: [*w[:4], "nan", *w[5:]]), r"parameters hold NaN or infinity"),
        (camera_line(lambda w: [*w[:4], "-260", *w[5:]]), r"a focal length of -260 px cannot"),
        (camera_line(lambda w: [*w[:2], "0", *w[3:]]), r"the camera is 0x240 px"),
        (camera_line(lambda w: [*w[:2], "160", *w[3:]]), r"the photo is 320x240 px but its camera"),
        (camera_line(lambda w: [*w[:6], "1e5", w[7]]), r"principal point .* far outside"),
        (
            camera_line(lambda w: [w[0], "EQUIRECTANGULAR", *w[2:4], *w[2:4]]),
            r"a 360-degree picture\), which has no pinhole camera; split",
        ),
        (
            lambda f: edit(f / "sparse" / "0" / "points3D.txt", lambda t: t.replace("200", "x")),
            r"points3D\.txt: line \d+ is damaged",
        ),
    ],
)  # fmt: skip
def test_damaged_text_gets_one_sentence(tmp_path, damage, sentence):
    dots.colmap(tmp_path / "colmap")
    damage(tmp_path / "colmap")
    with pytest.raises(InputError, match=sentence) as caught:
        imported(tmp_path / "colmap")
    assert "\n" not in str(caught.value)


def test_rounded_quaternions_are_normalised(tmp_path):
    dots.colmap(tmp_path / "colmap")
    scaled_quaternion(1.004)(tmp_path / "colmap")
    scene, target = imported(tmp_path / "colmap")
    for view in scene.views:
        turn = np.array(view.cam_from_world)[:3, :3]
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), rtol=0, atol=1e-12)
    xyz = load_points(target).xyz.astype(np.float64)
    assert max(dots.errors_px(scene, xyz, target)) < 0.5


def bytes_of(name, change):
    def damage(folder):
        path = folder / "sparse" / "0" / f"{name}.bin"
        path.write_bytes(change(path.read_bytes()))

    return damage


HUGE = struct.pack("<Q", 1 << 60)


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (bytes_of("cameras", lambda b: b[:12] + b"\x63" + b[13:]), r"has the model number 99"),
        (bytes_of("cameras", lambda b: b[:12] + b"\xff\xff\xff\xff" + b[16:]), r"number -1"),
        # FULL_OPENCV has three times the parameters that are there.
        (bytes_of("cameras", lambda b: b[:12] + b"\x06" + b[13:]), r"cameras\.bin: .*cut off"),
        (bytes_of("images", lambda b: b.replace(b"photo_0", b"caf\xe9__0")), r"is not UTF-8"),
        (bytes_of("images", lambda b: HUGE + b[8:]), r"images\.bin: .*damaged or cut off"),
        (bytes_of("points3D", lambda b: HUGE + b[8:]), r"points3D\.bin: .*damaged or cut off"),
        (bytes_of("points3D", lambda b: b[:-1]), r"points3D\.bin: .*damaged or cut off"),
        (bytes_of("images", lambda _b: b""), r"images\.bin: .*cut off \(0 bytes\)"),
    ],
)
def test_damaged_binary_gets_one_sentence(tmp_path, damage, sentence):
    dots.colmap(tmp_path / "colmap", text=False)
    damage(tmp_path / "colmap")
    with pytest.raises(InputError, match=sentence) as caught:
        imported(tmp_path / "colmap")
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_whole_files_that_random_bytes_hit_never_crash(tmp_path):
    """A few hundred of what `make fuzz` does at length."""
    dots.colmap(tmp_path / "colmap", text=False)
    whole = tmp_path / "colmap" / "sparse" / "0"
    rng = np.random.default_rng(0)
    refused = 0
    for name in ("cameras", "images", "points3D"):
        content = (whole / f"{name}.bin").read_bytes()
        for _ in range(60):
            damaged = bytearray(content)
            for position in rng.integers(0, len(content), rng.integers(1, 5)):
                damaged[position] = rng.integers(0, 256)
            (whole / f"{name}.bin").write_bytes(bytes(damaged))
            try:
                imported(tmp_path / "colmap")
            except InputError:
                refused += 1
        (whole / f"{name}.bin").write_bytes(content)
    assert refused > 60
    shutil.rmtree(tmp_path / "scene")
