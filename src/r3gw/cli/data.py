"""Commands that make and check data: from a dataset or photos to masks and initial points."""

from pathlib import Path

import click

from r3gw.cli.group import FILE, FOLDER, THREADS, cli, json_object
from r3gw.cli.told import wrote

SOURCE = click.Path(path_type=Path)


@cli.command(short_help="Render a scene of the embedded benchmark.")
@click.option("--settings", required=True, help="What to render, as JSON (config/README.md).")
@click.option("--target", type=FOLDER, required=True, help="Folder to write.")
@click.option(
    "--processes", type=click.IntRange(min=1), default=1, help="How many processes render at once."
)
def generate(settings: str, target: Path, processes: int) -> None:
    """Render a scene of the embedded benchmark: photos, masks, SfM model, ground truth."""
    from r3gw.benchmark.generate import generate as run
    from r3gw.benchmark.settings import BenchmarkSettings
    from r3gw.files.strict import validated

    scene = validated(BenchmarkSettings, json_object(settings, "--settings"), "--settings")
    run(
        scene.building,
        scene.seed,
        target,
        size_px=(scene.width_px, scene.height_px),
        train_views=scene.train_views,
        test_views=scene.test_views,
        samples=scene.samples,
        visits=scene.visits,
        num_devices=scene.devices,
        is_denoised=scene.denoise,
        point_candidates=scene.points,
        num_processes=processes,
    )
    wrote(target, "photos, masks, cameras and ground truth")


@cli.command("import", short_help="Import a dataset, or find the cameras of photos.")
@click.option("--scene", required=True, help="Name of the scene.")
@click.option(
    "--entry", required=True, help="Keys of the scene's config entry about its source, as JSON."
)
@click.option(
    "--source", type=SOURCE, required=True, help="Dataset folder, folder of photos, or a video."
)
@click.option("--target", type=FOLDER, required=True, help="Folder of the imported scene.")
@THREADS
def import_scene(scene: str, entry: str, source: Path, target: Path, threads: int) -> None:
    """Import a dataset, or reconstruct a folder of photos, into one scene format.

    The format is in the entry: nerf-osr, nerf-osr-original, colmap, nerfstudio or photos
    (config/README.md). Missing files are named before anything is read.
    """
    from r3gw.importing.settings import parse_scene
    from r3gw.importing.stage import import_scene as run

    settings = parse_scene(json_object(entry, "--entry"), f"scene '{scene}'")
    run(scene, settings, source, target, num_threads=threads)
    wrote(target / "scene.json", "cameras; photos and points lie beside it")


@cli.command()
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the masks.")
@click.option("--sources", required=True, help="Where masks come from, as JSON: the entry's keys.")
def masks(scene: Path, target: Path, sources: str) -> None:
    """Check given masks and make missing ones."""
    from r3gw.files.strict import validated
    from r3gw.masks.settings import MaskSources
    from r3gw.masks.stage import make_masks

    make_masks(
        scene, target, validated(MaskSources, json_object(sources, "--sources"), "--sources")
    )
    wrote(target / "masks.json", "look at the masks by `r3gw mask-sheet`")


@cli.command(short_help="Place the first points of foreground and sky.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--sky", required=True, help="Settings of the sky's initial points as JSON.")
@click.option(
    "--masks", "masked", type=FOLDER, help="Folder of its masks: stereo shall add points."
)
@click.option("--target", type=FILE, required=True, help="initial.npz to write.")
def initialise(scene: Path, sky: str, masked: Path | None, target: Path) -> None:
    """Place the initial foreground points and the sky hemisphere."""
    from r3gw.files.strict import validated
    from r3gw.model.settings import SkySettings
    from r3gw.model.stage import run_initialise

    settings = validated(SkySettings, json_object(sky, "--sky"), "--sky")
    run_initialise(scene, settings, target, masked)
    wrote(target)
