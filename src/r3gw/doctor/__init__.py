"""Checks everything that a run will need before hours of CPU go into it."""

from r3gw.doctor.doctor import examine, examine_scene
from r3gw.doctor.findings import Findings
from r3gw.doctor.source import examine_source

__all__ = ["Findings", "examine", "examine_scene", "examine_source"]
