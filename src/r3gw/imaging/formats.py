"""Which files are pictures: what is read, what is written, and what is known but refused.

A file's contents decide how it is decoded, so a HEIC that somebody renamed to .jpg is read. Its
suffix decides what it is looked for as: a photo, or a map of linear light.
"""

from pathlib import Path

LDR_SUFFIXES = (
    ".png", ".jpg", ".jpeg", ".jpe", ".jfif", ".tif", ".tiff", ".webp", ".avif", ".heic", ".heif",
    ".hif", ".bmp",
)  # fmt: skip
HDR_SUFFIXES = (".exr", ".hdr")
PILLOW_FORMATS = ("JPEG", "PNG", "TIFF", "WEBP", "AVIF", "BMP", "GIF")  # that it is asked to open
WRITTEN_SUFFIXES = (".png", ".jpg", ".jpeg")
# Undeveloped sensor data: to develop it is a photographer's choice, so r3gw does not.
RAW_SUFFIXES = (
    ".dng", ".cr2", ".cr3", ".crw", ".nef", ".nrw", ".arw", ".sr2", ".srf", ".raf", ".rw2", ".orf",
    ".pef", ".srw", ".3fr", ".iiq", ".rwl", ".x3f", ".gpr", ".kdc", ".dcr", ".mrw", ".erf",
)  # fmt: skip
DEVELOP = "develop it to JPEG, PNG or 16-bit TIFF (darktable, RawTherapee or Lightroom do)"

# Pillow's own limit against pictures that are small on disk and fill the memory; medium format
# cameras of 150 million pixels stay below it.
MOST_PIXELS = 178_956_970
MOST_BYTES = 1 << 30


def is_picture(path: Path) -> bool:
    """Whether the name is that of a photo or mask, in upper or lower case."""
    return path.suffix.lower() in LDR_SUFFIXES


def is_raw(path: Path) -> bool:
    """Whether the name is that of undeveloped sensor data."""
    return path.suffix.lower() in RAW_SUFFIXES
