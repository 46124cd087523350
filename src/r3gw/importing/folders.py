"""What readers of datasets with known cameras share: sessions, splits and masks beside photos."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.named_files import key_of, pictures_by_key
from r3gw.importing.source import MaskKind, SourceMask
from r3gw.importing.split import Split, find_split_file, read_split
from r3gw.scene import EvaluationEntry

LEAST_TRAINING_VIEWS = 2
_SESSION = re.compile(r"^(\d\d-\d\d_\d\d_\d\d)_")
MASK_FOLDERS: Mapping[MaskKind, tuple[str, bool]] = {
    "is_valid": ("masks", True),
    "is_sky": ("sky_masks", False),  # white = NOT sky
}


def session_of(name: str) -> str | None:
    """The ``dd-mm_hh_mm`` that NeRF-OSR's file names begin with, or None."""
    session = _SESSION.match(name)
    return session.group(1) if session else None


def masks_beside(folder: Path) -> dict[MaskKind, dict[str, SourceMask]]:
    """Masks in ``masks/`` (white = keep) and ``sky_masks/`` (white = not sky), by kind and key.

    Raises:
        InputError: If two masks of a kind share a stem.
    """
    return {
        kind: {key: SourceMask(path, white) for key, path in mask_files(folder / name).items()}
        for kind, (name, white) in MASK_FOLDERS.items()
    }


def mask_files(folder: Path) -> dict[str, Path]:
    """Masks by the key of their photo; COLMAP writes ``photo.jpg.png`` for photo.jpg.

    Raises:
        InputError: If two masks share a stem.
    """
    found: dict[str, Path] = {}
    for key, path in pictures_by_key(folder).items():
        photo = key_of(key) if key.endswith((".jpg", ".jpeg", ".png")) else key
        if (other := found.setdefault(photo, path)) != path:
            raise InputError(f"{path}: is for the same photo as {other.name}; remove one of them")
    return found


def evaluation_with_mask(
    entry: EvaluationEntry | None, mask: SourceMask | None
) -> EvaluationEntry | None:
    """An entry without a mask path of its own takes the one of eval_mask/."""
    if entry is None or entry.mask is not None or mask is None:
        return entry
    return entry.model_copy(update={"mask": str(mask.path)})


def split_beside(folder: Path, names: Iterable[str]) -> dict[str, Split]:
    """The split of each key by the folder's ``*_split.csv``; without one, all are for training.

    Raises:
        InputError: If the list is wrong, or there are several.
    """
    if not any(path.name.lower().endswith("_split.csv") for path in folder.glob("*")):
        return dict.fromkeys((key_of(name) for name in names), "train")
    return {key: line.split for key, line in read_split(find_split_file(folder)).items()}


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
