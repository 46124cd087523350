"""The embedded benchmark: three synthetic outdoor scenes with ground truth, rendered by Mitsuba.

Importing this package selects Mitsuba's variant `scalar_rgb`, the one that needs no LLVM.
"""

import mitsuba

mitsuba.set_variant("scalar_rgb")

from r3gw.benchmark.generate import SCENES, generate  # noqa: E402

__all__ = ["SCENES", "generate"]
