"""What the doctor found out about a scene: facts, warnings, problems."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

from r3gw.files import InputError

Result = TypeVar("Result")


@dataclass
class Findings:
    """One section of the page.

    Attributes:
        title: Name of the scene, or what else was looked at.
        facts: Label and value, in the order in which they are shown.
        warnings: Sentences about what is odd; a run goes on.
        problems: Sentences about what would make a run fail.
        picture: File name of a picture beside the page.
    """

    title: str
    facts: dict[str, str] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    picture: str | None = None

    def attempt(self, step: Callable[[], Result]) -> Result | None:
        """Result of ``step``; None if it finds bad input, which becomes a problem, told once."""
        try:
            return step()
        except InputError as error:
            if str(error) not in self.problems:
                self.problems.append(str(error))
            return None

    def as_json(self) -> dict[str, object]:
        """For the machine-readable record."""
        return {"facts": self.facts, "warnings": self.warnings, "problems": self.problems}
