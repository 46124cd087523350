"""Generate a benchmark scene: sessions, cameras, photos, ground truth, layout A on disk."""

import shutil
from collections.abc import Callable, Sequence
from importlib.metadata import version
from math import pi
from pathlib import Path

import numpy as np
from tqdm import tqdm

from r3gw.benchmark import cameras, lights, points, render, write
from r3gw.benchmark.buildings import chapel, colonnade, townhouse
from r3gw.benchmark.place import Place
from r3gw.benchmark.seeds import stream
from r3gw.benchmark.shooting import Exposure, Plan, Studio
from r3gw.files import InputError

PLACES = {module.PLACE.name: module.PLACE for module in (chapel, colonnade, townhouse)}
SCENES = tuple(PLACES)

OCCLUDED_EVERY = 3  # One training photo in three has passers-by
POINT_CANDIDATES = 9000


def generate(
    name: str,
    seed: int,
    target: Path,
    *,
    size_px: tuple[int, int] = (240, 180),
    train_views: int = 20,
    test_views: int = 4,
    samples: int = 20,
    show_progress: bool = True,
) -> None:
    """Render a scene and write it to ``target`` as layout A plus ground truth.

    The same arguments give the same bytes. ``target`` appears whole at the end, or not at all.

    Args:
        name: One of `SCENES`.
        seed: Drives textures, plants, clouds, cameras, exposures and passers-by; the building and
            its light list are the scene's own.
        target: Folder to make; it must not exist yet, or be empty.
        size_px: Width and height of the photos.
        train_views: Number of training photos, at least 2.
        test_views: Number of test photos, at least 1.
        samples: Light paths per pixel.
        show_progress: Whether to draw a progress bar.

    Raises:
        InputError: If the name is unknown, a number is too small, or ``target`` has content.
    """
    _check(name, target, size_px, train_views, test_views, samples)
    render.use_one_thread()
    scene = PLACES[name]
    partial = target.with_name(f".{target.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    try:
        plans = _plan(scene, seed, size_px, train_views, test_views)
        with tqdm(total=len(plans), desc=name, unit="photo", disable=not show_progress) as bar:
            shots, panoramas = _render(scene, seed, plans, samples, partial, bar.update)
        _write(scene, seed, shots, panoramas, samples, partial)
        if target.is_dir():
            target.rmdir()
        partial.replace(target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _check(
    name: str, target: Path, size_px: tuple[int, int], train: int, test: int, samples: int
) -> None:
    if name not in PLACES:
        raise InputError(f"unknown synthetic scene '{name}'; choose one of {', '.join(SCENES)}")
    for what, value, least in (
        ("width in pixels", size_px[0], 16),
        ("height in pixels", size_px[1], 16),
        ("number of training views", train, 2),
        ("number of test views", test, 1),
        ("samples per pixel", samples, 1),
    ):
        if value < least:
            raise InputError(f"synthetic scene '{name}': {what} is {value}; give {least} or more")
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise InputError(f"{target}: already there; remove it or choose another folder")


def _plan(
    scene: Place, seed: int, size_px: tuple[int, int], train_views: int, test_views: int
) -> list[Plan]:
    """Cameras, sessions and file names, sorted by file name."""
    random = stream(seed, scene.name, "cameras")
    trained = cameras.train_cameras(scene.walk, train_views, size_px, random)
    tested = cameras.test_cameras(scene.walk, test_views, trained, random)
    train_sessions = [s for s in scene.sessions if not s.is_test]
    test_sessions = [s for s in scene.sessions if s.is_test]
    plans = []
    for group, sessions, first in ((trained, train_sessions, 1), (tested, test_sessions, 701)):
        # Every block of neighbouring cameras meets every session, in its own order.
        turns: list[int] = []
        while len(turns) < len(group):
            turns += [int(i) for i in random.permutation(len(sessions))]
        for i, camera in enumerate(group):
            session = sessions[turns[i]]
            stem = f"{session.name}_IMG_{first + i:04d}"
            has_passersby = not session.is_test and i % OCCLUDED_EVERY == 1
            plans.append(Plan(stem, session, camera, has_passersby))
    return sorted(plans, key=lambda plan: plan.stem)


def _render(
    scene: Place,
    seed: int,
    plans: Sequence[Plan],
    samples: int,
    root: Path,
    done: Callable[[], object],
) -> tuple[list[write.Shot], dict[str, write.Panorama]]:
    """Render and write session by session; return photos by name, and the panoramas."""
    studio = Studio(scene, seed, samples)
    shots, panoramas = [], {}
    for session in scene.sessions:
        visit = [plan for plan in plans if plan.session == session]
        if not visit:
            continue
        random = stream(seed, scene.name, session.name)
        light = lights.environment(session, random)
        yaw_rad = lights.whole_pixel_yaw(float(random.uniform(-pi, pi)))
        panoramas[session.name] = write.Panorama(yaw_rad, lights.clipped_scale(light))
        write.write_light(root, session, light, yaw_rad)
        exposure = Exposure(light, random)
        emitter = render.emitter(light)
        place = studio.lit(emitter)
        for plan in visit:
            shots.append(studio.shoot(plan, place, emitter, exposure))
            write.write_shot(root, shots[-1])
            done()
    return sorted(shots, key=lambda shot: shot.stem), panoramas


def _write(
    scene: Place,
    seed: int,
    shots: Sequence[write.Shot],
    panoramas: dict[str, write.Panorama],
    samples: int,
    root: Path,
) -> None:
    """Everything that needs all photos: split, evaluation entries, model, facts."""
    write.write_split(root, scene.name, shots)
    write.write_test_config(root, shots, panoramas, stream(seed, scene.name, "sweeps"))
    views = [
        points.View(shot.camera, shot.truth.depth, shot.is_kept, shot.photo)
        for shot in shots
        if not shot.session.is_test
    ]
    focus = cameras.WORLD_FROM_BUILDING @ np.asarray(scene.walk.focus)
    random = stream(seed, scene.name, "points")
    write.write_model(root, shots, points.find(views, POINT_CANDIDATES, focus, random))
    made_with = {
        "scene": scene.name,
        "seed": seed,
        "samples": samples,
        "mitsuba": version("mitsuba"),
        "max_depth": render.MAX_DEPTH,
    }
    write.write_facts(root, shots, panoramas, made_with)
