"""Commands that look at data before a run: the doctor, its gates, the contact sheet of masks."""

import sys
from collections.abc import Sequence
from pathlib import Path

import click

from r3gw.cli.group import FILE, FOLDER, cli, json_object
from r3gw.files import write_json


@cli.command()
@click.option("--config", type=FILE, required=True, help="Configuration of the run.")
@click.option(
    "--results", type=FOLDER, default=Path("results"), show_default=True, help="Of all scenes."
)
@click.option(
    "--defaults",
    type=FOLDER,
    default=Path("config"),
    show_default=True,
    help="Folder of train.yaml and variants.yaml.",
)
@click.option(
    "--target",
    type=FOLDER,
    default=Path("results/doctor"),
    show_default=True,
    help="Folder of the page.",
)
def doctor(config: Path, results: Path, defaults: Path, target: Path) -> None:
    """Say on one page what a run will find, need and fail on, before it begins.

    Looks at the sources of all scenes and at what is already imported. Prints the page, writes it
    as TARGET/doctor.md, and exits with status 1 if anything would fail.
    """
    from r3gw.doctor import examine

    diagnosis = examine(config, results, target, defaults=defaults)
    click.echo(diagnosis.text)
    _stop_at(diagnosis.problems)


@cli.command("check-source")
@click.option("--scene", required=True, help="Name of the scene.")
@click.option("--entry", required=True, help="The scene's config entry as JSON.")
@click.option("--target", type=FILE, required=True, help="JSON file to write if all is well.")
def check_source(scene: str, entry: str, target: Path) -> None:
    """Refuse a scene whose source would fail to import; looks at names and lists only."""
    from r3gw.doctor import examine_source
    from r3gw.settings.config import parse_scene

    findings = examine_source(scene, parse_scene(json_object(entry, "--entry"), f"scene '{scene}'"))
    _stop_at(findings.problems)
    write_json(target, findings.as_json())


@cli.command("check-scene")
@click.option("--scene", required=True, help="Name of the scene.")
@click.option("--results", type=FOLDER, required=True, help="Folder of all scenes' results.")
@click.option("--target", type=FILE, required=True, help="JSON file to write if all is well.")
def check_scene(scene: str, results: Path, target: Path) -> None:
    """Refuse an imported scene whose training or evaluation would fail."""
    from r3gw.doctor import Findings, examine_scene

    findings = Findings(scene)
    examine_scene(results / scene, findings)
    _stop_at(findings.problems)
    write_json(target, findings.as_json())


def _stop_at(problems: Sequence[str]) -> None:
    """Print problems, one a line, and exit with status 1 if there are any."""
    for problem in problems:
        click.echo(f"r3gw doctor: {problem}", err=True)
    if problems:
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
