"""Photos that look alike, by COLMAP's bag of visual words, built from the photos' own features.

No vocabulary is fetched: two thousand words of the set at hand tell its photos apart well enough to
choose whom to match. One thread and a seed, so that the same photos give the same pairs.
"""

from pathlib import Path

import numpy as np
import pycolmap

from r3gw.importing.reader import Effort

_WORDS = 2560
_LEAST_WORDS = 64
_FEATURES_PER_WORD = 40  # to learn a word from
_ITERATIONS = 12
_FEATURES_PER_PHOTO = 1500  # to compare photos by, the largest ones
_ALIKE = 25  # photos to match each one with
_EMBEDDING = 64


def alike_pairs(database: Path, effort: Effort) -> list[tuple[str, str]]:
    """File names of photos that look alike, each pair once; features must be in ``database``."""
    with pycolmap.Database.open(database) as opened:
        names = {image.image_id: str(image.name) for image in opened.read_all_images()}
        index = _index(opened, sorted(names), effort)
        if index is None:
            return []
        vocabulary = effort.folder / "vocabulary.bin"
        index.write(vocabulary)
        options = pycolmap.VocabTreePairingOptions(
            num_images=_ALIKE + 1, max_num_features=_FEATURES_PER_PHOTO, num_threads=1
        )
        options.vocab_tree_path = vocabulary
        found = pycolmap.VocabTreePairGenerator(options, opened).all_pairs()
    pairs = {(min(first, second), max(first, second)) for first, second in found}
    return sorted((names[first], names[second]) for first, second in pairs if first != second)


def _index(
    database: pycolmap.Database, identifiers: list[int], effort: Effort
) -> pycolmap.VisualIndex | None:
    """Words of a sample of all features, alike many per photo; None if there are too few."""
    rng = np.random.default_rng(effort.seed)
    share = -(-_WORDS * _FEATURES_PER_WORD // len(identifiers))
    samples = []
    for identifier in identifiers:
        features = np.array(database.read_descriptors(identifier).data)
        if len(features):
            chosen = rng.choice(len(features), min(share, len(features)), replace=False)
            samples.append(features[np.sort(chosen)])
    if not samples:
        return None
    sample = np.concatenate(samples).astype(np.float32)
    words = min(_WORDS, len(sample) // _FEATURES_PER_WORD)
    if words < _LEAST_WORDS:
        return None
    index = pycolmap.VisualIndex.create(sample.shape[1], _EMBEDDING)
    options = pycolmap.VisualIndex.BuildOptions(
        num_visual_words=words, num_iterations=_ITERATIONS, num_rounds=1, num_threads=1
    )
    index.build(
        options, pycolmap.FeatureDescriptorsFloat(pycolmap.FeatureExtractorType.SIFT, sample)
    )
    return index
