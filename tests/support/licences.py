"""The licences of everything that an installation brings, from the libraries' own metadata.

python -m support.licences    (with tests/ on the path) writes docs/licences.md anew
"""

import re
import tomllib
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

REPOSITORY = Path(__file__).parents[2]
EXTRAS = ("pipeline", "benchmark", "view", "cluster")  # what `make` installs, less the tests' own
# Looked up by hand, where the metadata name no licence: in the files that the library ships, or
# that its project publishes.
BY_HAND = {
    "conda-inject": "MIT",
    "openexr": "BSD-3-Clause",
    "snakemake-interface-common": "MIT",
    "snakemake-interface-logger-plugins": "MIT",
    "snakemake-interface-report-plugins": "MIT",
    "snakemake-interface-scheduler-plugins": "MIT",
    "snakemake-interface-storage-plugins": "MIT",
}
# Licences that nobody who installs r3gw shall get unasked.
REFUSED = re.compile(
    r"AGPL|Affero|SSPL|Server Side Public|BUSL|Business Source|Commons Clause|PolyForm|proprietary"
    r"|non-?commercial|\bNC\b|research (use|purposes) only|academic",
    re.IGNORECASE,
)


def installed_by_default() -> dict[str, Distribution]:
    """Every library of an installation by `make`, directly asked for or not, by name."""
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    optional = project["optional-dependencies"]
    texts = [*project["dependencies"], *(text for extra in EXTRAS for text in optional[extra])]
    found: dict[str, Distribution] = {}
    waiting = [Requirement(text) for text in texts]
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        is_asked_for = requirement.marker is None or requirement.marker.evaluate({"extra": ""})
        if name not in found and is_asked_for:
            found[name] = distribution(name)
            waiting += [Requirement(text) for text in found[name].requires or []]
    return found


def licence(name: str, library: Distribution) -> str:
    """What a library says of its licence; empty if it says nothing."""
    metadata = library.metadata
    if expression := metadata.get("License-Expression"):
        return str(expression)
    classifiers = [
        text.rpartition(" :: ")[2]
        for text in metadata.get_all("Classifier") or []
        if text.startswith("License :: ")
    ]
    lines = str(metadata.get("License") or "").strip().splitlines()
    # Some put the whole text there.
    stated = lines[0] if len(lines) == 1 and len(lines[0]) < 60 else ""
    return " / ".join(dict.fromkeys([*classifiers, *([stated] if stated else [])])) or BY_HAND.get(
        name, ""
    )


def table() -> str:
    """A line for each library, as in docs/licences.md."""
    rows = [
        f"| {name} | {licence(name, library)} |"
        for name, library in sorted(installed_by_default().items())
    ]
    return "\n".join(["| Library | Licence |", "| --- | --- |", *rows, ""])


if __name__ == "__main__":
    page = REPOSITORY / "docs/licences.md"
    page.write_text(page.read_text().partition("| Library |")[0] + table())
