"""One random stream per purpose, so that a change in one part leaves the others as they were."""

import zlib

import numpy as np


def stream(seed: int, *purpose: str) -> np.random.Generator:
    """Return the generator of ``seed`` for a named purpose, such as ``("chapel", "clouds")``."""
    return np.random.default_rng([seed, *(zlib.crc32(word.encode()) for word in purpose)])
