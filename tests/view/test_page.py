"""The page's file: complete, escaped, and built from the sources in web/."""

import hashlib
import json
import re
import zlib
from base64 import b64decode
from functools import partial
from html.parser import HTMLParser

import pytest
from click.testing import CliRunner

from r3gw.__main__ import cli
from r3gw.files import InputError
from r3gw.model.model_file import save_model
from r3gw.scene import load_scene
from r3gw.view.daylight import BUNDLE
from r3gw.view.page import page_of
from r3gw.view.payload import PageOptions, payload_of
from r3gw.view.runs import find_run

BLOBS = ("place", "shape", "surface", "table")


class Parts(HTMLParser):
    """Texts of the elements with an id, and every address that the page names."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: dict[str, str] = {}
        self.addresses: list[str] = []
        self._open: str | None = None

    def handle_starttag(self, _tag, attrs):
        named = dict(attrs)
        self._open = named.get("id")
        self.addresses += [named[key] for key in ("src", "href") if named.get(key)]

    def handle_data(self, data):
        if self._open:
            self.texts[self._open] = self.texts.get(self._open, "") + data


def parts_of(html: str) -> Parts:
    """Parse a page."""
    parts = Parts()
    parts.feed(html)
    return parts


def blob(parts: Parts, name: str) -> bytes:
    """Bytes of an embedded blob."""
    return zlib.decompress(b64decode(parts.texts[name]))


def test_the_page_holds_the_payload_and_names_no_other_file(html, payload):
    parts = parts_of(html)
    assert json.loads(blob(parts, "payload")) == payload.facts
    for name, content in payload.blobs.items():
        assert blob(parts, name) == content
    assert parts.addresses == ["data:,"]
    style = (BUNDLE.parent / "templates" / "page.css").read_text()
    assert "url(" not in style


def test_a_title_is_text_not_markup(html):
    assert "<blob>" not in html
    assert "A &lt;blob&gt; &amp; co" in html


def test_photos_without_a_picture_keep_their_cameras(payload):
    *others, last = payload.facts["photos"]
    assert (last["thumbnail"], last["picture"]) == (None, None)
    assert all(photo["picture"].startswith("data:image/webp") for photo in others)


def test_pictures_and_gaussians_have_limits_and_the_page_says_so(gaussians, scene_folder):
    options = PageOptions(most_gaussians=700, most_pictures=2)
    made = payload_of(gaussians, load_scene(scene_folder), scene_folder, options)
    assert made.facts["numForeground"] + made.facts["numSky"] == 700
    assert made.facts["numLeftOut"] == len(gaussians.means) - 700
    assert [bool(photo["picture"]) for photo in made.facts["photos"]] == [True] * 2 + [False] * 3
    assert all(photo["thumbnail"] for photo in made.facts["photos"][:4])


def test_the_scripts_are_built_from_their_sources(repository):
    """After a change in web/: `npm ci && npm run build` there."""
    web = repository / "web"
    sources = sorted((web / "src").iterdir(), key=lambda path: path.name)
    digest = hashlib.sha256()
    for path in [*sources, web / "build.mjs", web / "package-lock.json"]:
        digest.update(path.read_bytes())
    assert (BUNDLE / "digest.txt").read_text().strip() == digest.hexdigest()


def test_libraries_come_with_their_licences():
    text = (BUNDLE / "LICENCES.txt").read_text()
    for name in ("@sparkjsdev/spark 2.2.0", "three 0.187.0", "fflate"):
        assert re.search(rf"^{re.escape(name)}", text, re.MULTILINE)
    assert text.count("Permission is hereby granted, free of charge") == 3


def test_scripts_cannot_end_their_element():
    assert "</script" not in (BUNDLE / "page.js").read_text().lower()


def test_a_run_is_found_by_its_folder_or_its_model(tmp_path, model, scene_folder):
    folder = tmp_path / "place" / "full" / "seed0"
    folder.mkdir(parents=True)
    save_model(model, folder / "model.safetensors")
    (tmp_path / "place" / "scene").symlink_to(scene_folder)
    by_folder, by_file = find_run(folder, None), find_run(folder / "model.safetensors", None)
    assert by_folder.model == by_file.model == folder / "model.safetensors"
    assert (by_folder.scene / "scene.json").is_file()
    with pytest.raises(InputError, match="no such file or folder"):
        find_run(tmp_path / "missing", None)
    with pytest.raises(InputError, match="--scene"):
        find_run(folder, tmp_path)
    with pytest.raises(InputError, match=r"holds no model\.safetensors; give a run's folder"):
        find_run(folder.parent, None)


def test_the_command_writes_a_page_of_a_model(tmp_path, model, scene_folder):
    save_model(model, tmp_path / "model.safetensors")
    target = tmp_path / "page.html"
    arguments = ["page", str(tmp_path), "--scene", str(scene_folder), "--target", str(target)]
    outcome = CliRunner().invoke(cli, arguments, catch_exceptions=False)
    assert outcome.exit_code == 0
    facts = json.loads(blob(parts_of(target.read_text()), "payload"))
    assert facts["numForeground"] == 60
    assert [light["photo"] for light in facts["lights"]] == ["a", "b"]


def test_an_export_makes_the_page_of_its_model(tmp_path, model, scene_folder):
    save_model(model, tmp_path / "model.safetensors")
    common = ["--model", str(tmp_path / "model.safetensors"), "--scene", str(scene_folder)]
    export = ["export", *common, "--light-of", "a", "--target", str(tmp_path / "exported")]
    assert CliRunner().invoke(cli, export, catch_exceptions=False).exit_code == 0
    found = []
    for source in (tmp_path / "model.safetensors", tmp_path / "exported" / "relightable.ply"):
        parts = parts_of(page_of(source, scene_folder))
        found.append([json.loads(blob(parts, "payload")), *map(partial(blob, parts), BLOBS)])
    assert found[0] == found[1]


def test_a_model_without_a_scene_of_photos_is_refused(gaussians, scene_folder):
    scene = load_scene(scene_folder).model_copy(update={"views": ()})
    with pytest.raises(InputError, match="no photos"):
        payload_of(gaussians, scene, scene_folder)
