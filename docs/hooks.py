"""Brings documents from outside docs/ onto the site, and turns links between them."""

import os
import re
from pathlib import Path
from typing import Any

# Pages from outside docs/: path in the repository, and on the site.
OUTSIDE = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "config/README.md": "configuration.md",
    "integrations/nerfbaselines/README.md": "nerfbaselines.md",
}
ORIGINS = {site: origin for origin, site in OUTSIDE.items()}
LINK = re.compile(r"\]\((?![a-z]+:|#)([^)#\s]+)")


def on_files(files: Any, config: Any) -> Any:
    """Add the pages from outside, and other files of the repository that pages link to."""
    from mkdocs.structure.files import File

    root = Path(config.config_file_path).parent
    pages = [*OUTSIDE, *(f"docs/{file.src_uri}" for file in files.documentation_pages())]
    linked = {target for page in pages for target in targets(page, (root / page).read_text())}
    others = {each for each in linked if not each.startswith("docs/") and (root / each).is_file()}
    for origin in sorted(others | {*OUTSIDE}):
        path = str(root / origin)
        files.append(File.generated(config, place_on_site(origin), abs_src_path=path))
    return files


def targets(page: str, markdown: str) -> list[str]:
    """Where the links of a page lead, from the repository's root on."""
    folder = Path(page).parent
    return [os.path.normpath(folder / link) for link in LINK.findall(markdown)]


def place_on_site(target: str) -> str:
    """Where a file of the repository is on the site."""
    return OUTSIDE.get(target, target.removeprefix("docs/"))


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Turn a page's links from places in the repository to places on the site."""
    site = page.file.src_uri
    folder = Path(ORIGINS.get(site, f"docs/{site}")).parent
    return LINK.sub(lambda link: f"]({place_on_site(os.path.normpath(folder / link[1]))}", markdown)
