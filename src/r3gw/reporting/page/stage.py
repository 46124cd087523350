"""The report's entry: one HTML page that needs no other file and no network."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.reporting.figures.style import look
from r3gw.reporting.page.scene_page import SceneFolders, scene_page
from r3gw.reporting.page.tables import COST, DECOMPOSITION, listing, provenance, table1_page
from r3gw.reporting.tables.printed import write_text


def write_report(tables: Path, scenes: Sequence[SceneFolders], target: Path) -> None:
    """Write the report.

    Args:
        tables: Folder of table1.csv, decomposition.csv and cost.csv.
        scenes: Scenes and the runs to show of each, the main one first.
        target: The page (.html).

    Raises:
        InputError: If a file is missing.
    """
    frames = {name: _read(tables / f"{name}.csv") for name in ("table1", "decomposition", "cost")}
    names = [each.root.name for each in scenes]
    with look():
        pages = [scene_page(each) for each in tqdm(scenes, desc="report", unit="scene")]
    environment = Environment(
        loader=PackageLoader("r3gw.reporting.page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template("report.html.j2").render(
        table1=table1_page(frames["table1"], names),
        decomposition=listing(frames["decomposition"], DECOMPOSITION),
        cost=listing(frames["cost"], COST),
        scenes=pages,
        provenance=provenance(frames["table1"]),
    )
    write_text(page, target)


def _read(path: Path) -> pd.DataFrame:
    if not path.is_file():
        raise InputError(f"{path}: no such file; make the tables first")
    return pd.read_csv(path)
