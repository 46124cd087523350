"""Photos of every format against the arrays that they were made from, by Pillow and OpenCV."""

import io
import struct
import time
import zlib

import cv2
import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageOps
from support import heic

from r3gw.files import InputError
from r3gw.imaging.decode import read_picture
from r3gw.imaging.files import read_grey, read_rgb, read_rgb_as_stored
from r3gw.imaging.formats import MOST_PIXELS
from r3gw.imaging.orientation import stored_from_upright, upright_from_stored

RED, GREEN, BLUE, GREY = (220, 40, 40), (40, 220, 40), (40, 40, 220), (200, 200, 200)


def quarters():
    image = np.empty((32, 64, 3), np.uint8)
    image[:16, :32], image[:16, 32:], image[16:, :32], image[16:, 32:] = RED, GREEN, BLUE, GREY
    return image


def save(path, image, form, **options):
    Image.fromarray(image).save(path, form, **options)
    return path


@pytest.mark.parametrize(
    ("name", "form", "options", "off_by"),
    [
        ("a.PNG", "PNG", {}, 0),
        ("a.JPG", "JPEG", {"quality": 95, "subsampling": 0}, 3),
        ("a.jpe", "JPEG", {"quality": 95, "subsampling": 0}, 3),
        ("a.jfif", "JPEG", {"quality": 95, "subsampling": 0, "progressive": True}, 3),
        ("a.TIFF", "TIFF", {}, 0),
        ("a.tif", "TIFF", {"compression": "tiff_lzw"}, 0),
        ("a.webp", "WEBP", {"lossless": True}, 0),
        ("a.avif", "AVIF", {"quality": 95, "subsampling": "4:4:4"}, 4),
        ("a.bmp", "BMP", {}, 0),
        ("webp_called.png", "WEBP", {"lossless": True}, 0),
        ("png_called.jpg", "PNG", {}, 0),
        ("jpeg_called.heic", "JPEG", {"quality": 95, "subsampling": 0}, 3),
    ],
)
def test_formats_are_read_by_their_contents(tmp_path, name, form, options, off_by):
    path = save(tmp_path / name, quarters(), form, **options)
    assert np.abs(read_rgb(path).astype(int) - quarters()).max() <= off_by


def test_heic_is_turned_once(tmp_path):
    path = tmp_path / "IMG_0001.HEIC"
    path.write_bytes(heic.TURNED)
    # A quarter turn to the right: the left column becomes the upper row, blue before red.
    expected = np.rot90(quarters(), -1)
    for read in (read_rgb, read_rgb_as_stored):
        assert np.abs(read(path).astype(int) - expected)[4:-4:4, 4:-4:4].max() <= 6
    assert read_picture(path).orientation == 1
    assert read_picture(path).exif  # with its focal length


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize(("name", "form"), [("a.jpg", "JPEG"), ("a.tif", "TIFF"), ("a.png", "PNG")])
def test_orientation(tmp_path, orientation, name, form):
    exif = Image.Exif()
    exif[0x0112] = orientation
    options = {"quality": 95, "subsampling": 0} if form == "JPEG" else {}
    path = save(tmp_path / name, quarters(), form, exif=exif, **options)
    with Image.open(path) as image:
        image.load()  # before the transposition, for which a TIFF has nothing left to do
        expected = np.asarray(ImageOps.exif_transpose(image).convert("RGB")).astype(int)
    assert np.abs(read_rgb(path).astype(int) - expected).max() <= 3
    assert np.abs(read_rgb_as_stored(path).astype(int) - quarters()).max() <= 3
    turned = upright_from_stored(quarters(), orientation)
    assert np.array_equal(stored_from_upright(turned, orientation), quarters())


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_sixteen_bits_keep_their_scale(tmp_path, suffix):
    deep = np.random.default_rng(0).integers(0, 65536, (9, 11, 3), dtype=np.uint16)
    deep[0, 0], deep[0, 1] = 65535, 0
    cv2.imwrite(str(tmp_path / f"c{suffix}"), deep[..., ::-1])
    cv2.imwrite(str(tmp_path / f"g{suffix}"), deep[..., 0])
    expected = np.rint(deep / 257.0)
    assert np.array_equal(read_rgb(tmp_path / f"c{suffix}"), expected)
    assert np.array_equal(read_grey(tmp_path / f"g{suffix}"), expected[..., 0])
    assert np.array_equal(read_picture(tmp_path / f"c{suffix}").pixels, deep)


