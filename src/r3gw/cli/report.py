"""Commands over many runs: tables and figures."""

from pathlib import Path

import click

from r3gw.cli.group import FILE, FOLDER, cli
from r3gw.cli.told import OPEN_PAGE, wrote


@cli.command(short_help="Make tables from the scores of any number of runs.")
@click.option("--kind", type=click.Choice(["table1", "ablations"]), required=True)
@click.option("--published", type=FILE, help="Published figures to show beside ours.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the tables.")
@click.argument("metrics", nargs=-1, required=True, type=FILE)
def tables(kind: str, published: Path | None, target: Path, metrics: tuple[Path, ...]) -> None:
    """Make tables from the metrics.json files of any number of runs."""
    from r3gw.reporting.tables.stage import write_ablation_tables, write_main_tables

    if kind == "table1":
        write_main_tables(metrics, published, target)
    else:
        write_ablation_tables(metrics, target)
    wrote(target / f"{kind}.csv", "docs/results.md explains the columns")


@cli.command(short_help="Compare variants with a baseline.")
@click.option("--baseline", required=True, help="Variant that the others are compared with.")
@click.option("--target", type=FILE, required=True, help="The table (.csv); .md comes beside it.")
@click.option("--runs", type=FILE, required=True, help="Table with one row per run (.csv).")
@click.option("--figure", type=FILE, required=True, help="PSNR over seconds (.png, and as .pdf).")
@click.argument("metrics", nargs=-1, required=True, type=FILE)
def study(baseline: str, target: Path, runs: Path, figure: Path, metrics: tuple[Path, ...]) -> None:
    """Compare variants with a baseline: test PSNR and SSIM beside the seconds of a training.

    METRICS are the metrics.json files of all their runs, each in its run's folder.
    """
    from r3gw.reporting.figures.stage import write_study

    write_study(metrics, baseline, target, runs, figure)
    wrote([target, runs, figure])


@cli.command(short_help="Draw the figures of a scene from its scored runs.")
@click.option("--name", required=True, help="Scene name, the beginning of the files' names.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--masks", type=FOLDER, required=True, help="Folder of the masks.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the figures.")
@click.argument("runs", nargs=-1, required=True, type=FOLDER)
def figures(name: str, scene: Path, masks: Path, target: Path, runs: tuple[Path, ...]) -> None:
    """Draw the figures of a scene from its evaluated runs; the first run is the main one."""
    from r3gw.reporting.figures.stage import scene_figures

    scene_figures(name, scene, masks, runs, target)
    wrote(target / f"{name}_*.png")


@cli.command(short_help="Write everything on one HTML page.")
@click.option("--results", type=FOLDER, required=True, help="Folder of tables and scenes.")
@click.option("--scene", "scenes", multiple=True, required=True, help="A scene; repeatable.")
@click.option(
    "--variant", "variants", multiple=True, required=True, help="Variants, the main one first."
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the runs shown.")
@click.option(
    "--pages", help="Folder of <scene>.html (`r3gw page`), from the report's own; they are linked."
)
@click.option("--target", type=FILE, required=True, help="The page (.html).")
def report(
    results: Path,
    scenes: tuple[str, ...],
    variants: tuple[str, ...],
    seed: int,
    pages: str | None,
    target: Path,
) -> None:
    """Write one HTML page: tables, test views, and every scene in detail.

    It needs no other file, but for the links to the pages that relight the scenes.
    """
    from r3gw.reporting.page.scene_page import SceneFolders
    from r3gw.reporting.page.stage import write_report

    folders = [
        SceneFolders(
            results / name,
            tuple(results / name / variant / f"seed{seed}" for variant in variants),
            None if pages is None else f"{pages}/{name}.html",
        )
        for name in scenes
    ]
    write_report(results, folders, target)
    wrote(target, OPEN_PAGE)
