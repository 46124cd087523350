"""r3gw.reporting.page.stage: one sound page, which needs nothing but itself."""

import base64
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from support.made_up_runs import GREEN, make_run, make_scene

from r3gw.files import InputError
from r3gw.reporting.methods import recommended
from r3gw.reporting.page.inline import mask_uri, picture_uri
from r3gw.reporting.page.scene_page import SceneFolders
from r3gw.reporting.page.stage import write_report
from r3gw.reporting.tables.listings import cost, decomposition
from r3gw.reporting.tables.table1 import table1

VOID = {"meta", "link", "img", "input", "br"}


class Page(HTMLParser):
    """What a page is made of; complains about tags that are not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def all(self, tag: str) -> list[dict[str, str | None]]:
        """Attributes of every element of a kind."""
        return [attributes for name, attributes in self.elements if name == tag]


def make_results(folder: Path, *, with_test: bool) -> list[SceneFolders]:
    """Tables, a scene and two runs, as the pipeline lays them out."""
    make_scene(folder / "x" / "scene", with_test=with_test)
    runs = [
        make_run(folder / "x" / variant / "seed0", variant, with_test=with_test)
        for variant in ("full", "no_specular")
    ]
    metrics = [run / "metrics" / "metrics.json" for run in runs]
    table1(metrics, None, folder / "table1.csv")
    decomposition(metrics, folder / "decomposition.csv")
    cost(metrics, folder / "cost.csv")
    return [SceneFolders(folder / "x", tuple(runs), "pages/x.html")]


@pytest.fixture(scope="module")
def text(tmp_path_factory) -> str:
    """The report of a made-up scene with a test view."""
    folder = tmp_path_factory.mktemp("results")
    scenes = make_results(folder, with_test=True)
    write_report(folder, scenes, folder / "report.html")
    return (folder / "report.html").read_text()


def test_page_is_sound_and_needs_no_other_file(text):
    page = Page(text)
    for tag, name in (("img", "src"), ("script", "src"), ("link", "href"), ("iframe", "src")):
        for attributes in page.all(tag):
            assert (attributes.get(name) or "data:").startswith("data:"), attributes
    assert "@import" not in text
    assert not re.search(r"url\((?!data:)", text)
    elsewhere = [each["href"] for each in page.all("a") if not each["href"].startswith("#")]
    assert elsewhere == ["pages/x.html"]


def test_page_can_be_read_without_eyes_or_mouse(text):
    page = Page(text)
    ids = [attributes["id"] for _, attributes in page.elements if "id" in attributes]
    assert len(ids) == len(set(ids))
    inside = {each["href"][1:] for each in page.all("a") if each["href"].startswith("#")}
    assert inside <= set(ids)
    assert all("alt" in each for each in page.all("img"))
    labelled = {each.get("for") for each in page.all("label")}
    assert all(each["id"] in labelled for each in page.all("input") if "id" in each)


def test_page_shows_tables_settings_and_provenance(text):
    for piece in (
        "protocol nerf-osr: published angles",
        "r3gw without specular",
        "digest-no_specular",
        "&lt;machine &amp; co&gt;",
        "<code>model.specular</code>: true → false",
        "1 training photos, 1 test photos, 50 SfM points",
    ):
        assert piece in " ".join(text.split()), piece


def test_a_report_without_pages_links_none(tmp_path):
    scenes = [replace(each, page=None) for each in make_results(tmp_path, with_test=True)]
    write_report(tmp_path, scenes, tmp_path / "report.html")
    links = Page((tmp_path / "report.html").read_text()).all("a")
    assert all(each["href"].startswith("#") for each in links)


def test_what_goes_beyond_the_paper_is_recommended():
    assert recommended(["full", "r3gw_plus", "mine"]) == "r3gw_plus"
    assert recommended(["mine", "full"]) == "mine"


def test_same_results_give_the_same_page(text, tmp_path):
    scenes = make_results(tmp_path, with_test=True)
    write_report(tmp_path, scenes, tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text() == text


def test_a_slower_machine_changes_the_section_of_cost_alone(text, tmp_path):
    scenes = make_results(tmp_path, with_test=True)
    table = pd.read_csv(tmp_path / "cost.csv")
    table[["training_minutes", "renders_per_second", "training_peak_rss_mb"]] *= 3
    table.to_csv(tmp_path / "cost.csv", index=False)
    write_report(tmp_path, scenes, tmp_path / "report.html")
    parts = [
        re.split("(?=<h2 id=)", page) for page in (text, (tmp_path / "report.html").read_text())
    ]
    different = [before[:14] for before, after in zip(*parts, strict=True) if before != after]
    assert different == ['<h2 id="cost">']


def test_photos_alone_make_a_page(tmp_path):
    scenes = make_results(tmp_path, with_test=False)
    write_report(tmp_path, scenes, tmp_path / "report.html")
    page = Page((tmp_path / "report.html").read_text())
    assert len(page.all("img")) > 10


def test_missing_tables_and_settings_are_named(tmp_path):
    scenes = make_results(tmp_path, with_test=True)
    (scenes[0].runs[1] / "settings.json").unlink()
    with pytest.raises(InputError, match=r"no_specular/seed0/settings\.json: no such file; train"):
        write_report(tmp_path, scenes, tmp_path / "report.html")
    (tmp_path / "cost.csv").unlink()
    with pytest.raises(InputError, match=r"cost\.csv: no such file; make the tables"):
        write_report(tmp_path, scenes, tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def decoded(uri: str) -> np.ndarray:
    """Pixels of a data URI, as OpenCV has them."""
    encoded = np.frombuffer(base64.b64decode(uri.split(",")[1]), np.uint8)
    return cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED)


def test_pictures_shrink_but_do_not_grow():
    picture = np.full((30, 40, 3), GREEN, np.uint8)
    assert decoded(picture_uri(picture, 20)).shape == (15, 20, 3)
    assert decoded(picture_uri(picture, 80)).shape == (30, 40, 3)
    np.testing.assert_allclose(
        decoded(picture_uri(picture, 20))[7, 10], (0, 255, 0), rtol=0, atol=8
    )


def test_masks_tint_sky_and_passers_by():
    is_sky, is_valid = np.zeros((8, 8), np.bool_), np.ones((8, 8), np.bool_)
    is_sky[:4] = True
    is_valid[6:] = False
    tint = decoded(mask_uri(is_valid, is_sky, 8))
    assert list(tint[0, 0]) == [178, 114, 0, 150]  # BGRA
    assert tint[5, 0, 3] == 0
    assert list(tint[7, 0]) == [126, 0, 230, 190]
