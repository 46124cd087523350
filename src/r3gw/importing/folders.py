"""What readers of datasets with known cameras share: photos, sessions, splits and masks."""

import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.named_files import listed, pictures_below
from r3gw.importing.source import MaskKind, SourceMask
from r3gw.importing.split import Split, find_split_file, read_split
from r3gw.scene import EvaluationEntry
from r3gw.scene.names import ByPhoto, key_of, normalised, stem_of

LEAST_TRAINING_VIEWS = 2
_SESSION = re.compile(r"^(\d\d-\d\d_\d\d_\d\d)_")
MASK_FOLDERS: Mapping[MaskKind, tuple[str, bool]] = {
    "is_valid": ("masks", True),
    "is_sky": ("sky_masks", False),  # white = NOT sky
}

Masks = Mapping[MaskKind, ByPhoto[SourceMask]]


def session_of(path: str) -> str | None:
    """The ``dd-mm_hh_mm`` that NeRF-OSR's file names begin with, or None."""
    session = _SESSION.match(stem_of(path))
    return session.group(1) if session else None


def photos_named(
    names: Iterable[str], pictures: Mapping[str, Path], source: Path
) -> dict[str, str]:
    """The picture that each name of a model or a list means, by its path; none, if it is absent.

    The same path comes first, then one that differs in case or suffix, then what `ByPhoto` finds.

    Raises:
        InputError: If a name fits several pictures, or two names mean the same picture.
    """
    wanted = list(names)
    found = {name: normalised(name) for name in wanted if normalised(name) in pictures}
    left = {name: name for name in wanted if name not in found}
    others = [path for path in pictures if path not in set(found.values())]
    matched = ByPhoto(left, others, str(source))
    for path in others:
        name = matched.get(path)
        if name is not None:
            found[name] = path
    return found


def masks_beside(folder: Path, photos: Collection[str]) -> Masks:
    """Masks in ``masks/`` (white = keep) and ``sky_masks/`` (white = not sky), by kind.

    Args:
        folder: Holds both folders, or none.
        photos: Paths of all photos, among which a mask's owner is found.

    Raises:
        InputError: If two masks are for the same photo, or one fits several photos.
    """
    return {
        kind: ByPhoto(mask_files(folder / name, white), photos, str(folder / name))
        for kind, (name, white) in MASK_FOLDERS.items()
    }


def mask_files(folder: Path, white_means: bool = True) -> dict[str, SourceMask]:
    """Masks by the path of their photo; COLMAP writes ``photo.jpg.png`` for photo.jpg."""
    found = {}
    for path, file in pictures_below(folder).items():
        inner = path.removesuffix(file.suffix)
        found[inner if key_of(inner) != inner.lower() else path] = SourceMask(file, white_means)
    return found


def notes_on_masks(masks: Masks) -> tuple[str, ...]:
    """A sentence about each folder in which masks belong to no photo, if there is one."""
    return tuple(
        f"masks in {MASK_FOLDERS[kind][0]}/ that belong to no photo are not used: "
        f"{listed(files.unused, 3)}; a mask has the name of its photo"
        for kind, files in masks.items()
        if files.unused
    )


def masks_of(masks: Masks, photo: str) -> dict[MaskKind, SourceMask]:
    """The masks of one photo, by kind."""
    return {kind: mask for kind, files in masks.items() if (mask := files.get(photo)) is not None}


def evaluation_with_mask(
    entry: EvaluationEntry | None, mask: SourceMask | None
) -> EvaluationEntry | None:
    """An entry without a mask path of its own takes the one of eval_mask/."""
    if entry is None or entry.mask is not None or mask is None:
        return entry
    return entry.model_copy(update={"mask": str(mask.path)})


def split_beside(folder: Path, photos: Collection[str]) -> dict[str, Split]:
    """The split of each photo by the folder's ``*_split.csv``; without one, all are for training.

    Raises:
        InputError: If the list is wrong, names no photo of the folder, or there are several lists.
    """
    if not any(path.name.lower().endswith("_split.csv") for path in folder.glob("*")):
        return dict.fromkeys(photos, "train")
    path = find_split_file(folder)
    lines = ByPhoto(read_split(path), photos, str(path))
    found = {photo: line.split for photo in photos if (line := lines.get(photo)) is not None}
    if not found:
        raise InputError(
            f"{path}: names none of the photos here (it names {listed(lines.unused, 2)}); write "
            "the photos' own names"
        )
    return found


def require_training_views(splits: Iterable[Split], source: Path) -> None:
    """Refuse a scene that nothing can be learned from.

    Raises:
        InputError: If fewer than two photos are for training.
    """
    count = sum(split == "train" for split in splits)
    if count < LEAST_TRAINING_VIEWS:
        photos = "no training photo is" if count == 0 else "only one training photo is"
        raise InputError(
            f"{source}: {photos} left, but a scene needs {LEAST_TRAINING_VIEWS} or more; add "
            "photos, or check that the split list and the cameras name the same files"
        )
