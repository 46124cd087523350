"""Radiance pictures against OpenCV where it reads them, and against arrays where it does not."""

import cv2
import numpy as np
import pytest

from r3gw.files import InputError
from r3gw.imaging.files import read_linear

RNG = np.random.default_rng(5)


def pixels(height, width):
    """RGBE with runs, gaps and noise; exponents around one."""
    rgbe = RNG.integers(2, 256, (height, width, 4), dtype=np.uint8)
    rgbe[..., 3] = RNG.integers(120, 140, (height, width))
    rgbe[:, width // 4 : width // 2] = rgbe[:, width // 4 : width // 4 + 1]
    rgbe[0, 0, 3] = 0
    return rgbe


def linear(rgbe):
    return rgbe[..., :3] * np.where(rgbe[..., 3:] > 0, 2.0 ** (rgbe[..., 3:] - 136.0), 0.0)


def write(path, rows, size, magic="#?RADIANCE", form="32-bit_rle_rgbe"):
    header = f"{magic}\n# a comment\nSOFTWARE=test\nFORMAT={form}\n\n{size}\n"
    path.write_bytes(header.encode() + rows)
    return path


def old_runs(rgbe):
    """Repeats of whole pixels as 1 1 1 n, longer ones with n shifted by 8 bits."""
    out = bytearray()
    for row in rgbe:
        x = 0
        while x < len(row):
            count = 1
            while x + count < len(row) and (row[x + count] == row[x]).all():
                count += 1
            out += row[x].tobytes()
            rest = count - 1
            while rest:
                out += bytes((1, 1, 1, rest & 255))
                rest >>= 8
            x += count
    return bytes(out)


@pytest.mark.parametrize("size", [(6, 12), (5, 300), (3, 7)])
def test_library_reads_the_same(tmp_path, size):
    light = RNG.random((*size, 3)).astype(np.float32) * 7
    light[:, 2:5] = light[:, 2:3]
    cv2.imwrite(str(tmp_path / "a.hdr"), light)
    expected = cv2.imread(str(tmp_path / "a.hdr"), cv2.IMREAD_ANYDEPTH | cv2.IMREAD_COLOR)
    assert np.array_equal(read_linear(tmp_path / "a.hdr"), expected[..., ::-1])


def test_flat_and_old_runs(tmp_path):
    rgbe = pixels(4, 900)
    for name, rows in (("flat", rgbe.tobytes()), ("old", old_runs(rgbe))):
        path = write(tmp_path / f"{name}.hdr", rows, "-Y 4 +X 900", magic="#?RGBE")
        np.testing.assert_allclose(read_linear(path), linear(rgbe), rtol=1e-6, atol=0)
    assert len(old_runs(rgbe)) < 0.8 * rgbe.nbytes


@pytest.mark.parametrize(
    ("size", "stored"),
    [
        ("-Y 6 +X 12", lambda image: image),
        ("+Y 6 +X 12", lambda image: image[::-1]),
        ("-Y 6 -X 12", lambda image: image[:, ::-1]),
        ("+Y 6 -X 12", lambda image: image[::-1, ::-1]),
        ("+X 12 -Y 6", lambda image: image.swapaxes(0, 1)),
        ("-X 12 -Y 6", lambda image: image.swapaxes(0, 1)[::-1]),
        ("+X 12 +Y 6", lambda image: image.swapaxes(0, 1)[:, ::-1]),
        ("-X 12 +Y 6", lambda image: image.swapaxes(0, 1)[::-1, ::-1]),
    ],
)
def test_orientations(tmp_path, size, stored):
    """A scanline runs along the second axis; +Y: the first scanline is the lowest row."""
    image = pixels(6, 12)
    path = write(tmp_path / "a.hdr", np.ascontiguousarray(stored(image)).tobytes(), size)
    np.testing.assert_allclose(read_linear(path), linear(image), rtol=1e-6, atol=0)


@pytest.mark.parametrize("magic", ["#?AUTOPANO", "#?RADIANCE\nFORMAT= 32-bit_rle_rgbe "])
def test_other_writers(tmp_path, magic):
    rgbe = pixels(4, 20)
    path = write(tmp_path / "a.hdr", rgbe.tobytes(), "-Y 4 +X 20", magic=magic)
    np.testing.assert_allclose(read_linear(path), linear(rgbe), rtol=1e-6, atol=0)


def test_damaged_files(tmp_path):
    rgbe = pixels(4, 20)
    good = write(tmp_path / "a.hdr", rgbe.tobytes(), "-Y 4 +X 20").read_bytes()
    cases = {
        "cut off": good[:-3],
        "no line of sizes": good.replace(b"-Y 4 +X 20", b"4 by 20"),
        "no line of sizes ": good.replace(b"-Y 4 +X 20", b"-Y 4 +Y 20"),
        "does not begin": good[1:],
        "its pixels are 32-bit_rle_xyze": good.replace(b"rgbe", b"xyze"),
        "claims 999999x999999 pixels": good.replace(b"-Y 4 +X 20", b"-Y 999999 +X 999999"),
        "another length than 20": good.replace(rgbe.tobytes()[:4], b"\x02\x02\x00\x09"),
        "an empty run": good.replace(rgbe.tobytes()[:8], b"\x02\x02\x00\x14\x00\x00\x00\x00"),
        "leaves its scanline": good.replace(
            rgbe.tobytes()[:8], b"\x02\x02\x00\x14\xff\x01\x01\x01"
        ),
    }
    for reason, data in cases.items():
        path = tmp_path / "b.hdr"
        path.write_bytes(data)
        with pytest.raises(InputError, match=f"not a readable Radiance picture .*{reason.strip()}"):
            read_linear(path)
