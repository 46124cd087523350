"""history.csv: what a training did, a row every few iterations."""

import csv
import time
from pathlib import Path

import torch

from r3gw.files import atomic_path
from r3gw.model.model import SceneModel
from r3gw.rendering.compose import Rendering
from r3gw.training.photos import Photo

ROWS = 200
LEADING = ("iteration", "loss", "psnr", "num_foreground", "num_sky", "sky_radius")


class History:
    """Collects rows and writes them at the end."""

    def __init__(self, iterations: int) -> None:
        """Plan about `ROWS` rows over ``iterations``."""
        self.interval = max(1, iterations // ROWS)
        self.start = time.perf_counter()
        self.rows: list[dict[str, float | int]] = []

    def seconds(self) -> float:
        """Time spent training so far."""
        return time.perf_counter() - self.start

    def resume(self, rows: list[dict[str, float | int]], seconds: float) -> None:
        """Go on after ``rows``, ``seconds`` into the run."""
        self.rows = rows
        self.start = time.perf_counter() - seconds

    def is_due(self, iteration: int) -> bool:
        """Whether this iteration gets a row."""
        return iteration % self.interval == 0 or iteration == 1

    def add(
        self,
        iteration: int,
        model: SceneModel,
        photo: Photo,
        rendering: Rendering,
        parts: dict[str, float],
    ) -> dict[str, float | int]:
        """Record one iteration and return its row, with a column for every acting loss."""
        row: dict[str, float | int] = {
            "iteration": iteration,
            "loss": sum(parts.values()),
            "psnr": photo_psnr(rendering, photo),
            "num_foreground": len(model.foreground),
            "num_sky": len(model.sky.rows),
            "sky_radius": float(model.sky.radius.detach()),
        }
        row |= {f"loss_{name}": value for name, value in parts.items()}
        self.rows.append(row)
        return row

    def write(self, path: Path) -> None:
        """Write all rows as CSV, atomically; a loss that does not act yet is 0.

        Columns have an order of their own: a run that continued from a checkpoint knows the keys
        of its earlier rows in the order of that file.
        """
        names = {name for row in self.rows for name in row}
        columns = [*LEADING, *sorted(names - {*LEADING})]
        with atomic_path(path) as temporary, temporary.open("w", newline="") as stream:
            table = csv.DictWriter(stream, columns, restval="0", lineterminator="\n")
            table.writeheader()
            table.writerows(
                {name: _spoken(value) for name, value in row.items()} for row in self.rows
            )


def _spoken(value: float | int) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


@torch.no_grad()
def photo_psnr(rendering: Rendering, photo: Photo) -> float:
    """PSNR in dB over the valid pixels of a training photo, sky included."""
    error = (rendering.colour.clamp(0, 1) - photo.target()).square()[photo.is_valid]
    return float(-10 * torch.log10(error.mean() + 1e-6))
