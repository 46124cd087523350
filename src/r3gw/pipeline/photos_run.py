"""The workflow on one folder of photos, by one command: its settings, its call, what to look at."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import yaml

from r3gw.files import InputError, atomic_path
from r3gw.files.strict import read_yaml
from r3gw.pipeline.config import Config, load_config
from r3gw.reporting.methods import recommended
from r3gw.reporting.relit import read_relit
from r3gw.scene.selection import evenly

NUM_PICTURES = 3
SETTINGS = "photos.yaml"
HEADER = """\
# The settings of this run. Edit them and give the same command again: what depends on them is made
# again. config/README.md in the repository explains every key.
"""


def repository() -> Path:
    """The folder that holds the workflow, from which this package is run or was installed editably.

    Raises:
        InputError: If the package was installed without the workflow.
    """
    folder = Path(__file__).parents[3]
    if not (folder / "workflow" / "Snakefile").is_file():
        raise InputError(
            "the workflow is not beside this installation of r3gw; clone the repository and run "
            "'make' there, or follow docs/howto.md with the stages by hand"
        )
    return folder


def prepare(photos: Path, target: Path, defaults: Path) -> Path:
    """Write ``target/photos.yaml``: the settings of ``defaults``, for this folder of photos.

    A file that is there already is kept, so that its settings can be edited.

    Args:
        photos: The folder of photos, or the video.
        target: Folder of the results.
        defaults: The repository's ``config/photos.yaml``.

    Raises:
        InputError: If there are no such photos, or ``target`` belongs to others.
    """
    if not photos.exists():
        raise InputError(f"{photos}: no such folder or video; name one that holds your photos")
    path = target / SETTINGS
    if path.is_file():
        scenes = load_config(read_yaml(path), str(path)).scenes
        known = [entry.source.model_dump().get("path") for entry in scenes.values()]
        if str(photos.resolve()) not in known:
            raise InputError(
                f"{path}: is of other photos ({', '.join(map(str, known))}); name another --target"
            )
        return path
    values = read_yaml(defaults)
    for entry in values["scenes"].values():
        entry["path"] = str(photos.resolve())
    load_config(values, str(defaults))
    target.mkdir(parents=True, exist_ok=True)
    with atomic_path(path) as temporary:
        temporary.write_text(HEADER + yaml.safe_dump(values, sort_keys=False))
    return path


def run_workflow(settings: Path, cores: int, options: Sequence[str]) -> None:
    """Run the workflow beside ``settings``; what is made already is not made again.

    Args:
        settings: The configuration; results go to ``results/`` beside it.
        cores: How many cores it may use.
        options: More for Snakemake.

    Raises:
        InputError: If it does not come to its end.
    """
    target = settings.parent.resolve()
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(repository() / "Snakefile")]
    command += ["--directory", str(target), "--configfile", str(settings.resolve())]
    if exit_status([*command, "--cores", str(cores), *options, "all"]) != 0:
        raise InputError(
            f"the workflow stopped for the reason above; what it finished is kept in {target}, and "
            "the same command goes on from there"
        )


def exit_status(command: Sequence[str]) -> int:
    """Run a command to its end and return its exit status.

    Ctrl-C reaches the command as well, which is given the time to end its own jobs.
    """
    with subprocess.Popen(command) as process:
        while True:
            try:
                return process.wait()
            except KeyboardInterrupt:
                continue


def to_look_at(settings: Path) -> list[tuple[str, Path]]:
    """What to look at after a run, and what each is: the report, the page, three pictures.

    The pictures show one view under the light of three photos.

    Raises:
        InputError: If the run is not complete.
    """
    config = load_config(read_yaml(settings), str(settings))
    results = settings.parent / "results"
    found = [("report", results / "report.html")]
    for scene in config.scenes:
        found.append(("to relight in a browser", results / "pages" / f"{scene}.html"))
        found += _pictures(_run(config, results / scene) / "metrics" / "relit")
    return found


def _run(config: Config, folder: Path) -> Path:
    return folder / recommended(config.variants) / f"seed{config.seeds[0]}"


def _pictures(folder: Path) -> list[tuple[str, Path]]:
    relit = read_relit(folder)
    view = relit.views[0]
    return [
        (
            f"{view} in the light of {relit.photos[number]}",
            folder / "learned" / f"{view}_{number}.png",
        )
        for number in evenly(range(len(relit.photos)), NUM_PICTURES)
    ]
