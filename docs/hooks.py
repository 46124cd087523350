"""Brings documents from outside docs/ onto the site, and turns links between them."""

import os
import re
from pathlib import Path
from typing import Any

# Path in the repository, and on the site.
OUTSIDE = {
    "CHANGELOG.md": "changelog.md",
    "CITATION.cff": "CITATION.cff",
    "CONTRIBUTING.md": "contributing.md",
    "config/README.md": "configuration.md",
    "src/r3gw/raster/csrc/semantics.h": "semantics.h",
}
ORIGINS = {site: origin for origin, site in OUTSIDE.items()}
LINK = re.compile(r"\]\((?![a-z]+:|#)([^)#\s]+)")


def on_files(files: Any, config: Any) -> Any:
    """Add the documents from outside to the files of the site."""
    from mkdocs.structure.files import File

    root = Path(config.config_file_path).parent
    for origin, site in OUTSIDE.items():
        files.append(File.generated(config, site, abs_src_path=str(root / origin)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Turn a page's links from places in the repository to places on the site."""
    site = page.file.src_uri
    folder = Path(ORIGINS.get(site, f"docs/{site}")).parent

    def turned(match: re.Match[str]) -> str:
        target = os.path.normpath(folder / match[1])
        return f"]({OUTSIDE.get(target, target.removeprefix('docs/'))}"

    return LINK.sub(turned, markdown)
