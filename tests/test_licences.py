"""Nothing with a non-commercial or network-copyleft licence comes with an installation."""

import pytest
from support.licences import REFUSED, installed_by_default, licence, table


def test_every_library_has_a_licence_that_anybody_may_use():
    found = {name: licence(name, library) for name, library in installed_by_default().items()}
    assert len(found) > 60
    assert {"torch", "numpy", "snakemake", "mitsuba", "pycolmap"} <= set(found)
    assert [name for name, text in found.items() if not text] == []
    assert {name: text for name, text in found.items() if REFUSED.search(text)} == {}


@pytest.mark.parametrize(
    "text",
    [
        "GNU Affero General Public License v3",
        "AGPL-3.0-or-later",
        "Free for non-commercial use",
        "Free For Educational Use / Noncommercial",
        "CC-BY-NC-4.0",
        "Other/Proprietary License",
        "PolyForm-Noncommercial-1.0.0",
    ],
)
def test_such_licences_are_known_by_their_names(text):
    assert REFUSED.search(text)


def test_the_page_lists_what_is_installed(repository):
    assert (repository / "docs/licences.md").read_text().endswith(table())
