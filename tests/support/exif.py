"""JPEG files with an EXIF orientation tag."""

import struct

import cv2
import numpy as np


def with_orientation(path, image: np.ndarray, orientation: int) -> None:
    """Write a JPEG whose EXIF tag says how it was held."""
    data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 97])[1].tobytes()
    tiff = b"II*\0" + struct.pack("<IHHHIHHI", 8, 1, 0x0112, 3, 1, orientation, 0, 0)
    segment = b"Exif\0\0" + tiff
    length = struct.pack(">H", len(segment) + 2)
    path.write_bytes(data[:2] + b"\xff\xe1" + length + segment + data[2:])
