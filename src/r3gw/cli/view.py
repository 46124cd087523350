"""Commands that show a trained scene in a browser."""

from pathlib import Path

import click

from r3gw.cli.group import FILE, FOLDER, cli
from r3gw.cli.told import OPEN_PAGE, wrote
from r3gw.files import InputError

PATH = click.Path(path_type=Path)
SCENE = click.option(
    "--scene", type=FOLDER, help="Folder of the imported scene; default: where the workflow has it."
)
MOST_GAUSSIANS = click.option(
    "--most-gaussians",
    type=click.IntRange(1),
    default=300_000,
    show_default=True,
    help="Leave out the least visible foreground Gaussians beyond this number.",
)
MOST_PICTURES = click.option(
    "--most-pictures",
    type=click.IntRange(0),
    default=60,
    show_default=True,
    help="Photos that the page can fade to; the others are cameras with thumbnails.",
)


@cli.command(short_help="Write a scene as one HTML page that relights it.")
@click.argument("run", type=PATH)
@SCENE
@click.option("--target", type=FILE, required=True, help="The page (.html).")
@MOST_GAUSSIANS
@MOST_PICTURES
def page(
    run: Path, scene: Path | None, target: Path, most_gaussians: int, most_pictures: int
) -> None:
    """Write a scene as one HTML file that shows and relights it in any browser with WebGL 2.

    RUN is a run's folder, its model.safetensors, or an exported relightable.ply (with lights.json
    beside it). The file needs no network and no server.
    """
    from r3gw.view.page import write_page
    from r3gw.view.payload import PageOptions
    from r3gw.view.runs import find_run

    if target.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{target}: browsers know a page by its name; let it end in .html")
    found = find_run(run, scene)
    options = PageOptions(None, most_gaussians, most_pictures, found.facts)
    write_page(found.model, found.scene, target, options)
    wrote(target, OPEN_PAGE)


@cli.command(short_help="Show a scene, or a running training, in your browser.")
@click.argument("run", type=PATH)
@SCENE
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8040, show_default=True, help="0: any free."
)
@click.option("--browse/--no-browse", default=True, show_default=True, help="Open a browser.")
@MOST_GAUSSIANS
@MOST_PICTURES
def view(
    run: Path, scene: Path | None, port: int, browse: bool, most_gaussians: int, most_pictures: int
) -> None:
    """Show a run in the browser, on this computer alone (127.0.0.1).

    RUN is a run's folder, its model.safetensors, or an exported relightable.ply. A run that is
    still in training shows its curves and a frame every few seconds, and its page once it is done.
    """
    from r3gw.view.page import page_of
    from r3gw.view.payload import PageOptions
    from r3gw.view.runs import Run, find_run
    from r3gw.view.server import serve

    def make(found: Run) -> str:
        options = PageOptions(None, most_gaussians, most_pictures, found.facts)
        return page_of(found.model, found.scene, options)

    serve(find_run(run, scene), make, port, click.echo, browse=browse)
