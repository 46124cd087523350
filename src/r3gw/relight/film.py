"""Relighting by files: a trained scene in, pictures or a film out."""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import torch
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.relight.cameras import CameraOptions, cameras_over_time, view_named
from r3gw.relight.lights import LightOptions, light_over_time, require_map
from r3gw.relight.load import load_relightable, require_scene_of
from r3gw.relight.outputs import output_for
from r3gw.relight.picture import frame
from r3gw.relight.seen import Coverage
from r3gw.relight.tone import CURVES, linear_from_scene, scene_linear
from r3gw.relight.witnesses import Witnesses
from r3gw.scene import load_scene
from r3gw.scene.selection import evenly

MOST_JUDGED = 12  # Frames whose coverage is measured.


@dataclass(frozen=True)
class FilmOptions:
    """How frames are made of a scene.

    Attributes:
        frames: How many.
        fps: Frames per second.
        tone: Name of the tone curve (`r3gw.relight.tone.CURVES`).
        guessed: What becomes of surfaces that photos did not see well (`r3gw.relight.seen`).
    """

    frames: int = 1
    fps: float = 25.0
    tone: str = "standard"
    guessed: Literal["shown", "dimmed"] = "shown"


def relight(
    model_path: Path,
    scene_folder: Path,
    outputs: tuple[Path, ...],
    cameras: CameraOptions,
    light: LightOptions,
    film: FilmOptions = FilmOptions(),
    *,
    num_threads: int = 1,
) -> float | None:
    """Render the frames and write them to every output.

    Args:
        model_path: model.safetensors of a training, or relightable.ply of an export.
        scene_folder: Folder of scene.json.
        outputs: Files to write (r3gw.relight.outputs).
        cameras, light: Each may move over the film.
        film: Frames and tone.
        num_threads: CPU threads of torch and the rasterizer.

    Returns:
        Share of the surfaces that photos saw well in the frame where it is lowest, among at most
        `MOST_JUDGED` evenly chosen ones; None where no frame shows a surface.

    Raises:
        InputError: If a name is unknown, a file unreadable, choices contradict each other, or
            something moves but there is only one frame.
    """
    if film.frames == 1 and (cameras.moves or light.moves):
        raise InputError(
            "one frame shows no movement: ask for more frames, or for one view and plain numbers"
        )
    torch.set_num_threads(num_threads)
    # What is quickly looked at comes first, so that a slip is told at once.
    sinks = [output_for(path, film.frames, film.fps) for path in outputs]
    require_map(light)
    scene = load_scene(scene_folder)
    for name in cameras.views:
        view_named(scene, name)
    gaussians = load_relightable(model_path)
    require_scene_of(gaussians, scene)
    times = [i / max(film.frames - 1, 1) for i in range(film.frames)]
    placed = cameras_over_time(scene, cameras, gaussians.middle, times)
    light_at = light_over_time(gaussians, light)
    photos = [view.camera for view in scene.split("train")]
    witnesses, coverage = Witnesses(gaussians, photos), Coverage(gaussians, photos)
    curve = CURVES[film.tone]
    steps = tqdm(
        zip(placed, times, strict=True),
        total=film.frames,
        desc="relighting",
        unit="frame",
        disable=film.frames == 1,
    )
    with ExitStack() as stack:
        for sink in sinks:
            stack.enter_context(sink)
        for camera, time in steps:
            shown, pictures = light_at(time), {}
            dim_but = coverage.is_well_seen(camera.centre) if film.guessed == "dimmed" else None
            for is_linear in {sink.is_linear for sink in sinks}:
                tone = scene_linear if is_linear else curve
                picture = frame(gaussians, camera, shown, tone, witnesses, dim_but)
                pictures[is_linear] = linear_from_scene(picture) if is_linear else picture
            for sink in sinks:
                sink.write(pictures[sink.is_linear])
    judged = evenly(list({id(camera): camera for camera in placed}.values()), MOST_JUDGED)
    shares = [share for camera in judged if (share := coverage.share(camera)) is not None]
    return min(shares, default=None)
