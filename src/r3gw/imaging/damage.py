"""What decoders pass over without a word: damaged data, and files that are no pictures at all."""

import zlib

_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
# How files begin that often stand under a picture's name, and what to do about each.
_INSTEAD = (
    (b"version https://git-lfs", "is a pointer of Git LFS; fetch the picture with 'git lfs pull'"),
    (b"<", "is a web page or drawing (HTML, SVG), no photo; download or export the picture again"),
    (b"%PDF", "is a PDF; export the picture as PNG or JPEG"),
    (b"8BPS", "is a Photoshop document; export it as PNG or JPEG"),
    (b"\x00\x00\x00\x0cjP  ", "is JPEG 2000; convert it to PNG"),
    (b"\xff\x0a", "is JPEG XL; convert it to PNG or JPEG"),
    (b"\x00\x00\x00\x0cJXL ", "is JPEG XL; convert it to PNG or JPEG"),
)


def unread_reason(data: bytes) -> str:
    """Why bytes that no decoder knows are no picture, and what to do, as the end of a sentence."""
    if not data:
        return "is empty (0 bytes), so not a readable picture; copy it again or remove it"
    start = data[:64].lstrip()
    for magic, reason in _INSTEAD:
        if data.startswith(magic) or start.startswith(magic):
            return reason
    return (
        "not a readable picture (truncated or of another format?); copy it again, convert it to "
        "PNG or remove it"
    )


def jpeg_is_whole(data: bytes) -> bool:
    """Whether a JPEG reaches its end marker; OpenCV fills a cut-off one with grey, without a word.

    Walks the segments to the start of the scan (ITU T.81, Annex B), so that neither a thumbnail
    before it nor data appended behind the picture counts.
    """
    position = 2
    while data[position : position + 2] not in (b"\xff\xda", b""):
        filler = data[position : position + 2] == b"\xff\xff"
        length = int.from_bytes(data[position + 2 : position + 4], "big")
        position += 1 if filler else 2 + length
    return data.find(b"\xff\xd9", position) >= 0


def refuse_altered_png(data: bytes) -> None:
    """Refuse a PNG with altered pixels, or a chunk for which OpenCV sets aside more than is there.

    Pillow does not look at the checksums of pixels. A wrong one of an ancillary chunk, such as a
    colour profile, spoils no pixel (W3C, PNG Specification, 5.3 and 5.4: capital letters mark
    critical chunks).

    Raises:
        ValueError: If a chunk is longer than the file, or the checksum of a critical one is wrong.
    """
    position = len(_PNG_MAGIC)
    view = memoryview(data)
    while position + 8 <= len(data):
        length = int.from_bytes(view[position : position + 4], "big")
        kind = bytes(view[position + 4 : position + 8])
        end = position + 8 + length
        if end + 4 > len(data):
            raise ValueError(f"a chunk of {length} bytes is longer than the file")
        stated = int.from_bytes(view[end : end + 4], "big")
        if kind[:1].isupper() and zlib.crc32(view[position + 4 : end]) != stated:
            raise ValueError("its checksums do not fit its pixels")
        if kind == b"IEND":
            return
        position = end + 4
