"""Table 1 in panels, one per protocol, so that figures of different protocols share no column.

Panels are read from the rows of table1.csv, so that Markdown, LaTeX and the report say what the
file says. Published rows have panels of their own.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from r3gw.evaluation.metrics import METRICS
from r3gw.evaluation.protocols import facts

DIGITS = {"psnr": 2, "ssim": 3, "mse": 3, "mae": 3}
HIGHER_IS_BETTER = {"psnr", "ssim"}
# Column with the names of all figures of a row that seeds do not tell apart from the first method.
WITHIN_SPREAD = "within_spread"
MARK = "*"
NOTE = (
    "± is the sample standard deviation over seeds. An asterisk: the difference to the full method "
    "is no larger than the larger of the two spreads, so these seeds do not tell the two apart."
)


@dataclass(frozen=True)
class Figure:
    """One printed figure.

    Attributes:
        value: Mean over seeds, as a rounded text; empty if unknown.
        spread: Over seeds, as a rounded text; empty below two seeds.
        is_marked: Whether the difference to the full method lies within the spread.
    """

    value: str
    spread: str = ""
    is_marked: bool = False

    @property
    def text(self) -> str:
        """``23.01 ± 0.12*``, ``23.01`` or nothing."""
        return self.value + (f" ± {self.spread}" if self.spread else "") + MARK * self.is_marked


@dataclass(frozen=True)
class Panel:
    """Figures of one protocol, or the published ones.

    Attributes:
        title: What stands above it.
        rows: By method, the figures in the order of places and, for each, of `METRICS`.
    """

    title: str
    rows: Mapping[str, Sequence[Figure]]

    def best(self) -> list[str | None]:
        """Per column the best value; None where fewer than two methods have one."""
        metrics = len(METRICS)
        columns = zip(*self.rows.values(), strict=True)
        return [_best(METRICS[i % metrics], column) for i, column in enumerate(columns)]

    @property
    def has_spread(self) -> bool:
        """Whether any figure is of several seeds."""
        return any(figure.spread for row in self.rows.values() for figure in row)


def panels(frame: pd.DataFrame, places: Sequence[str]) -> Iterator[Panel]:
    """All panels that have figures.

    Args:
        frame: Rows of table1.csv.
        places: Scenes, then "avg".
    """
    is_published = frame["group"].str.startswith("published")
    for protocol in facts.PROTOCOLS:
        title = f"protocol {protocol.name}: {protocol.title}"
        for rows, origin in ((frame[is_published], "published, "), (frame[~is_published], "")):
            printed = {
                str(row["method"]): [
                    _figure(row, metric, protocol.suffix, place)
                    for place in places
                    for metric in METRICS
                ]
                for row in rows.to_dict("records")
            }
            if any(figure.value for row in printed.values() for figure in row):
                yield Panel(origin + title, printed)


def _figure(row: Mapping[Any, Any], metric: str, suffix: str, place: str) -> Figure:
    name = f"{metric}{suffix}_{place}"
    marked = str(row.get(WITHIN_SPREAD, "")).split(";")
    spread = row.get(f"{metric}{suffix}_std_{place}")
    digits = DIGITS[metric]
    value = _rounded(row.get(name), digits)
    return Figure(value, _rounded(spread, digits) if value else "", name in marked)


def _rounded(value: Any, digits: int) -> str:
    return "" if value is None or pd.isna(value) else f"{value:.{digits}f}"


def _best(metric: str, figures: Sequence[Figure]) -> str | None:
    known = [figure.value for figure in figures if figure.value]
    choose = max if metric in HIGHER_IS_BETTER else min
    return choose(known, key=float) if len(known) > 1 else None
