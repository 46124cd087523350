"""The registry: which reader reads which format."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from r3gw.importing.reader import Reader
from r3gw.importing.readers.colmap import ColmapReader
from r3gw.importing.readers.nerf_osr import NerfOsrReader
from r3gw.importing.readers.nerf_osr_original import NerfOsrOriginalReader
from r3gw.importing.readers.nerfstudio import NerfstudioReader
from r3gw.importing.readers.photos import PhotosReader
from r3gw.importing.settings import SceneSettings

_READERS: Mapping[str, type[Reader[Any]]] = {
    "synthetic": NerfOsrReader,
    "nerf-osr": NerfOsrReader,
    "nerf-osr-original": NerfOsrOriginalReader,
    "colmap": ColmapReader,
    "nerfstudio": NerfstudioReader,
    "photos": PhotosReader,
}


def reader_of(settings: SceneSettings, source: Path) -> Reader[Any]:
    """The reader of an entry's format for what lies in ``source``."""
    return _READERS[settings.format](settings, source)
