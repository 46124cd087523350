"""What photos are called: by their path below the folder of photos, so that equal stems may meet.

A rig or a drone writes ``left/0001.jpg`` and ``right/0001.jpg``. Paths are compared in Unicode's
composed form (NFC) with ``/``, since macOS decomposes accents and Windows writes ``\\``. Masks,
lists and label maps name photos with other suffixes, other cases and other leading folders;
`ByPhoto` finds the photo that is meant.
"""

import re
import unicodedata
from collections.abc import Collection, Iterable, Iterator, Mapping
from hashlib import sha256
from pathlib import PurePosixPath
from typing import Generic, TypeVar

from r3gw.files import InputError

# What may stand behind the dot of a photo, mask or map; anything else belongs to the name.
_SUFFIX = re.compile(
    r"(?<=[^/])\.(jpe?g|jpe|jfif|png|tiff?|webp|heic|heif|hif|avif|bmp|gif|dng|cr2|cr3|nef|arw|raf"
    r"|orf|rw2|exr|hdr|txt|npy)$",
    re.IGNORECASE,
)
_UNSAFE = re.compile(r'[\x00-\x1f\x7f/\\:*?"<>|]')
_MOST_BYTES = 180  # of a view's name; file systems allow 255, and writers add to it

Thing = TypeVar("Thing")


def normalised(path: str) -> str:
    """A path as written anywhere, with ``/``, in NFC, without ``./`` in front."""
    return str(PurePosixPath(unicodedata.normalize("NFC", path.replace("\\", "/"))))


def key_of(path: str) -> str:
    """What a photo's path is compared by: normalised, without its suffix, in lower case."""
    return _SUFFIX.sub("", normalised(path)).lower()


def stem_of(path: str) -> str:
    """A path's last part without its suffix, in NFC, its case kept."""
    return _SUFFIX.sub("", normalised(path)).rpartition("/")[2]


def view_names(paths: Collection[str]) -> dict[str, str]:
    """Names of views by their photo's path; each is unique and safe as a file name.

    A photo is called by its stem; where two stems are equal, all photos are called by their
    path below what they have in common: ``rig/left/0001.jpg`` becomes ``left_0001``.
    """
    stems = {path: stem_of(path) for path in paths}
    if len({stem.lower() for stem in stems.values()}) < len(stems):
        common = _common_folder(paths)
        stems = {path: _SUFFIX.sub("", normalised(path))[len(common) :] for path in paths}
    names: dict[str, str] = {}
    taken: set[str] = set()
    for path in sorted(paths):
        name = _UNSAFE.sub("_", stems[path])
        if name.lower() in taken or len(name.encode()) > _MOST_BYTES:
            mark = sha256(normalised(path).encode()).hexdigest()[:8]
            name = f"{name.encode()[:_MOST_BYTES].decode(errors='ignore')}_{mark}"
        names[path] = name
        taken.add(name.lower())
    return names


def _common_folder(paths: Iterable[str]) -> str:
    """The folder that all paths begin with, with its last slash; empty if there is none."""
    folders = [normalised(path).split("/")[:-1] for path in paths]
    shared = []
    for parts in zip(*folders, strict=False):
        if len(set(parts)) > 1:
            break
        shared.append(parts[0])
    return "".join(f"{part}/" for part in shared)


class ByPhoto(Generic[Thing]):
    """Masks, lines of a list or maps, each given to the photo that its own path means.

    A thing belongs to the photo of the same path; else to the one whose path ends as its own does
    (``masks/left/0001.png`` or ``left/0001.png`` for ``left/0001.jpg``); else, whatever the
    folders, to the only photo of the same stem.
    """

    def __init__(self, things: Mapping[str, Thing], photos: Collection[str], where: str) -> None:
        """Match ``things`` by path with the paths of ``photos``; ``where`` names them in errors.

        Raises:
            InputError: If a thing fits several photos equally well, or a photo several things.
        """
        self.unused: list[str] = []
        self._found: dict[str, Thing] = {}
        by_stem: dict[str, list[str]] = {}
        for photo in photos:
            by_stem.setdefault(_last(key_of(photo)), []).append(photo)
        chosen: dict[str, tuple[tuple[bool, int], str]] = {}
        loose: dict[str, list[str]] = {}
        for path in sorted(things):
            key = key_of(path)
            candidates = by_stem.get(_last(key), [])
            best = _best(key, candidates, f"{where}: {path}")
            if best is None:
                loose.setdefault(_last(key), []).append(path)
                continue
            score, photo = best
            if photo in chosen and chosen[photo][0] == score:
                raise InputError(
                    f"{where}: {path} is for the same photo as {chosen[photo][1]}; remove one of "
                    "them"
                )
            if photo not in chosen or chosen[photo][0] < score:
                chosen[photo] = score, path
        for stem, paths in loose.items():
            candidates = by_stem.get(stem, [])
            if len(candidates) == len(paths) == 1 and candidates[0] not in chosen:
                chosen[candidates[0]] = (False, 0), paths[0]
        self._found = {key_of(photo): things[path] for photo, (_, path) in chosen.items()}
        used = {path for _, path in chosen.values()}
        self.unused = [path for path in sorted(things) if path not in used]

    def __contains__(self, photo: str) -> bool:
        return key_of(photo) in self._found

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def get(self, photo: str) -> Thing | None:
        """The thing that belongs to a photo, given by its path."""
        return self._found.get(key_of(photo))


def _last(key: str) -> str:
    return key.rpartition("/")[2]


def _best(
    key: str, candidates: Collection[str], source: str
) -> tuple[tuple[bool, int], str] | None:
    """The candidate whose path the key's ends with, or the other way round, and how well."""
    parts = key.split("/")
    scored = []
    for photo in candidates:
        other = key_of(photo).split("/")
        shared = min(len(parts), len(other))
        if parts[-shared:] == other[-shared:]:
            scored.append(((parts == other, shared), photo))
    if not scored:
        return None
    best = max(score for score, _ in scored)
    photos = [photo for score, photo in scored if score == best]
    if len(photos) > 1:
        raise InputError(
            f"{source} fits several photos ({', '.join(sorted(photos)[:3])}); put the photo's "
            "folder in front of its name"
        )
    return best, photos[0]
