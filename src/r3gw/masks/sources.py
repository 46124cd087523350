"""Where one photo's masks come from: the first source of a chain that has one (docs/data.md)."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.imaging.files import LDR_SUFFIXES, read_rgb
from r3gw.imaging.masks import read_mask
from r3gw.masks.classical import segment_sky
from r3gw.masks.labels import read_label_masks
from r3gw.masks.network import SegmentationNetwork
from r3gw.masks.settings import MaskSources, chain
from r3gw.masks.solid import Positions, solid_positions
from r3gw.scene import View, load_points
from r3gw.scene.names import ByPhoto, stem_of

Mask = NDArray[np.bool_]
_ADVICE = {
    "is_sky": "add it, or let the chain 'sky_masks' end in -or-classical (made from the photo)",
    "is_valid": "add it, or let the chain 'valid_masks' end in -or-all (every pixel is valid)",
}


class MaskReader:
    """Masks of the views of one scene, made or read one photo at a time."""

    def __init__(self, scene_folder: Path, views: Sequence[View], sources: MaskSources) -> None:
        """Look for label maps and read the network, if the chains name them.

        Raises:
            InputError: If the folder of label maps or the network is missing or unreadable.
        """
        self._folder = scene_folder
        self._sources = sources
        self._labels = _label_maps(scene_folder, views, sources.label_maps)
        named = {*chain(sources.sky_masks), *chain(sources.valid_masks)}
        self._network = None
        if "network" in named and sources.network is not None:
            self._network = SegmentationNetwork(sources.network)
        self._segmented: tuple[str, tuple[Mask, Mask]] | None = None
        self._points: NDArray[np.float32] | None = None

    def is_sky(self, view: View) -> tuple[str, Mask]:
        """Name of the source, and the mask ``[H, W]``.

        Raises:
            InputError: If no source of the chain has one, or a file is unreadable or misfit.
        """
        makers: dict[str, Callable[[View], Mask | None]] = {
            "given": lambda view: self._given("is_sky", view),
            "labels": lambda view: self._of_labels(view, 1),
            "network": lambda view: self._of_network(view, 1),
            "classical": lambda view: segment_sky(self._photo(view), self._solid(view)),
            "none": lambda view: np.zeros((view.height, view.width), np.bool_),
        }
        return _first("is_sky", view, self._sources.sky_masks, makers)

    def is_valid(self, view: View) -> tuple[str, Mask]:
        """As `is_sky`, for what is no occluder."""
        makers: dict[str, Callable[[View], Mask | None]] = {
            "given": lambda view: self._given("is_valid", view),
            "labels": lambda view: self._of_labels(view, 0),
            "network": lambda view: self._of_network(view, 0),
            "all": lambda view: np.ones((view.height, view.width), np.bool_),
        }
        return _first("is_valid", view, self._sources.valid_masks, makers)

    def is_opaque(self, view: View) -> Mask:
        """Where the photo is not transparent, ``[H, W]``: nothing else is valid, or sky.

        Raises:
            InputError: If the imported alpha channel is unreadable.
        """
        mask = self._given("is_opaque", view)
        return np.ones((view.height, view.width), np.bool_) if mask is None else mask

    def levels(self, kind: str, view: View, source: str) -> str | None:
        """What the import noted of a mask that came with the data and has one value only."""
        path = self._folder / "given" / kind / f"{view.name}.txt"
        return path.read_text() if source == "given" and path.is_file() else None

    def _photo(self, view: View) -> NDArray[np.uint8]:
        return read_rgb(self._folder / view.image)

    def _solid(self, view: View) -> Positions:
        if self._points is None:
            self._points = load_points(self._folder).xyz
        return solid_positions(view, self._points)

    def _given(self, kind: str, view: View) -> Mask | None:
        path = self._folder / "given" / kind / f"{view.name}.png"
        return read_mask(path, view.width, view.height) if path.is_file() else None

    def _of_labels(self, view: View, which: int) -> Mask | None:
        path = self._labels.get(view.name)
        if path is None:
            return None
        classes = self._sources.label_classes
        return read_label_masks(path, classes, view.width, view.height)[which]

    def _of_network(self, view: View, which: int) -> Mask | None:
        if self._network is None:
            return None
        if self._segmented is None or self._segmented[0] != view.name:
            self._segmented = view.name, self._network(self._photo(view))
        return self._segmented[1][which]


def _first(
    kind: str, view: View, wanted: str, makers: dict[str, Callable[[View], Mask | None]]
) -> tuple[str, Mask]:
    for source in chain(wanted):
        mask = makers[source](view)
        if mask is not None:
            return source, mask
    raise InputError(
        f"{view.name}: no source of '{wanted}' has a mask {kind} of this photo; {_ADVICE[kind]}"
    )


def _label_maps(scene_folder: Path, views: Sequence[View], folder: str | None) -> dict[str, Path]:
    """Label maps by the view's name; those that the entry names come before imported ones.

    A map in the entry's folder belongs to a view by the path of its photo (r3gw.scene.names), or
    by the view's own name.

    Raises:
        InputError: If there is no such folder, or a map fits several photos.
    """
    imported = scene_folder / "given" / "labels"
    found = {view.name: imported / f"{view.name}.png" for view in views}
    found = {name: path for name, path in found.items() if path.is_file()}
    if folder is None:
        return found
    place = Path(folder)
    if not place.is_dir():
        raise InputError(f"{folder}: no such folder; correct 'label_maps'")
    maps = {
        path.relative_to(place).as_posix(): path
        for path in sorted(place.rglob("*"))
        if path.suffix.lower() in LDR_SUFFIXES and not path.name.startswith(".")
    }
    names = {stem_of(path).lower(): file for path, file in maps.items()}
    by_path = ByPhoto(maps, [view.path or view.name for view in views], folder)
    for view in views:
        file = by_path.get(view.path or view.name) or names.get(view.name.lower())
        if file is not None:
            found[view.name] = file
    return found
