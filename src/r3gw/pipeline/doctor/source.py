"""The cheap half: is what a scene is made from there and readable, before it is imported?"""

from pathlib import Path

from r3gw.benchmark.work import PLACES
from r3gw.files import InputError
from r3gw.importing.completeness import require_complete
from r3gw.importing.formats import reader_of
from r3gw.importing.settings import SyntheticScene
from r3gw.masks.network import SegmentationNetwork
from r3gw.masks.settings import MaskSources, chain
from r3gw.pipeline.doctor.findings import Findings
from r3gw.pipeline.scene_entry import SceneEntry


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
    findings.facts.update(findings.attempt(reader_of(entry.source, source).facts) or {})


def _mask_sources(settings: MaskSources) -> None:
    """The network and the folder of label maps that the entry names."""
    if settings.label_maps is not None and not Path(settings.label_maps).is_dir():
        raise InputError(f"{settings.label_maps}: no such folder; correct 'label_maps'")
    named = {*chain(settings.sky_masks), *chain(settings.valid_masks)}
    if "network" in named and settings.network is not None:
        SegmentationNetwork(settings.network)
