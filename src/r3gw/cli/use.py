"""Commands that use a trained scene."""

from pathlib import Path

import click

from r3gw.cli.group import FILE, FOLDER, cli


@cli.command()
@click.option("--model", type=FILE, required=True, help="model.pt of the run.")
@click.option("--scene", type=FOLDER, required=True, help="Folder of the imported scene.")
@click.option("--view", required=True, help="Photo whose camera is used.")
@click.option("--env-map", type=FILE, help="Environment map: .exr, .hdr, .jpg or .png.")
@click.option("--yaw-deg", type=float, default=0.0, help="Turn of the map about the vertical.")
@click.option("--exposure", type=float, default=1.0, help="Factor on the map.")
@click.option("--light-of", help="Training photo whose learned light is used instead of a map.")
@click.option("--sky", help="white, or learned:PHOTO. Default: white under a map.")
@click.option("--output", type=FILE, required=True, help="Picture to write (.png or .jpg).")
def relight(
    model: Path,
    scene: Path,
    view: str,
    env_map: Path | None,
    yaw_deg: float,
    exposure: float,
    light_of: str | None,
    sky: str | None,
    output: Path,
) -> None:
    """Render a photo's view under an environment map or under another photo's light."""
    from r3gw.evaluation.relight import relight_view

    relight_view(
        model,
        scene,
        view,
        output,
        env_map=env_map,
        yaw_deg=yaw_deg,
        exposure=exposure,
        light_of=light_of,
        sky=sky,
    )
