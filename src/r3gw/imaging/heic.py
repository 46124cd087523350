"""HEIC pictures, decoded in a process of their own.

libheif, which pi-heif brings, ends its process on some damaged files (found by fuzzing); so the
process that it can end is a child's. A child takes about a quarter of a second per photo.
"""

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.imaging.formats import MOST_PIXELS

_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx")
_MOST_SECONDS = 120
# pi-heif turns the picture by its own header, and EXIF's orientation is then 1.
_CHILD = """
import io, sys, warnings
import numpy as np, pi_heif
from PIL import Image
warnings.simplefilter("ignore")
pi_heif.register_heif_opener()
with Image.open(sys.argv[1], formats=("HEIF",)) as image:
    if image.width * image.height > int(sys.argv[2]):
        sys.exit("more pixels than are read")
    exif = image.getexif()
    block = exif.tobytes() if len(exif) else b""
    pixels = np.asarray(image.convert("RGBA" if image.has_transparency_data else "RGB"))
stream = io.BytesIO()
np.savez(stream, pixels=pixels, exif=np.frombuffer(block, np.uint8))
sys.stdout.buffer.write(stream.getvalue())
"""


def is_heic(data: bytes) -> bool:
    """Whether a file's first box says that it is HEIC; AVIF, of the same family, is not."""
    size = int.from_bytes(data[:4], "big")
    brands = data[8 : min(size, 256)]
    return data[4:8] == b"ftyp" and any(brand in brands for brand in _BRANDS)


def decode_heic(path: Path) -> tuple[NDArray[np.uint8], bytes]:
    """RGB or RGBA pixels ``[H, W, c]``, turned by the file's header, and its EXIF block.

    Raises:
        ValueError: If the file is damaged or too large.
    """
    command = [sys.executable, "-c", _CHILD, str(path.absolute()), str(MOST_PIXELS)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=_MOST_SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise ValueError(f"not decoded within {_MOST_SECONDS} s") from None
    if done.returncode:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        is_killed = done.returncode < 0 or not lines
        raise ValueError("its decoder gave up" if is_killed else lines[-1])
    with np.load(io.BytesIO(done.stdout)) as arrays:
        return arrays["pixels"], arrays["exif"].tobytes()
