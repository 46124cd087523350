"""How tables reach disk: CSV, and table 1 as Markdown and LaTeX (booktabs)."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from r3gw.evaluation.metrics import METRICS
from r3gw.files import atomic_path
from r3gw.reporting.tables.panels import HIGHER_IS_BETTER, NOTE, Figure, Panel, panels

FLOAT_FORMAT = "%.6g"
SPECIAL = {"&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}"}


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
    heads = ["Method", *(f"{metric.upper()} {place}" for place in places for metric in METRICS)]
    parts, shown = [], list(panels(frame, places))
    for panel in shown:
        rows = [[name, *(figure.text for figure in row)] for name, row in panel.rows.items()]
        table = pd.DataFrame(rows, columns=heads)
        text = table.to_markdown(index=False, disable_numparse=True)
        parts.append(f"**{panel.title[0].upper()}{panel.title[1:]}**\n\n{text}\n")
    if any(panel.has_spread for panel in shown):
        parts.append(f"{NOTE}\n")
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
    body, shown = [], list(panels(frame, places))
    for panel in shown:
        title = f"\\emph{{{_escaped(panel.title)}}}"
        body.append(f"\\multicolumn{{{num_columns}}}{{l}}{{{title}}} \\\\")
        body += _latex_rows(panel)
        body.append("\\addlinespace")
    note = [f"% {NOTE}"] if any(panel.has_spread for panel in shown) else []
    lines = [
        "% \\usepackage{booktabs}; wide: \\resizebox{\\linewidth}{!}{\\input{table1}}",
        *note,
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


def _latex_rows(panel: Panel) -> list[str]:
    best = panel.best()
    return [
        " & ".join(
            [
                _escaped(method),
                *(
                    _latex_figure(figure, is_best=figure.value == wanted)
                    for figure, wanted in zip(row, best, strict=True)
                ),
            ]
        )
        + " \\\\"
        for method, row in panel.rows.items()
    ]


def _latex_figure(figure: Figure, *, is_best: bool) -> str:
    value = f"\\textbf{{{figure.value}}}" if is_best and figure.value else figure.value
    spread = f" $\\pm$ {figure.spread}" if figure.spread else ""
    return value + spread + ("$^*$" if figure.is_marked else "")


def _escaped(text: str) -> str:
    return "".join(SPECIAL.get(character, character) for character in text)
