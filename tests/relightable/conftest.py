"""The tiny scene of the evaluation's tests, whose photos are renderings of a known model."""

from evaluation.conftest import tiny

__all__ = ["tiny"]
