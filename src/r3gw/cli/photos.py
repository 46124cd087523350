"""The command for people in a hurry: a folder of photos in, a relightable scene out."""

from pathlib import Path

import click

from r3gw.cli.group import FOLDER, cli


@cli.command(
    context_settings={"ignore_unknown_options": True},
    short_help="Make a relightable scene of a folder of photos or a video.",
)
@click.argument("photos", type=click.Path(path_type=Path))
@click.argument("options", nargs=-1, type=click.UNPROCESSED, metavar="[SNAKEMAKE OPTIONS]")
@click.option(
    "--target",
    type=FOLDER,
    help="Folder of settings and results; default: <name of the folder>_r3gw, here.",
)
@click.option(
    "--cores", type=click.IntRange(1), default=2, show_default=True, help="Cores to use at most."
)
def photos(photos: Path, options: tuple[str, ...], target: Path | None, cores: int) -> None:
    """Make a relightable scene of a folder of photos, or of a video: the whole workflow.

    It writes the settings of config/photos.yaml to photos.yaml in the target, runs Snakemake there,
    and names what to look at. The same command goes on where an interrupted one stopped; edited
    settings make again what depends on them. Options of Snakemake, such as --dry-run, are passed
    on.
    """
    from r3gw.pipeline.photos_run import prepare, repository, run_workflow, to_look_at

    folder = target or Path(f"{photos.resolve().stem}_r3gw")
    settings = prepare(photos, folder, repository() / "config" / "photos.yaml")
    run_workflow(settings, cores, options)
    if not (folder / "results" / "report.html").is_file():
        return  # a dry run
    for what, path in to_look_at(settings):
        click.echo(f"{what}: {path}")