def test_rare_colour_models(tmp_path):
    image = Image.fromarray(quarters())
    image.convert("L").save(tmp_path / "grey.jpg", quality=95)
    image.convert("CMYK").save(tmp_path / "cmyk.jpg", quality=95, subsampling=0)
    image.quantize(4).save(tmp_path / "palette.png")
    image.convert("1", dither=Image.Dither.NONE).save(tmp_path / "bits.png")
    grey = np.asarray(image.convert("L"), int)
    assert np.abs(read_rgb(tmp_path / "grey.jpg") - grey[..., None]).max() <= 2
    assert np.abs(read_rgb(tmp_path / "cmyk.jpg").astype(int) - quarters()).max() <= 6
    assert np.array_equal(read_rgb(tmp_path / "palette.png"), quarters())
    assert set(np.unique(read_grey(tmp_path / "bits.png"))) == {0, 255}


def test_transparency(tmp_path):
    alpha = np.zeros((32, 64), np.uint8)
    alpha[:, :48], alpha[0, 0], alpha[0, 1] = 255, 127, 128
    save(tmp_path / "a.png", np.dstack([quarters(), alpha]), "PNG")
    picture = read_picture(tmp_path / "a.png")
    assert np.array_equal(picture.is_opaque, alpha >= 128)
    assert np.array_equal(picture.pixels, quarters())
    (tmp_path / "b.heic").write_bytes(heic.TRANSPARENT)
    assert np.array_equal(read_picture(tmp_path / "b.heic").is_opaque[:, ::8], alpha[:, ::8] > 0)
    save(tmp_path / "c.png", np.dstack([quarters(), np.full((32, 64), 255, np.uint8)]), "PNG")
    assert read_picture(tmp_path / "c.png").is_opaque is None
    palette = Image.fromarray(quarters()).quantize(4)
    palette.save(tmp_path / "d.png", transparency=palette.getpixel((0, 0)))
    is_red = (quarters() == RED).all(axis=2)
    assert np.array_equal(read_picture(tmp_path / "d.png").is_opaque, ~is_red)


def test_animations_and_pages_are_refused(tmp_path):
    frames = [Image.new("RGB", (20, 10), colour) for colour in ("red", "blue", "white")]
    for frame, x in zip(frames, (1, 5, 9), strict=True):
        ImageDraw.Draw(frame).point((x, 2), "black")
    for name in ("a.webp", "a.png", "a.gif", "a.tif"):
        frames[0].save(tmp_path / name, save_all=True, append_images=frames[1:])
        # A GIF that is called PNG is an animation all the same.
        path = (tmp_path / name).rename(tmp_path / name.replace(".gif", "_gif.png"))
        with pytest.raises(InputError, match=rf"{path.name}: holds 3 pictures"):
            read_picture(path)


def test_raw_is_refused_by_name_of_the_cure(tmp_path):
    tags = {50706: b"\x01\x04\x00\x00", 254: 1}
    for tag, value in tags.items():
        image = Image.fromarray(quarters())
        image.save(tmp_path / "raw.tif", tiffinfo={tag: value})
        with pytest.raises(InputError, match=r"is undeveloped \(RAW\); develop it to JPEG, PNG"):
            read_picture(tmp_path / "raw.tif")


@pytest.mark.parametrize("form", ["PNG", "TIFF", "WEBP", "AVIF", "JPEG", "BMP"])
@pytest.mark.parametrize("share", [0.02, 0.4, 0.8])
def test_truncated_files_are_refused(tmp_path, form, share):
    noise = np.random.default_rng(3).integers(0, 255, (48, 64, 3), dtype=np.uint8)
    buffer = io.BytesIO()
    Image.fromarray(noise).save(buffer, form)
    path = tmp_path / "a.jpg"
    path.write_bytes(buffer.getvalue()[: int(len(buffer.getvalue()) * share)])
    with pytest.raises(InputError, match=r"a\.jpg: not a readable picture"):
        read_picture(path)


def png_of_size(width, height, depth=8, colour=2):
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    data = zlib.compress(bytes(1000))
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    )


def test_the_best_compressed_pictures_are_no_bombs(tmp_path):
    for mode in ("1", "L", "RGB", "RGBA"):
        Image.new(mode, (3000, 2000)).save(tmp_path / "plain.png", optimize=True)
        assert read_rgb(tmp_path / "plain.png").shape == (2000, 3000, 3)


def test_a_height_that_the_pixels_do_not_fill_is_refused(tmp_path):
    path = tmp_path / "tall.png"
    data = io.BytesIO()
    Image.fromarray(quarters()).save(data, "PNG")
    header = struct.pack(">IIBBBBB", 64, 2_000_000, 8, 2, 0, 0, 0)
    body = b"IHDR" + header
    path.write_bytes(
        data.getvalue()[:12] + body + struct.pack(">I", zlib.crc32(body)) + data.getvalue()[33:]
    )
    with pytest.raises(InputError, match=r"bytes cannot hold 64x2000000 px"):
        read_picture(path)


