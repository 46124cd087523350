"""The doctor: looks at everything that a configuration names and writes one page."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

from r3gw.doctor.findings import Findings
from r3gw.doctor.imported import (
    describe_lighting,
    describe_masks,
    describe_scene,
    describe_up,
)
from r3gw.doctor.page import page
from r3gw.doctor.pictures import up_picture
from r3gw.doctor.source import examine_source
from r3gw.doctor.training import Runs, describe_training
from r3gw.files import atomic_path, write_json
from r3gw.scene import load_scene
from r3gw.settings import Config, TrainSettings, load_config, run_settings
from r3gw.settings.validation import read_yaml

Stage = Literal["sources", "scenes"]
_TITLES = {"sources": "sources of the scenes", "scenes": "imported scenes and their masks"}


@dataclass(frozen=True)
class Diagnosis:
    """The page, and whether a run may begin."""

    text: str
    problems: tuple[str, ...]


def examine(
    config_file: Path, results: Path, target: Path, *, stage: Stage, defaults: Path
) -> Diagnosis:
    """Examine all scenes of a configuration.

    Args:
        config_file: The configuration (config.yaml or the same as JSON).
        results: Folder of results; its imported scenes are looked at.
        target: Folder of the page. Gets ``<stage>.md``, a picture per scene (stage scenes) and,
            only if there is no problem, ``<stage>.json``.
        stage: ``sources`` looks only at what scenes are made from, which takes seconds;
            ``scenes`` looks at sources and at imported scenes, masks and settings.
        defaults: Folder of train.yaml and variants.yaml.

    Raises:
        InputError: If the configuration itself is wrong.
    """
    config = load_config(read_yaml(config_file), str(config_file))
    record = target / f"{stage}.json"
    record.unlink(missing_ok=True)
    runs = Findings("settings")
    resolved = _runs(config, defaults, runs)
    sections = [runs]
    for name in sorted(config.scenes):
        findings = examine_source(name, config.scenes[name])
        if stage == "scenes":
            _examine_imported(results / name, target, resolved, findings)
        sections.append(findings)
    text = page(sections, _TITLES[stage])
    with atomic_path(target / f"{stage}.md") as path:
        path.write_text(text)
    problems = tuple(problem for section in sections for problem in section.problems)
    if not problems:
        write_json(record, {section.title: section.as_json() for section in sections})
    return Diagnosis(text, problems)


def _runs(config: Config, defaults: Path, findings: Findings) -> Runs:
    """Settings of every run of the configuration; a mistake in one is a problem."""
    files = {"train_file": defaults / "train.yaml", "variants_file": defaults / "variants.yaml"}
    runs: dict[tuple[str, int], TrainSettings] = {}
    wanted = [(variant, seed) for variant in config.variants for seed in config.seeds]
    extra = config.ablations
    wanted += [(variant, seed) for variant in extra.variants for seed in extra.seeds]
    for variant, seed in dict.fromkeys(wanted):
        settings = findings.attempt(partial(run_settings, config, variant, seed, **files))
        if settings is not None and variant in config.variants and seed in config.seeds:
            runs[variant, seed] = settings
    findings.facts["variants"] = ", ".join(config.variants)
    findings.facts["seeds"] = ", ".join(str(seed) for seed in config.seeds)
    lengths = sorted({settings.iterations for settings in runs.values()})
    findings.facts["iterations"] = ", ".join(f"{length:,}" for length in lengths)
    return runs


def _examine_imported(folder: Path, target: Path, runs: Runs, findings: Findings) -> None:
    scene_folder = folder / "scene"
    scene = findings.attempt(lambda: load_scene(scene_folder))
    if scene is None:
        return
    describe_scene(scene, scene_folder, findings)
    describe_masks(scene, folder / "masks", findings)
    describe_up(scene, findings)
    picture = f"{findings.title}_up.png"
    findings.attempt(lambda: up_picture(scene.views, scene_folder, target / picture))
    findings.picture = picture if (target / picture).is_file() else None
    describe_lighting(scene, scene_folder, findings)
    describe_training(scene, folder / "initial.npz", runs, findings)
