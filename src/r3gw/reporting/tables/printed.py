"""How tables reach paper and disk: CSV, Markdown, LaTeX (booktabs).

Table 1 is printed in panels, one per protocol, so that figures of different protocols never
share a column; published rows have a panel of their own.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

from r3gw.files import atomic_path
from r3gw.reporting.tables.runs import METRICS, SUFFIXES

FLOAT_FORMAT = "%.6g"
DIGITS = {"psnr": 2, "ssim": 3, "mse": 3, "mae": 3}
HIGHER_IS_BETTER = {"psnr", "ssim"}
PANELS = {
    "nerf-osr": "protocol nerf-osr: published angles, the best chosen by an oracle",
    "full-yaw": "protocol full-yaw: whole circle, the best angle chosen by an oracle",
    "nerf-osr-linear": "protocol nerf-osr-linear: linear maps, angle and exposure by an oracle",
    "exact": "protocol exact: true light, nothing chosen",
    "learned": "protocol learned: training views under their own lights",
}
SPECIAL = {"&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}"}

Panel = tuple[str, pd.DataFrame]


def write_csv(frame: pd.DataFrame, target: Path) -> None:
    """Write a table atomically, six significant digits."""
    with atomic_path(target) as path:
        frame.to_csv(path, index=False, float_format=FLOAT_FORMAT)


def write_text(text: str, target: Path) -> None:
    """Write a text atomically."""
    with atomic_path(target) as path:
        path.write_text(text)


def markdown(frame: pd.DataFrame, places: Sequence[str]) -> str:
    """Table 1 as Markdown: a heading and a table per panel.

    Args:
        frame: Rows of table1.csv.
        places: Scenes, then "avg".
    """
    parts = []
    for title, panel in panels(frame, places):
        table = panel.rename(columns=lambda name: _heading(name) if name != "method" else "Method")
        text = table.to_markdown(index=False, disable_numparse=True)
        parts.append(f"**{title[0].upper()}{title[1:]}**\n\n{text}\n")
    return "\n".join(parts)


def latex(frame: pd.DataFrame, places: Sequence[str]) -> str:
    """Table 1 as a LaTeX tabular for the booktabs package; best figure of a panel in bold."""
    width = len(METRICS)
    groups = "".join(f" & \\multicolumn{{{width}}}{{c}}{{{_escaped(name)}}}" for name in places)
    rules = " ".join(
        f"\\cmidrule(lr){{{2 + width * i}-{1 + width * (i + 1)}}}" for i in range(len(places))
    )
    arrows = {m: "uparrow" if m in HIGHER_IS_BETTER else "downarrow" for m in METRICS}
    heads = "".join(f" & {m.upper()} $\\{arrows[m]}$" for m in METRICS) * len(places)
    num_columns = 1 + width * len(places)
    body = []
    for title, panel in panels(frame, places):
        body.append(f"\\multicolumn{{{num_columns}}}{{l}}{{\\emph{{{_escaped(title)}}}}} \\\\")
        body += _latex_rows(panel, places)
        body.append("\\addlinespace")
    lines = [
        "% \\usepackage{booktabs}; wide: \\resizebox{\\linewidth}{!}{\\input{table1}}",
        f"\\begin{{tabular}}{{l{'r' * (num_columns - 1)}}}",
        "\\toprule",
        f"{groups} \\\\",
        rules,
        f"Method{heads} \\\\",
        "\\midrule",
        *body[:-1],
        "\\bottomrule",
        "\\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


def panels(frame: pd.DataFrame, places: Sequence[str]) -> Iterator[Panel]:
    """Title and rounded rows of every panel that has figures.

    Columns are ``method`` and ``<metric>_<place>`` for every metric and place.
    """
    is_published = frame["group"].str.startswith("published")
    for protocol, title in PANELS.items():
        for rows, origin in ((frame[is_published], "published, "), (frame[~is_published], "")):
            wanted = {
                f"{metric}_{place}": f"{metric}{SUFFIXES[protocol]}_{place}"
                for place in places
                for metric in METRICS
            }
            if rows.reindex(columns=list(wanted.values())).isna().to_numpy().all():
                continue
            panel = pd.DataFrame({"method": rows["method"]})
            for name, column in wanted.items():
                values = rows.get(column, pd.Series(float("nan"), rows.index))
                panel[name] = _rounded(values, DIGITS[name.split("_")[0]])
            yield origin + title, panel


def _latex_rows(panel: pd.DataFrame, places: Sequence[str]) -> list[str]:
    names = [f"{metric}_{place}" for place in places for metric in METRICS]
    best = {}
    for name in names:
        known = [value for value in panel[name] if value]
        choose = max if name.split("_")[0] in HIGHER_IS_BETTER else min
        best[name] = choose(known, key=float) if len(known) > 1 else None
    rows = []
    for _, row in panel.iterrows():
        cells = [
            f"\\textbf{{{row[name]}}}" if row[name] and row[name] == best[name] else row[name]
            for name in names
        ]
        rows.append(" & ".join([_escaped(str(row["method"])), *cells]) + " \\\\")
    return rows


def _heading(name: str) -> str:
    metric, place = name.split("_", 1)
    return f"{metric.upper()} {place}"


def _rounded(values: pd.Series, digits: int) -> pd.Series:
    return values.map(lambda value: "" if pd.isna(value) else f"{value:.{digits}f}")


def _escaped(text: str) -> str:
    return "".join(SPECIAL.get(character, character) for character in text)
