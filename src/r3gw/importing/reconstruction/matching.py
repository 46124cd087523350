"""Which photos are matched with which, and the matching itself.

All pairs of 300 photos take hours, and nearly none of them show the same thing. Beyond some sixty
photos, pairs come from likeness, from where the photos were taken, and from the order of their
names.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import pycolmap
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.importing.reader import Effort
from r3gw.importing.reconstruction.prepared import PreparedPhoto
from r3gw.importing.reconstruction.retrieval import alike_pairs

Matching = Literal["exhaustive", "sequential", "retrieval", "spatial"]
Pair = tuple[str, str]

MOST_EXHAUSTIVE = 60  # photos
_DOUBLINGS = 10  # distances in a sequence: 1, 2, 4, ... 512
_ALIKE = 25  # photos that look most like each one
_FOLLOWING = 2  # photos that follow, where the order is a hint only
_NEAREST = 30  # photos in space
_PAIRS_AT_ONCE = 50
_EARTH_RADIUS_M = 6_371_000.0


def match_photos(
    photos: Sequence[PreparedPhoto], database: Path, matching: Matching | None, effort: Effort
) -> str:
    """Match photos whose features are in ``database``; returns how, for the report.

    Args:
        photos: The photos, in the order in which they were taken if that is known.
        database: COLMAP's, with features.
        matching: How pairs are chosen; None: all of them up to sixty photos, beyond that by
            likeness, by order and by place.
        effort: Threads and seed.

    Raises:
        InputError: If places are to choose, but less than half of the photos tell theirs.
    """
    chosen = matching or ("exhaustive" if len(photos) <= MOST_EXHAUSTIVE else "retrieval")
    if chosen == "exhaustive":
        pairs = set(_following(photos, len(photos)))
    elif chosen == "sequential":
        pairs = set(_doubling(photos))
    elif chosen == "spatial":
        _require_places(photos)
        pairs = set(_near_in_space(photos)) | set(_following(photos, _FOLLOWING))
    else:
        pairs = set(alike_pairs(database, _ALIKE, effort.seed)) | set(
            _following(photos, _FOLLOWING)
        )
        if matching is None:
            pairs |= set(_near_in_space(photos))
    match_pairs(database, sorted(pairs), effort)
    return f"{chosen}, {len(pairs)} pairs"


def match_pairs(database: Path, pairs: Sequence[Pair], effort: Effort) -> None:
    """Match pairs of file names that hold no blank, and verify them by their geometry."""
    options = pycolmap.FeatureMatchingOptions(num_threads=effort.num_threads, use_gpu=False)
    verification = pycolmap.TwoViewGeometryOptions()
    verification.ransac.random_seed = effort.seed
    listed = database.parent / "pairs.txt"
    with tqdm(total=len(pairs), desc="matching", unit="pair", leave=False) as progress:
        for start in range(0, len(pairs), _PAIRS_AT_ONCE):
            part = pairs[start : start + _PAIRS_AT_ONCE]
            listed.write_text("".join(f"{first} {second}\n" for first, second in part))
            pycolmap.match_image_pairs(
                database,
                matching_options=options,
                pairing_options=pycolmap.ImportedPairingOptions(match_list_path=listed),
                verification_options=verification,
            )
            progress.update(len(part))


def _following(photos: Sequence[PreparedPhoto], count: int) -> list[Pair]:
    """Every photo with the ``count`` that follow it."""
    names = [photo.file.name for photo in photos]
    return [(names[i], other) for i in range(len(names)) for other in names[i + 1 : i + 1 + count]]


def _doubling(photos: Sequence[PreparedPhoto]) -> list[Pair]:
    """Every photo with those 1, 2, 4, ... further, as COLMAP's sequential matching has it."""
    names = [photo.file.name for photo in photos]
    steps = [2**power for power in range(_DOUBLINGS)]
    return [
        (names[i], names[i + step]) for i in range(len(names)) for step in steps
        if i + step < len(names)
    ]  # fmt: skip


def _require_places(photos: Sequence[PreparedPhoto]) -> None:
    placed = sum(photo.place is not None for photo in photos)
    if 2 * placed < len(photos):
        raise InputError(
            f"'matching: spatial' needs GPS in EXIF, but only {placed} of {len(photos)} photos "
            "have it; choose 'retrieval' or leave 'matching' out"
        )


def _near_in_space(photos: Sequence[PreparedPhoto]) -> list[Pair]:
    """Every photo whose place is known with the nearest ones, by EXIF's GPS."""
    placed = [photo for photo in photos if photo.place is not None]
    if len(placed) < 2:
        return []
    metres = _metres(np.array([photo.place for photo in placed]))
    pairs = set()
    for index, photo in enumerate(placed):
        distance = np.linalg.norm(metres - metres[index], axis=1)
        distance[index] = np.inf
        for other in np.argsort(distance, kind="stable")[:_NEAREST]:
            if int(other) != index:
                names = sorted((photo.file.name, placed[int(other)].file.name))
                pairs.add((names[0], names[1]))
    return sorted(pairs)


def _metres(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Local metres ``[N, 2]`` east and north of latitudes and longitudes ``[N, 3]`` in degrees."""
    latitude, longitude = np.radians(places[:, 0]), np.radians(places[:, 1])
    turn = np.angle(np.exp(1j * (longitude - longitude[0])))  # across the date line
    east = turn * np.cos(latitude.mean())
    return _EARTH_RADIUS_M * np.stack([east, latitude - latitude[0]], axis=1)
