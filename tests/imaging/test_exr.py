"""EXR: which channels mean RGB, against the arrays that the OpenEXR package wrote."""

import numpy as np
import OpenEXR
import pytest

from r3gw.files import InputError
from r3gw.imaging.exr import write_exr
from r3gw.imaging.files import read_linear
from r3gw.lighting.envmap import read_env_map

RNG = np.random.default_rng(0)
R, G, B, A = (RNG.random((8, 16), dtype=np.float32) for _ in range(4))
RGB = np.stack([R, G, B], axis=-1)
HEADER = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}


def exr(path, channels, **header):
    OpenEXR.File(HEADER | header, channels).write(str(path))
    return path


def layer(name):
    return {f"{name}.{letter}": plane for letter, plane in zip("RGB", (R, G, B), strict=True)}


@pytest.mark.parametrize(
    ("channels", "expected"),
    [
        ({"R": R, "G": G, "B": B}, RGB),
        ({"R": R, "G": G, "B": B, "A": A, "depth.Z": A, "id": np.ones((8, 16), np.uint32)}, RGB),
        ({"Y": R}, np.repeat(R[..., None], 3, axis=2)),
        ({"Y": R, "A": A}, np.repeat(R[..., None], 3, axis=2)),
        (layer("ViewLayer.Combined") | {"ViewLayer.Depth.Z": A}, RGB),
        ({"R": R, "G": G, "B": B} | layer("diffuse"), RGB),
        (layer("ViewLayer.Combined") | layer("ViewLayer.DiffCol"), RGB),
        (layer("View.Combined") | {f"View.Normal.{axis}": A for axis in "XYZ"}, RGB),
        ({"r": R, "g": G, "b": B}, RGB),
        ({"rgba.red": R, "rgba.green": G, "rgba.blue": B, "rgba.alpha": A}, RGB),
        ({"R": R.astype(np.float16), "G": G, "B": (B * 9).astype(np.uint32)}, None),
    ],
)
def test_channels_that_mean_rgb(tmp_path, channels, expected):
    if expected is None:
        planes = [channels[letter].astype(np.float32) for letter in "RGB"]
        expected = np.stack(planes, axis=-1)
    path = exr(tmp_path / "a.exr", channels)
    assert np.array_equal(read_linear(path), expected)
    assert np.array_equal(read_env_map(path).numpy(), expected)


@pytest.mark.parametrize(
    ("channels", "sentence"),
    [
        (layer("left") | layer("right"), r"channels \(left\.B.*right\.R\) make 2 pictures"),
        ({"Z": R}, r"its channels \(Z\) are no RGB picture; save it with channels R, G and B"),
        ({"X": R, "Y": G, "Z": B}, r"its channels \(X, Y, Z\) are no RGB picture"),
        (layer("A.Combined") | layer("B.Combined"), r"make 2 pictures"),
        ({"R": R, "G": G}, r"its channels \(G, R\) are no RGB picture"),
    ],
)
def test_channels_without_one_meaning(tmp_path, channels, sentence):
    with pytest.raises(InputError, match=sentence):
        read_linear(exr(tmp_path / "a.exr", channels))


def parts(path, **named):
    made = [
        OpenEXR.Part(HEADER | {"name": name}, channels, name) for name, channels in named.items()
    ]
    OpenEXR.File(made).write(str(path))
    return path


def test_parts(tmp_path):
    plain = {"R": R, "G": G, "B": B}
    path = parts(tmp_path / "a.exr", depth={"Z": A}, beauty=plain)
    assert np.array_equal(read_linear(path), RGB)
    path = parts(tmp_path / "b.exr", left=plain, right=plain)
    with pytest.raises(InputError, match=r"\(B, G, R in 2 parts\) make 2 pictures"):
        read_linear(path)


def test_cropped_and_overscanned_windows(tmp_path):
    def window(left, top, right, bottom):
        return (np.array([left, top], np.int32), np.array([right, bottom], np.int32))

    planes = {"R": R, "G": G, "B": B}
    crop = exr(
        tmp_path / "crop.exr",
        planes,
        dataWindow=window(10, 4, 25, 11),
        displayWindow=window(0, 0, 31, 15),
    )
    expected = np.zeros((16, 32, 3), np.float32)
    expected[4:12, 10:26] = RGB
    assert np.array_equal(read_linear(crop), expected)
    wide = exr(
        tmp_path / "wide.exr",
        planes,
        dataWindow=window(-3, -2, 12, 5),
        displayWindow=window(0, 0, 7, 3),
    )
    assert np.array_equal(read_linear(wide), RGB[2:6, 3:11])


@pytest.mark.parametrize("bad", [np.inf, -np.inf, np.nan])
def test_values_that_are_no_light(tmp_path, bad):
    image = RGB.copy()
    image[3, 5, 1] = bad
    write_exr(tmp_path / "a.exr", image)
    with pytest.raises(InputError, match=r"in 1 pixels, the first at column 5, row 3; repair"):
        read_linear(tmp_path / "a.exr")


def test_damaged_file(tmp_path):
    data = exr(tmp_path / "a.exr", {"RGB": RGB}).read_bytes()
    for share in (0.05, 0.3, 0.9):
        (tmp_path / "b.exr").write_bytes(data[: int(len(data) * share)])
        with pytest.raises(InputError, match=r"b\.exr: not a readable EXR picture"):
            read_linear(tmp_path / "b.exr")
    (tmp_path / "c.exr").write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(InputError, match=r"c\.exr: not a readable EXR picture"):
        read_linear(tmp_path / "c.exr")


def test_channel_names_that_are_no_text(tmp_path):
    path = exr(tmp_path / "a.exr", {"R": R, "G": G, "B": B, "Z": A})
    path.write_bytes(path.read_bytes().replace(b"Z\0", b"\xff\0"))
    with pytest.raises(InputError, match=r"a\.exr: not a readable EXR picture \(names of its"):
        read_linear(path)
