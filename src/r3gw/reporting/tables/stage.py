"""The tables' entry: which tables are made of which runs, and where they are written."""

from collections.abc import Sequence
from pathlib import Path

from r3gw.reporting.tables import listings
from r3gw.reporting.tables.table1 import ablations, table1


def write_main_tables(metrics_files: Sequence[Path], published: Path | None, target: Path) -> None:
    """Write table1 (.csv, .md, .tex), images, runs, decomposition and cost (.csv).

    Args:
        metrics_files: metrics.json of every run.
        published: Published figures to show beside ours where the scenes are the paper's.
        target: Folder of the tables.

    Raises:
        InputError: If a file is missing or malformed.
    """
    listings.images_table(metrics_files, target / "images.csv")
    listings.runs_table(metrics_files, target / "runs.csv")
    listings.decomposition(metrics_files, target / "decomposition.csv")
    listings.cost(metrics_files, target / "cost.csv")
    table1(metrics_files, published, target / "table1.csv")


def write_ablation_tables(metrics_files: Sequence[Path], target: Path) -> None:
    """Write ablations.csv and ablation_runs.csv into a folder.

    Raises:
        InputError: If a file is missing or malformed.
    """
    listings.runs_table(metrics_files, target / "ablation_runs.csv")
    ablations(metrics_files, target / "ablations.csv")
