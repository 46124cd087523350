"""Commands that look at data before a run: the doctor, its gates, the contact sheet of masks."""

import sys
from collections.abc import Sequence
from pathlib import Path

import click

from r3gw.cli.group import FILE, FOLDER, cli, json_object
from r3gw.cli.told import wrote
from r3gw.files import write_json


@cli.command(short_help="Say what a run will find, need and fail on.")
@click.option("--config", type=FILE, required=True, help="Configuration of the run.")
@click.option(
    "--results",
    type=FOLDER,
    default=Path("results"),
    show_default=True,
    help="Folder of the results of all scenes.",
)
@click.option(
    "--defaults",
    type=FOLDER,
    help="Folder of train.yaml and variants.yaml; default: config here, or that of the clone.",
)
@click.option(
    "--target",
    type=FOLDER,
    default=Path("results/doctor"),
    show_default=True,
    help="Folder of the page.",
)
def doctor(config: Path, results: Path, defaults: Path | None, target: Path) -> None:
    """Say on one page what a run will find, need and fail on, before it begins.

    Looks at the sources of all scenes and at what is already imported. Prints the page, writes it
    as TARGET/doctor.md, and exits with status 1 if anything would fail.
    """
    from r3gw.pipeline.doctor.doctor import examine
    from r3gw.pipeline.photos_run import repository

    if defaults is None:
        here = Path("config")
        defaults = here if (here / "train.yaml").is_file() else repository() / "config"
    diagnosis = examine(config, results, target, defaults=defaults)
    click.echo(diagnosis.text)
    _stop_at(diagnosis.problems)
    wrote(target / "doctor.md", "the same page, with pictures of what is imported")


@cli.command("doctor-sources", short_help="Refuse scenes whose source would fail to import.")
@click.option("--entries", required=True, help="Config entries by scene name, as JSON.")
def doctor_sources(entries: str) -> None:
    """Refuse scenes whose source would fail to import; looks at names and lists only."""
    from r3gw.pipeline.doctor.source import examine_source
    from r3gw.pipeline.scene_entry import parse_entry

    found = [
        examine_source(name, parse_entry(entry, f"scene '{name}'"))
        for name, entry in json_object(entries, "--entries").items()
    ]
    _stop_at([problem for findings in found for problem in findings.problems])


@cli.command("doctor-scene", short_help="Refuse a scene whose training would fail.")
@click.option("--scene", required=True, help="Name of the scene.")
@click.option("--results", type=FOLDER, required=True, help="Folder of all scenes' results.")
@click.option("--target", type=FILE, required=True, help="JSON file to write if all is well.")
def doctor_scene(scene: str, results: Path, target: Path) -> None:
    """Refuse an imported scene whose training or evaluation would fail."""
    from r3gw.pipeline.doctor.doctor import examine_scene
    from r3gw.pipeline.doctor.findings import Findings

    findings = Findings(scene)
    _, size = examine_scene(results / scene, findings)
    _stop_at(findings.problems)
    assert size is not None  # a scene without it is a problem
    write_json(target, findings.as_json() | {"size": size.model_dump()})


@cli.command("doctor-run", short_help="Refuse a training that does not fit into memory.")
@click.option("--name", required=True, help="The run as messages call it: scene/variant/seed.")
@click.option("--checked", type=FILE, required=True, help="What doctor-scene wrote of its scene.")
@click.option("--settings", type=FILE, required=True, help="Resolved settings (JSON).")
def doctor_run(name: str, checked: Path, settings: Path) -> None:
    """Refuse a training that this machine cannot hold in memory."""
    from r3gw.pipeline.doctor.findings import Findings
    from r3gw.pipeline.doctor.training import describe_training, read_size
    from r3gw.training.settings import load_train_settings

    findings = Findings(name)
    describe_training(read_size(checked), [load_train_settings(settings)], findings)
    _stop_at(findings.problems)


def _stop_at(problems: Sequence[str]) -> None:
    """Print problems, one a line, and exit with status 1 if there are any."""
    for problem in problems:
        click.echo(f"r3gw doctor: {problem}", err=True)
    if problems:
        sys.exit(1)


@cli.command("mask-sheet", short_help="Draw all photos of a scene with their masks tinted.")
@click.option("--name", required=True, help="Scene name, the beginning of the file's name.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--masks", type=FOLDER, required=True, help="Folder of its masks.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the figures.")
def sheet(name: str, scene: Path, masks: Path, target: Path) -> None:
    """Draw all photos of a scene with their masks tinted, as NAME_masks.png."""
    from r3gw.reporting.figures.mask_sheet import mask_sheet

    mask_sheet(name, scene, masks, target)
    wrote(target / f"{name}_masks.png")
