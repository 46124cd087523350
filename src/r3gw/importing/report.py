"""sfm_report.json, for every format: what came in, what was left out and why."""

import logging
from collections import Counter
from pathlib import Path

from r3gw.files import write_json
from r3gw.importing.named_files import listed
from r3gw.importing.source import SourceScene

_LOG = logging.getLogger(__name__)


def write_report(found: SourceScene, source_format: str, target: Path) -> None:
    """Write ``target/sfm_report.json`` and say in the log what is not in the scene.

    Args:
        found: What the reader found.
        source_format: The key ``format`` of the scene's entry.
        target: The scene folder.
    """
    for note in found.notes:
        _LOG.warning("%s", note)
    if found.left_out:
        reasons = Counter(found.left_out.values())
        shown = "; ".join(
            f"{count} {reason} ({listed(_with(found, reason), 3)})"
            for reason, count in sorted(reasons.items())
        )
        _LOG.warning(
            "%d of %d photos are left out: %s",
            len(found.left_out),
            len(found.left_out) + len(found.views),
            shown,
        )
    registered = sorted(view.path for view in found.views)
    report = {
        "format": source_format,
        "photos": len(registered) + len(found.left_out),
        "registered": registered,
        "not_registered": dict(found.left_out),
        "points": len(found.points.xyz),
        "notes": list(found.notes),
    }
    write_json(target / "sfm_report.json", report | dict(found.facts))


def _with(found: SourceScene, reason: str) -> list[str]:
    return [path for path, why in found.left_out.items() if why == reason]