@pytest.mark.parametrize("size", [(100_000, 100_000), (1 << 20, 200), (13_400, 13_400)])
def test_small_file_of_a_huge_picture_is_refused_fast(tmp_path, size):
    path = tmp_path / "bomb.png"
    path.write_bytes(png_of_size(*size))
    begin = time.perf_counter()
    with pytest.raises(InputError, match=r"bomb\.png: (claims more than 178|not a readable)"):
        read_picture(path)
    assert time.perf_counter() - begin < 2.0
    assert MOST_PIXELS == 2 * Image.MAX_IMAGE_PIXELS


def test_bomb_inside_the_limit_is_refused_fast(tmp_path):
    # 13,000 x 13,000 px in 16 bits RGBA: 1.35 GB from a kilobyte, which took 13 s once.
    path = tmp_path / "bomb.png"
    path.write_bytes(png_of_size(13_000, 13_000, 16, 6))
    begin = time.perf_counter()
    with pytest.raises(InputError, match=r"not a readable picture"):
        read_picture(path)
    assert time.perf_counter() - begin < 2.0


def test_a_heic_that_ends_its_decoder_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.heic"
    path.write_bytes(heic.TURNED)
    monkeypatch.setattr("r3gw.imaging.heic._CHILD", "import os; os.abort()")
    with pytest.raises(InputError, match=r"a\.heic: not a readable picture .*its decoder gave up"):
        read_picture(path)
    monkeypatch.undo()
    path.write_bytes(heic.TURNED[:500])
    with pytest.raises(InputError, match=r"a\.heic: not a readable picture"):
        read_picture(path)


def test_altered_pixels_of_a_png_are_refused_and_altered_words_are_not(tmp_path):
    """Random pixels are stored nearly as they are, so that inflating them may well succeed."""
    noise = np.random.default_rng(0).integers(0, 256, (64, 64, 3)).astype(np.uint8)
    stream = io.BytesIO()
    Image.fromarray(noise).save(stream, "PNG")
    path = tmp_path / "a.png"
    data = stream.getvalue()
    middle = len(data) // 2
    path.write_bytes(data[:middle] + bytes(20) + data[middle + 20 :])
    with pytest.raises(
        InputError, match=r"a\.png: not a readable .*: its checksums do not fit its pixels; "
    ):
        read_picture(path)
    end = data.index(b"\x00\x00\x00\x00IEND")
    path.write_bytes(data[:end] + b"\x00\x00\x00\x03tEXta\x00bXXXX" + data[end:])
    assert np.array_equal(read_rgb(path), noise)


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b"", r"is empty \(0 bytes\).*; copy it again"),
        (b"version https://git-lfs.github.com/spec/v1\n", r"pointer of Git LFS; .*'git lfs pull'"),
        (b"\n<!DOCTYPE html><html>404</html>", r"is a web page .*download"),
        (b"%PDF-1.7", r"is a PDF; export"),
        (b"8BPS\x00\x01", r"Photoshop document; export"),
        (b"\x00\x00\x00\x0cjP  \r\n", r"is JPEG 2000; convert"),
        (b"no picture at all", r"not a readable picture .*; copy it again"),
    ],
)
def test_what_is_no_picture_is_called_by_its_name(tmp_path, data, sentence):
    path = tmp_path / "a.jpg"
    path.write_bytes(data)
    with pytest.raises(InputError, match=rf"a\.jpg: .*{sentence}"):
        read_picture(path)


def test_float_colours_are_refused_as_such(tmp_path):
    cv2.imwrite(str(tmp_path / "a.tif"), np.full((8, 8, 3), 0.5, np.float32))
    with pytest.raises(InputError, match=r"a\.tif: holds float values; save photos with 8 or 16"):
        read_picture(tmp_path / "a.tif")


def test_a_chunk_that_claims_gigabytes_is_refused_fast(tmp_path):
    """OpenCV sets aside and clears what a chunk claims, which takes seconds."""
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), np.zeros((12, 16, 3), np.uint16))
    data = path.read_bytes()
    end = data.index(b"IEND") - 4
    path.write_bytes(data[:end] + b"\x7f\xff\xff\x00tEXt" + data[end:])
    begin = time.perf_counter()
    with pytest.raises(InputError, match=r"a chunk of 2147483392 bytes is longer than the file"):
        read_picture(path)
    assert time.perf_counter() - begin < 2.0
