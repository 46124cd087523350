"""The page as one HTML file: markup, style, scripts and data, with nothing to load from elsewhere."""

import json
import zlib
from base64 import b64encode
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from r3gw.files import atomic_path
from r3gw.relight.load import load_relightable
from r3gw.scene import load_scene
from r3gw.view.payload import BUNDLE, PageChoice, Payload, payload_of

TEMPLATES = Path(str(files("r3gw.view"))) / "templates"
COMPRESSION = 9
SCRIPTS = ("libraries", "reader")  # deflated by web/build.mjs


def write_page(
    model_path: Path, scene_folder: Path, target: Path, choice: PageChoice = PageChoice()
) -> None:
    """Write a trained scene as a page that shows and relights it.

    Args:
        model_path: model.pt of a run, or relightable.ply of an export.
        scene_folder: Folder of scene.json.
        target: The .html file.
        choice: What goes in.

    Raises:
        InputError: If a file is missing or of another kind.
    """
    scene = load_scene(scene_folder)
    payload = payload_of(load_relightable(model_path), scene, scene_folder, choice)
    text = page_html(payload)
    with atomic_path(target) as temporary:
        temporary.write_text(text, encoding="utf-8")


def page_html(payload: Payload) -> str:
    """The whole file."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES), undefined=StrictUndefined, autoescape=True
    )
    blobs = {name: encoded(content) for name, content in payload.blobs.items()}
    blobs["payload"] = encoded(json.dumps(payload.facts, separators=(",", ":")).encode())
    for name in SCRIPTS:
        blobs[name] = b64encode((BUNDLE / f"{name}.js.deflate").read_bytes()).decode()
    return environment.get_template("page.html").render(
        title=payload.facts["title"],
        style=(TEMPLATES / "page.css").read_text(encoding="utf-8"),
        script=(BUNDLE / "page.js").read_text(encoding="utf-8"),
        blobs=blobs,
    )


def encoded(content: bytes) -> str:
    """Deflated, as base64: what web/src/blobs.ts reads."""
    return b64encode(zlib.compress(content, COMPRESSION)).decode()
