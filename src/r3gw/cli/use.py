"""Commands that use a trained scene: relighting and export."""

from pathlib import Path
from typing import Any, Literal

import click

from r3gw.cli.group import FILE, FOLDER, cli
from r3gw.cli.sections import SWEEP, SectionCommand, light_options, option
from r3gw.cli.told import OPEN_PAGE, wrote
from r3gw.relight.sweep import Sweep

SCENE, CAMERA, OUTPUT = "Scene", "Camera", "Output"
MODEL = option(
    SCENE,
    "--model",
    type=click.Path(path_type=Path),
    required=True,
    help="A run's folder, its model.safetensors, or an exported relightable.ply.",
)
SCENE_FOLDER = option(
    SCENE,
    "--scene",
    type=FOLDER,
    help="Folder of the imported scene; default: where the workflow has it.",
)


@cli.command(
    cls=SectionCommand, short_help="Make a picture or a film from any camera under any light."
)
@MODEL
@SCENE_FOLDER
@option(
    CAMERA,
    "--view",
    multiple=True,
    required=True,
    metavar="PHOTO",
    help="Training or test photo whose camera is used; several make a smooth path through them.",
)
@option(
    CAMERA,
    "--orbit-deg",
    type=SWEEP,
    metavar="SWEEP",
    help="Carry the view's camera about the scene, looking at its middle; positive to the right.",
)
@option(CAMERA, "--width", type=click.IntRange(2), help="Picture width in px; default the photo's.")
@light_options
@option(
    OUTPUT,
    "--output",
    type=FILE,
    multiple=True,
    required=True,
    help=".png, .jpg, .exr (linear light), .mp4, or numbered frames such as frames/%04d.png. "
    "May be given several times.",
)
@option(
    OUTPUT,
    "--frames",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Number of frames of a film.",
)
@option(
    OUTPUT,
    "--fps",
    type=click.FloatRange(0, min_open=True),
    default=25.0,
    show_default=True,
    help="Frames per second of .mp4.",
)
@option(
    OUTPUT,
    "--guessed",
    type=click.Choice(["shown", "dimmed"]),
    default="shown",
    show_default=True,
    help="What becomes of surfaces that fewer than two photos saw from within 30 degrees.",
)
@option(OUTPUT, "--threads", type=click.IntRange(1), default=1, help="CPU threads.")
def relight(
    model: Path,
    scene: Path | None,
    view: tuple[str, ...],
    orbit_deg: Sweep | None,
    width: int | None,
    output: tuple[Path, ...],
    frames: int,
    fps: float,
    guessed: Literal["shown", "dimmed"],
    threads: int,
    tone: str,
    **light: Any,
) -> None:
    """Show a trained scene from any camera under any light, as a picture or as a film.

    A SWEEP is a number, or FROM:TO (or FROM:VIA:TO) to change evenly over the film.

    \b
    One photo's view under an HDR map:
      r3gw relight --model R --view A --env-map sunset.hdr --output relit.png
    A day around the place, the camera on a path from A by B to C:
      r3gw relight --model R --view A --view B --view C \\
          --sun 10:60:10 90:270 --frames 150 --output day.mp4
    From one photo's weather to another's, orbiting:
      r3gw relight --model R --view A --orbit-deg -30:30 --light-of A \\
          --light-of B --blend 0:1 --frames 100 --output blend.mp4
    """
    from r3gw.relight.cameras import CameraOptions
    from r3gw.relight.film import FilmOptions
    from r3gw.relight.film import relight as run
    from r3gw.relight.outputs import described
    from r3gw.relight.seen import remark
    from r3gw.view.runs import find_run

    found = find_run(model, scene)
    cameras = CameraOptions(view, orbit_deg, width)
    share = run(
        found.model,
        found.scene,
        output,
        cameras,
        _light(**light),
        FilmOptions(frames, fps, tone, guessed),
        num_threads=threads,
    )
    for path in output:
        wrote(described(path, frames, fps))
    warning = remark(share)
    if warning is not None:
        click.echo(f"{'where least, ' if frames > 1 else ''}{warning} (--guessed dimmed)", err=True)


@cli.command(cls=SectionCommand, short_help="Write a scene for viewers of Gaussian splats.")
@MODEL
@SCENE_FOLDER
@light_options
@option(
    OUTPUT,
    "--target",
    type=click.Path(path_type=Path),
    required=True,
    help="Folder for baked.ply, relightable.ply, baked.glb and lights.json; or a page (.html).",
)
@option(
    OUTPUT,
    "--view",
    metavar="PHOTO",
    help="Bake reflections as this photo's camera sees them; default: the mean over all "
    "training cameras.",
)
@option(
    OUTPUT,
    "--coordinates",
    type=click.Choice(["scene", "source"]),
    default="scene",
    show_default=True,
    help="scene: upright (up = -y), r3gw's scale; source: those of the dataset or reconstruction.",
)
def export(
    model: Path,
    scene: Path | None,
    target: Path,
    view: str | None,
    coordinates: Literal["scene", "source"],
    tone: Literal["standard", "reinhard", "filmic"],
    **light: Any,
) -> None:
    """Write a trained scene for viewers of Gaussian splats, under one light.

    \b
    baked.ply         what SuperSplat, antimatter15 and gsplat viewers open
    relightable.ply   the same with albedo, roughness and is_sky; `relight --model` reads it
    baked.glb         glTF 2.0 with KHR_gaussian_splatting
    lights.json       the learned lights as spherical harmonics

    A target that ends in .html is one page instead, which opens in that light and relights the
    scene in any browser (see also `r3gw page`).
    """
    from r3gw.relight.export import export as run
    from r3gw.relight.lights import require_map, still_light
    from r3gw.relight.trained import load
    from r3gw.view.runs import find_run

    found, options = find_run(model, scene), _light(**light)
    require_map(options)
    trained = load(found.model, found.scene)
    baked_under = still_light(trained.gaussians, options)
    if target.suffix.lower() == ".html":
        _export_page(found, target, options, tone)
        return
    run(trained, target, baked_under, view=view, tone=tone, coordinates=coordinates)
    wrote(target, "viewers of Gaussian splats open baked.ply, others baked.glb")


def _export_page(run: Any, target: Path, options: Any, tone: str) -> None:
    from r3gw.view.page import write_page
    from r3gw.view.payload import PageOptions
    from r3gw.view.start import start_of

    begun = PageOptions(facts=run.facts, start=start_of(options, tone))
    write_page(run.model, run.scene, target, begun)
    wrote(target, OPEN_PAGE)


def _light(
    env_map: Path | None,
    light_of: tuple[str, ...],
    blend: Sweep,
    sun: tuple[Sweep, Sweep] | None,
    turbidity: float,
    yaw_deg: Sweep,
    exposure: float | Literal["auto"] | None,
    sky: str | None,
) -> Any:
    """The LightOptions of the command's options."""
    from r3gw.relight.lights import LightOptions, MapSource, PhotoSource, SunSource

    if (env_map is not None) + bool(light_of) + (sun is not None) != 1:
        raise click.UsageError("give exactly one light: --env-map, --light-of or --sun")
    if len(light_of) > 2 or (blend != Sweep((0.0,)) and len(light_of) != 2):
        raise click.UsageError("a blend is of two lights: give --light-of twice")
    source: MapSource | PhotoSource | SunSource
    if env_map is not None:
        source = MapSource(env_map)
    elif sun is not None:
        source = SunSource(*sun, turbidity)
    else:
        source = PhotoSource(light_of, blend)
    return LightOptions(source, yaw_deg, exposure, sky)
