"""What every format's reader offers: what is missing, what can be said before, and the scene."""

from abc import ABC, abstractmethod
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from r3gw.importing.evaluation_config import missing_evaluation_files, read_evaluation
from r3gw.importing.source import SourceScene

Entry = TypeVar("Entry")


@dataclass(frozen=True)
class Effort:
    """How a reader may work.

    Attributes:
        folder: A folder for temporary files; it lives until the scene is written.
        num_threads: Threads for features and matching.
        seed: Seed of all random sampling.
    """

    folder: Path
    num_threads: int
    seed: int = 0


class Reader(ABC, Generic[Entry]):
    """Reads one format. A new one is a class here, its settings, and a line in the registry."""

    def __init__(self, settings: Entry, source: Path) -> None:
        """Keep what to read.

        Args:
            settings: The scene's entry in the configuration.
            source: Folder (or video) of the scene, which exists.
        """
        self.settings = settings
        self.source = source

    @abstractmethod
    def missing(self, given: Collection[str] = ()) -> list[str]:
        """Names of the files that the scene needs and does not have, in a fixed order.

        Only names are looked at, so that it can run before anything else does.

        Args:
            given: Kinds of masks that NeRF-OSR's photos must come with; the mask stage makes the
                others if they are missing.

        Raises:
            InputError: If a list that names the files is itself unreadable.
        """

    @abstractmethod
    def read(self, effort: Effort) -> SourceScene:
        """Views and points in the source's own frame.

        Raises:
            InputError: On a missing file, a wrong size or an unreadable value; names it.
        """

    def facts(self) -> dict[str, str]:
        """What the doctor says of a complete source before it is imported.

        Raises:
            InputError: If something that is cheap to look at is wrong.
        """
        entries = read_evaluation(self.source / "eval_files")
        return {"views with an environment map": str(len(entries))}

    def missing_evaluation(self) -> list[str]:
        """What ``eval_files/test_config.py`` names and is not there."""
        return [f"eval_files: {n}" for n in missing_evaluation_files(self.source / "eval_files")]
