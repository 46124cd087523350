"""The page as one HTML file: markup, style, scripts and data; it loads nothing from elsewhere."""

import json
import zlib
from base64 import b64encode
from html import escape
from pathlib import Path
from string import Template

from r3gw.files import atomic_path
from r3gw.relight.load import load_relightable
from r3gw.scene import load_scene
from r3gw.view.daylight import BUNDLE
from r3gw.view.payload import DEFAULTS, PageOptions, Payload, payload_of

TEMPLATES = Path(__file__).parent / "templates"
BLOB = '<script type="application/octet-stream" id="{name}">{text}</script>'
COMPRESSION = 9
SCRIPTS = ("libraries", "reader")  # deflated by web/build.mjs


def write_page(
    model_path: Path, scene_folder: Path, target: Path, options: PageOptions = DEFAULTS
) -> None:
    """Write a trained scene as a page that shows and relights it.

    Args:
        model_path: model.safetensors of a run, or relightable.ply of an export.
        scene_folder: Folder of scene.json.
        target: The .html file.
        options: What goes in.

    Raises:
        InputError: If a file is missing or of another kind.
    """
    text = page_of(model_path, scene_folder, options)
    with atomic_path(target) as temporary:
        temporary.write_text(text, encoding="utf-8")


def page_of(model_path: Path, scene_folder: Path, options: PageOptions = DEFAULTS) -> str:
    """The page of a trained scene; arguments and errors as of `write_page`."""
    scene = load_scene(scene_folder)
    return page_html(payload_of(load_relightable(model_path), scene, scene_folder, options))


def page_html(payload: Payload) -> str:
    """The whole file."""
    blobs = {name: encoded(content) for name, content in payload.blobs.items()}
    blobs["payload"] = encoded(json.dumps(payload.facts, separators=(",", ":")).encode())
    for name in SCRIPTS:
        blobs[name] = b64encode((BUNDLE / f"{name}.js.deflate").read_bytes()).decode()
    return Template(_template("page.html")).substitute(
        title=escape(payload.facts["title"]),
        style=_template("page.css"),
        script=(BUNDLE / "page.js").read_text(encoding="utf-8"),
        blobs="\n".join(BLOB.format(name=name, text=text) for name, text in blobs.items()),
    )


def encoded(content: bytes) -> str:
    """Deflated, as base64: what web/src/blobs.ts reads."""
    return b64encode(zlib.compress(content, COMPRESSION)).decode()


def _template(name: str) -> str:
    return (TEMPLATES / name).read_text(encoding="utf-8")
