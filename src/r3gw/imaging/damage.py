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


def png_is_whole(data: bytes) -> bool:
    """Whether the checksums of a PNG's critical chunks hold; Pillow does not look at pixels' own.

    A wrong checksum of an ancillary chunk, such as a colour profile, spoils no pixel (W3C, PNG
    Specification, 5.3 and 5.4: capital letters mark critical chunks).
    """
    position = len(_PNG_MAGIC)
    view = memoryview(data)
    while position + 12 <= len(data):
        length = int.from_bytes(view[position : position + 4], "big")
        kind = bytes(view[position + 4 : position + 8])
        end = position + 8 + length
        if kind[:1].isupper():
            stated = int.from_bytes(view[end : end + 4], "big")
            if end + 4 > len(data) or zlib.crc32(view[position + 4 : end]) != stated:
                return False
        if kind == b"IEND":
            return True
        position = end + 4
    return False
