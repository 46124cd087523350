"""A number that may change over a film."""

from dataclasses import dataclass
from math import isfinite

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
        if not all(isfinite(value) for value in values):
            raise InputError(f"'{text}' is neither a number nor FROM:TO, such as 0:90")
        return Sweep(values)

    @property
    def moves(self) -> bool:
        """Whether the value changes."""
        return len(set(self.values)) > 1

    def at(self, time: float) -> float:
        """Value at a time of the film, 0 to 1."""
        place = min(max(time, 0.0), 1.0) * (len(self.values) - 1)
        before = min(int(place), len(self.values) - 2)
        if before < 0:
            return self.values[0]
        first, last = self.values[before : before + 2]
        return first + (place - before) * (last - first)
