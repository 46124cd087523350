"""Photos that look alike, by their vectors of locally aggregated descriptors (VLAD).

Jégou et al., "Aggregating local image descriptors into compact codes" (PAMI 2012), with RootSIFT
(Arandjelović and Zisserman, CVPR 2012) and intra-normalisation ("All about VLAD", CVPR 2013). The
centres are learned from the photos' own features, so nothing is fetched. COLMAP's vocabulary tree
would serve as well, but its index is not the same twice, and takes longer than this to build.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pycolmap
from numpy.typing import NDArray
from scipy.cluster.vq import kmeans2

_CENTRES = 64
_FEATURES_PER_CENTRE = 400  # to learn a centre from
_ITERATIONS = 15

Features = NDArray[np.float32]


def alike_pairs(database: Path, count: int, seed: int) -> list[tuple[str, str]]:
    """File names of photos that look alike: each with the ``count`` most like it, each pair once.

    Args:
        database: COLMAP's, with SIFT features.
        count: Photos to match each one with.
        seed: For the choice of features that centres are learned from.
    """
    with pycolmap.Database.open(database) as opened:
        images = sorted((str(image.name), image.image_id) for image in opened.read_all_images())
        centres = _centres(opened, [key for _, key in images], seed)
        if centres is None:
            return []
        vectors = np.stack([_vlad(_root_sift(opened, key), centres) for _, key in images])
    likeness = vectors @ vectors.T
    np.fill_diagonal(likeness, -np.inf)
    pairs = set()
    for index, row in enumerate(likeness):
        for other in np.argsort(-row, kind="stable")[:count]:
            if np.isfinite(row[other]):
                pairs.add((min(index, int(other)), max(index, int(other))))
    return [(images[first][0], images[second][0]) for first, second in sorted(pairs)]


def _root_sift(database: pycolmap.Database, image_id: int) -> Features:
    """Descriptors ``[N, 128]`` whose dot products compare by Hellinger's kernel."""
    stored = np.array(database.read_descriptors(image_id).data, dtype=np.float32)
    shares = stored / np.maximum(stored.sum(axis=1, keepdims=True), 1.0)
    rooted: Features = np.sqrt(shares)
    return rooted


def _centres(database: pycolmap.Database, image_ids: Sequence[int], seed: int) -> Features | None:
    """Centres ``[64, 128]`` of a sample, alike many of each photo; None if there are too few."""
    rng = np.random.default_rng(seed)
    share = -(-_CENTRES * _FEATURES_PER_CENTRE // max(len(image_ids), 1))
    samples = [rng.permutation(_root_sift(database, key))[:share] for key in image_ids]
    sample = np.concatenate(samples) if samples else np.empty((0, 128), np.float32)
    if len(sample) < 10 * _CENTRES:
        return None
    found, _ = kmeans2(sample, _CENTRES, iter=_ITERATIONS, minit="points", rng=rng, missing="warn")
    centres: Features = found.astype(np.float32)
    return centres


def _vlad(features: Features, centres: Features) -> Features:
    """Sums of the differences to the nearest centre, ``[64 * 128]``, of unit length."""
    sums = np.zeros_like(centres)
    if len(features):
        # All lengths are 1 or nearly so; the nearest centre follows from dot products.
        nearest = (features @ centres.T - 0.5 * (centres**2).sum(axis=1)).argmax(axis=1)
        np.add.at(sums, nearest, features - centres[nearest])
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
    vector: Features = sums.ravel() / np.maximum(np.linalg.norm(sums), 1e-12)
    return vector
