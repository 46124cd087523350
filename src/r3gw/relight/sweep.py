"""A number that may change over a film."""

from dataclasses import dataclass

import numpy as np

from r3gw.files import InputError


@dataclass(frozen=True)
class Sweep:
    """Values passed through at an even pace from the first frame to the last."""

    values: tuple[float, ...]

    @staticmethod
    def parse(text: str) -> "Sweep":
        """Read ``VALUE`` or ``FROM:TO`` or ``FROM:VIA:TO``.

        Raises:
            InputError: If a part is no finite number.
        """
        try:
            values = tuple(float(part) for part in text.split(":"))
        except ValueError:
            values = (float("nan"),)
        if not np.isfinite(values).all():
            raise InputError(f"'{text}' is neither a number nor FROM:TO, such as 0:90")
        return Sweep(values)

    @property
    def moves(self) -> bool:
        """Whether the value changes."""
        return len(set(self.values)) > 1

    def at(self, time: float) -> float:
        """Value at a time of the film, 0 to 1."""
        return float(np.interp(time, np.linspace(0.0, 1.0, len(self.values)), self.values))
