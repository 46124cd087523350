"""The cheap half: is what a scene is made from there and readable, before it is imported?"""

from pathlib import Path

from r3gw.benchmark.work import PLACES
from r3gw.files import InputError
from r3gw.importing.completeness import require_complete
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.folders import MASK_FOLDERS
from r3gw.importing.named_files import pictures_by_key
from r3gw.importing.settings import PhotosScene, SyntheticScene
from r3gw.masks.network import SegmentationNetwork
from r3gw.masks.settings import MaskSources, chain
from r3gw.pipeline.doctor.findings import Findings
from r3gw.pipeline.scene_entry import SceneEntry

_LEAST_PHOTOS = 3


def examine_source(name: str, entry: SceneEntry) -> Findings:
    """Look at the source of a scene: names of files, lists, environment maps; no photo is read.

    Args:
        name: The scene's name in the configuration.
        entry: Its entry there.
    """
    settings = entry.source
    findings = Findings(name, {"format": settings.format})
    if isinstance(settings, SyntheticScene):
        findings.facts["source"] = "made by r3gw itself"
        findings.attempt(lambda: _known_building(name, settings))
    else:
        findings.facts["source"] = settings.path
        _examine_files(name, entry, Path(settings.path), findings)
    findings.attempt(lambda: _mask_sources(entry.masks))
    return findings


def _known_building(name: str, settings: SyntheticScene) -> None:
    if settings.building not in PLACES:
        known = ", ".join(PLACES)
        raise InputError(
            f"scene '{name}': no building is named '{settings.building}'; there are: {known}"
        )


def _examine_files(name: str, entry: SceneEntry, source: Path, findings: Findings) -> None:
    before = len(findings.problems)
    findings.attempt(lambda: require_complete(name, entry.source, source, entry.given_masks))
    if len(findings.problems) > before:
        return
    if isinstance(entry.source, PhotosScene):
        if source.is_dir():
            findings.attempt(lambda: _enough_photos(source, findings))
        return
    entries = findings.attempt(lambda: read_evaluation(source / "eval_files"))
    if entries is not None:
        findings.facts["views with an environment map"] = str(len(entries))


def _enough_photos(source: Path, findings: Findings) -> None:
    beside = tuple(name for name, _ in MASK_FOLDERS.values())
    photos = pictures_by_key(source, without=beside)
    findings.facts["photos"] = str(len(photos))
    if len(photos) < _LEAST_PHOTOS:
        found = "1 photo is" if len(photos) == 1 else f"{len(photos)} photos are"
        raise InputError(
            f"{source}: {found} here, but at least {_LEAST_PHOTOS} that overlap are needed"
        )


def _mask_sources(settings: MaskSources) -> None:
    """The network and the folder of label maps that the entry names."""
    if settings.label_maps is not None and not Path(settings.label_maps).is_dir():
        raise InputError(f"{settings.label_maps}: no such folder; correct 'label_maps'")
    named = {*chain(settings.sky_masks), *chain(settings.valid_masks)}
    if "network" in named and settings.network is not None:
        SegmentationNetwork(settings.network)
