"""Commands about one run: training it and scoring it."""

from pathlib import Path

import click

from r3gw.cli.group import FILE, FOLDER, THREADS, cli
from r3gw.cli.told import wrote


@cli.command(short_help="Train one variant on one scene.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--masks", type=FOLDER, required=True, help="Folder of the masks.")
@click.option("--initial", type=FILE, required=True, help="initial.npz")
@click.option("--settings", type=FILE, required=True, help="Resolved settings (JSON).")
@click.option("--name", required=True, help="Scene name, for the record.")
@click.option("--variant", required=True, help="Variant name, for the record.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the run.")
@THREADS
@click.option(
    "--checkpoint-seconds",
    type=click.FloatRange(min=0),
    default=300.0,
    show_default=True,
    envvar="R3GW_CHECKPOINT_SECONDS",
    show_envvar=True,
    help="Seconds between checkpoints.",
)
@click.option("--fresh", is_flag=True, help="Begin anew even where a checkpoint stands.")
@click.option(
    "--snapshot",
    "snapshots",
    type=click.IntRange(min=1),
    multiple=True,
    metavar="N",
    help="Also write the run after N iterations, to snapshots/N; may be given several times.",
)
def train(
    scene: Path,
    masks: Path,
    initial: Path,
    settings: Path,
    name: str,
    variant: str,
    target: Path,
    threads: int,
    checkpoint_seconds: float,
    fresh: bool,
    snapshots: tuple[int, ...],
) -> None:
    """Train one variant on one scene; writes model.safetensors, history.csv and run.json."""
    from r3gw.training.run import RunFiles, run_training

    run_training(
        RunFiles(scene, masks, initial, settings, target),
        scene=name,
        variant=variant,
        num_threads=threads,
        checkpoint_s=checkpoint_seconds,
        fresh=fresh,
        snapshots=snapshots,
    )
    wrote(target / "model.safetensors", f"see it by `r3gw view {target} --scene {scene}`")


@cli.command(short_help="Score a trained model and draw its pictures.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--masks", type=FOLDER, required=True, help="Folder of the masks.")
@click.option("--model", type=FILE, required=True, help="model.safetensors of the run.")
@click.option("--target", type=FOLDER, required=True, help="Folder of the evaluation.")
@THREADS
def evaluate(scene: Path, masks: Path, model: Path, target: Path, threads: int) -> None:
    """Score a trained model under every protocol and draw its pictures."""
    from r3gw.evaluation.stage import evaluate_run

    evaluate_run(scene, masks, model, target, num_threads=threads)
    wrote(target / "metrics.json", "its pictures are in renders/ beside it")
