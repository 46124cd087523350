"""The command line: ``python -m r3gw STAGE``, one subcommand per stage of the workflow."""

import json
import logging
import sys
from pathlib import Path
from typing import Any, Literal

import click

from r3gw.files import InputError
from r3gw.settings.validation import validated

FOLDER = click.Path(file_okay=False, path_type=Path)
FILE = click.Path(dir_okay=False, path_type=Path)
THREADS = click.option("--threads", type=click.IntRange(1), default=1, help="CPU threads.")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="r3gw")
def cli() -> None:
    """Relightable 3D Gaussians for outdoor scenes in the wild.

    Each stage reads and writes files; `snakemake --cores 2 all` runs them in order.
    """
    # Libraries only warn: fontTools alone writes hundreds of INFO lines per figure.
    logging.basicConfig(level=logging.WARNING, format="%(message)s", stream=sys.stderr)
    logging.getLogger("r3gw").setLevel(logging.INFO)


@cli.command()
@click.option("--entry", required=True, help="The scene's config entry as JSON.")
@click.option("--target", type=FOLDER, required=True, help="Folder to write (layout A).")
def generate(entry: str, target: Path) -> None:
    """Render a scene of the embedded benchmark: photos, masks, SfM model, ground truth."""
    from r3gw.settings import SyntheticScene
    from r3gw.synthetic import generate as run

    scene = validated(SyntheticScene, _json(entry, "--entry"), "--entry")
    run(
        scene.building,
        scene.seed,
        target,
        size_px=(scene.width_px, scene.height_px),
        train_views=scene.train_views,
        test_views=scene.test_views,
        samples=scene.samples,
    )


@cli.command("import")
@click.option("--scene", required=True, help="Name of the scene.")
@click.option("--entry", required=True, help="The scene's config entry as JSON.")
@click.option("--source", type=FOLDER, required=True, help="Dataset folder or folder of photos.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the imported scene.")
@THREADS
def import_scene(scene: str, entry: str, source: Path, target: Path, threads: int) -> None:
    """Import a dataset, or reconstruct a folder of photos, into one scene format."""
    from r3gw.settings.config import parse_scene
    from r3gw.sfm import import_scene as run

    settings = parse_scene(_json(entry, "--entry"), f"scene '{scene}'")
    run(scene, settings, source, target, num_threads=threads)


@cli.command()
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the masks.")
@click.option(
    "--sky",
    type=click.Choice(["given", "classical", "given-or-classical"]),
    required=True,
    help="Where sky masks come from.",
)
def masks(
    scene: Path, target: Path, sky: Literal["given", "classical", "given-or-classical"]
) -> None:
    """Check given masks and make missing ones."""
    from r3gw.masks import make_masks

    make_masks(scene, target, sky=sky)


@cli.command()
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--sky", required=True, help="Settings of the sky's initial points as JSON.")
@click.option("--target", type=FILE, required=True, help="initial.npz to write.")
def initialise(scene: Path, sky: str, target: Path) -> None:
    """Place the initial foreground points and the sky hemisphere."""
    from r3gw.gaussians.stage import run_initialise
    from r3gw.settings.train import SkySettings

    run_initialise(scene, validated(SkySettings, _json(sky, "--sky"), "--sky"), target)


@cli.command()
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--masks", type=FOLDER, required=True, help="Folder of the masks.")
@click.option("--initial", type=FILE, required=True, help="initial.npz")
@click.option("--settings", type=FILE, required=True, help="Resolved settings (JSON).")
@click.option("--name", required=True, help="Scene name, for the record.")
@click.option("--variant", required=True, help="Variant name, for the record.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the run.")
@THREADS
def train(
    scene: Path,
    masks: Path,
    initial: Path,
    settings: Path,
    name: str,
    variant: str,
    target: Path,
    threads: int,
) -> None:
    """Train one variant on one scene; writes model.pt, history.csv and run.json."""
    from r3gw.training.run import run_training

    run_training(
        scene, masks, initial, settings, target, scene=name, variant=variant, num_threads=threads
    )


@cli.command()
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--masks", type=FOLDER, required=True, help="Folder of the masks.")
@click.option("--model", type=FILE, required=True, help="model.pt of the run.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the evaluation.")
@THREADS
def evaluate(scene: Path, masks: Path, model: Path, target: Path, threads: int) -> None:
    """Score a trained model under every protocol and draw its pictures."""
    from r3gw.evaluation.evaluate import evaluate_run

    evaluate_run(scene, masks, model, target, num_threads=threads)


@cli.command()
@click.option("--kind", type=click.Choice(["table1", "ablations"]), required=True)
@click.option("--published", type=FILE, help="Published figures to show beside ours.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the tables.")
@click.argument("metrics", nargs=-1, required=True, type=FILE)
def tables(kind: str, published: Path | None, target: Path, metrics: tuple[Path, ...]) -> None:
    """Make tables from the metrics.json files of any number of runs."""
    from r3gw.reporting import tables as make

    if kind == "table1":
        make.runs_table(metrics, target / "runs.csv")
        make.decomposition(metrics, target / "decomposition.csv")
        make.table1(metrics, published, target / "table1.csv")
    else:
        make.runs_table(metrics, target / "ablation_runs.csv")
        make.ablations(metrics, target / "ablations.csv")


@cli.command()
@click.option("--name", required=True, help="Scene name, the beginning of the files' names.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the figures.")
@click.argument("runs", nargs=-1, required=True, type=FOLDER)
def figures(name: str, scene: Path, target: Path, runs: tuple[Path, ...]) -> None:
    """Draw the figures of a scene from its evaluated runs; the first run is the main one."""
    from r3gw.reporting.figures import scene_figures

    scene_figures(name, scene, runs, target)


@cli.command()
@click.option("--model", type=FILE, required=True, help="model.pt of the run.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--view", required=True, help="Photo whose camera is used.")
@click.option("--env-map", type=FILE, help="Environment map: .exr, .hdr, .jpg or .png.")
@click.option("--yaw-deg", type=float, default=0.0, help="Turn of the map about the vertical.")
@click.option("--exposure", type=float, default=1.0, help="Factor on the map.")
@click.option("--light-of", help="Training photo whose learned light is used instead of a map.")
@click.option("--sky", help="white, or learned:PHOTO. Default: white under a map.")
@click.option("--output", type=FILE, required=True, help="Picture to write (.png or .jpg).")
def relight(
    model: Path,
    scene: Path,
    view: str,
    env_map: Path | None,
    yaw_deg: float,
    exposure: float,
    light_of: str | None,
    sky: str | None,
    output: Path,
) -> None:
    """Render a photo's view under an environment map or under another photo's light."""
    from r3gw.evaluation.relight import relight_view

    relight_view(
        model,
        scene,
        view,
        output,
        env_map=env_map,
        yaw_deg=yaw_deg,
        exposure=exposure,
        light_of=light_of,
        sky=sky,
    )


def _json(text: str, option: str) -> dict[str, Any]:
    try:
        value = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{option}: not readable as JSON ({error})") from None
    if not isinstance(value, dict):
        raise InputError(f"{option}: expected a JSON object, got {text}")
    return value


def main() -> None:
    """Run the command line; bad input ends in one sentence and exit status 2."""
    try:
        cli()
    except InputError as error:
        click.echo(f"r3gw: {error}", err=True)
        sys.exit(2)


if __name__ == "__main__":
    main()
