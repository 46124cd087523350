"""The doctor: looks at everything that a configuration names and writes one page."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from r3gw.files import atomic_path, write_json
from r3gw.files.strict import read_yaml
from r3gw.model.initial import load_initial
from r3gw.pipeline.config import Config, load_config, run_settings
from r3gw.pipeline.doctor.findings import Findings
from r3gw.pipeline.doctor.imported import (
    describe_lighting,
    describe_masks,
    describe_scene,
    describe_up,
)
from r3gw.pipeline.doctor.page import page
from r3gw.pipeline.doctor.pictures import up_picture
from r3gw.pipeline.doctor.source import examine_source
from r3gw.pipeline.doctor.training import SceneSize, describe_training
from r3gw.scene import Scene, load_scene
from r3gw.training.settings import TrainSettings


@dataclass(frozen=True)
class Diagnosis:
    """The page, and whether a run may begin."""

    text: str
    problems: tuple[str, ...]


def examine(config_file: Path, results: Path, target: Path, *, defaults: Path) -> Diagnosis:
    """Examine all scenes of a configuration.

    Args:
        config_file: The configuration (config.yaml or the same as JSON).
        results: Folder of results; what is already imported there is looked at.
        target: Folder of the page. Gets ``doctor.md``, a picture per imported scene and, only if
            there is no problem, ``doctor.json``.
        defaults: Folder of train.yaml and variants.yaml.

    Raises:
        InputError: If the configuration itself is wrong.
    """
    config = load_config(read_yaml(config_file), str(config_file))
    record = target / "doctor.json"
    record.unlink(missing_ok=True)
    settings = Findings("settings")
    runs = _runs(config, defaults, settings)
    sections = [settings]
    for name in sorted(config.scenes):
        findings = examine_source(name, config.scenes[name])
        if (results / name / "scene" / "scene.json").is_file():
            scene, size = examine_scene(results / name, findings)
            if scene is not None:
                _draw_up(scene, results / name / "scene", target, findings)
            if size is not None and runs:
                describe_training(size, runs, findings)
        else:
            findings.facts["imported"] = "not yet"
        sections.append(findings)
    text = page(sections)
    with atomic_path(target / "doctor.md") as path:
        path.write_text(text)
    if not (problems := tuple(problem for section in sections for problem in section.problems)):
        write_json(record, {section.title: section.as_json() for section in sections})
    return Diagnosis(text, problems)


def examine_scene(folder: Path, findings: Findings) -> tuple[Scene | None, SceneSize | None]:
    """Look at an imported scene, its masks and initial points; None is what cannot be read.

    Args:
        folder: Results of the scene: scene/, masks/ and initial.npz.
        findings: Gets what was found.
    """
    scene = findings.attempt(partial(load_scene, folder / "scene"))
    if scene is None:
        return None, None
    describe_scene(scene, folder / "scene", findings)
    describe_masks(scene, folder / "masks", findings)
    describe_up(scene, findings)
    describe_lighting(scene, folder / "scene", findings)
    return scene, _size(scene, folder / "initial.npz", findings)


def _size(scene: Scene, initial: Path, findings: Findings) -> SceneSize | None:
    points = findings.attempt(partial(load_initial, initial))
    photos = scene.split("train")
    if points is None or not photos:
        return None
    return SceneSize(
        foreground=len(points.foreground),
        sky=len(points.sky_angles),
        photos=len(photos),
        photo_pixels=sum(view.width * view.height for view in photos),
    )


def _draw_up(scene: Scene, scene_folder: Path, target: Path, findings: Findings) -> None:
    picture = f"{findings.title}_up.png"
    findings.attempt(partial(up_picture, scene.views, scene_folder, target / picture))
    findings.picture = picture if (target / picture).is_file() else None


def _runs(config: Config, defaults: Path, findings: Findings) -> list[TrainSettings]:
    """Settings of every run of the configuration; a mistake in one is a problem."""
    files = {"train_file": defaults / "train.yaml", "variants_file": defaults / "variants.yaml"}
    runs: list[TrainSettings] = []
    wanted = [(variant, seed) for variant in config.variants for seed in config.seeds]
    extra = config.ablations
    wanted += [(variant, seed) for variant in extra.variants for seed in extra.seeds]
    for variant, seed in dict.fromkeys(wanted):
        settings = findings.attempt(partial(run_settings, config, variant, seed, **files))
        if settings is not None and variant in config.variants and seed in config.seeds:
            runs.append(settings)
    findings.facts["variants"] = ", ".join(config.variants)
    findings.facts["seeds"] = ", ".join(str(seed) for seed in config.seeds)
    lengths = sorted({settings.iterations for settings in runs})
    findings.facts["iterations"] = ", ".join(f"{length:,}" for length in lengths)
    return runs
