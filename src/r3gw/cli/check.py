"""Commands that look at data before a run: the doctor and the contact sheet of masks."""

import sys
from pathlib import Path
from typing import Literal

import click

from r3gw.cli.group import FILE, FOLDER, cli


@cli.command()
@click.option("--config", type=FILE, required=True, help="Configuration of the run.")
@click.option("--results", type=FOLDER, default=Path("results"), help="Folder of all results.")
@click.option(
    "--stage",
    type=click.Choice(["sources", "scenes"]),
    default="scenes",
    help="sources: only what scenes are made from; scenes: also what was imported.",
)
@click.option(
    "--defaults",
    type=FOLDER,
    default=Path("config"),
    help="Folder of train.yaml and variants.yaml.",
)
@click.option("--target", type=FOLDER, default=Path("results/doctor"), help="Folder of the page.")
def doctor(
    config: Path, results: Path, stage: Literal["sources", "scenes"], defaults: Path, target: Path
) -> None:
    """Say on one page what a run will find, need and fail on, before it begins.

    Prints the page, writes it as TARGET/STAGE.md, and exits with status 1 if anything would fail.
    """
    from r3gw.doctor import examine

    diagnosis = examine(config, results, target, stage=stage, defaults=defaults)
    click.echo(diagnosis.text)
    for problem in diagnosis.problems:
        click.echo(f"r3gw doctor: {problem}", err=True)
    if diagnosis.problems:
        sys.exit(1)


@cli.command("mask-sheet")
@click.option("--name", required=True, help="Scene name, the beginning of the file's name.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--masks", type=FOLDER, required=True, help="Folder of its masks.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the figures.")
def sheet(name: str, scene: Path, masks: Path, target: Path) -> None:
    """Draw all photos of a scene with their masks tinted, as NAME_masks.png."""
    from r3gw.reporting.masks import mask_sheet

    mask_sheet(name, scene, masks, target)
