"""From photos or a dataset to the scene on disk: readers per format, one writer."""

from r3gw.importing.stage import import_scene

__all__ = ["import_scene"]
