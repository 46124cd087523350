"""Generate a benchmark scene: sessions, cameras, photos and ground truth, as NeRF-OSR has them."""

import shutil
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
from tqdm import tqdm

from r3gw.benchmark import cameras, colmap, points, render, write
from r3gw.benchmark.devices import DEVICES, Device
from r3gw.benchmark.place import Place
from r3gw.benchmark.seeds import stream
from r3gw.benchmark.shooting import Plan
from r3gw.benchmark.visits import with_visits
from r3gw.benchmark.work import PLACES, Work, render_visits
from r3gw.files import InputError

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
    visits: int | None = None,
    num_devices: int = 0,
    is_denoised: bool = False,
    point_candidates: int = POINT_CANDIDATES,
    num_processes: int = 1,
    show_progress: bool = True,
) -> None:
    """Render a scene into ``target``: the NeRF-OSR layout (docs/data.md), and ground truth.

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
        visits: Training sessions; by default those of the place's own list.
        num_devices: Devices that took the photos (r3gw.benchmark.devices); their distorted
            originals are written too. 0: every photo has a pinhole camera of its own.
        is_denoised: Whether photos are smoothed, for renders of few samples.
        point_candidates: Sparse points to try; what two photos show is kept.
        num_processes: Processes that share the sessions; the bytes do not depend on it.
        show_progress: Whether to draw a progress bar.

    Raises:
        InputError: If the name is unknown, a number is too small, or ``target`` has content.
    """
    _check(name, target, size_px, train_views, test_views, samples)
    scene = PLACES[name]
    if visits is not None:
        random = stream(seed, scene.name, "visits")
        scene = replace(scene, sessions=with_visits(scene.sessions, visits, random))
    partial = target.with_name(f".{target.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    try:
        plans = _plan(scene, seed, size_px, train_views, test_views, DEVICES[:num_devices])
        work = Work(scene.name, seed, samples, is_denoised, partial)
        with tqdm(total=len(plans), desc=name, unit="photo", disable=not show_progress) as bar:
            shots, panoramas = render_visits(scene, plans, work, num_processes, bar.update)
        _write(scene, shots, panoramas, work, point_candidates)
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
    scene: Place,
    seed: int,
    size_px: tuple[int, int],
    train_views: int,
    test_views: int,
    devices: Sequence[Device],
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
            device = devices[int(random.integers(len(devices)))] if devices else None
            posed = camera if device is None else device.camera(camera, size_px)
            plans.append(Plan(stem, session, posed, has_passersby, device))
    return sorted(plans, key=lambda plan: plan.stem)


def _write(
    scene: Place,
    shots: Sequence[write.Taken],
    panoramas: dict[str, write.Panorama],
    work: Work,
    point_candidates: int,
) -> None:
    """Everything that needs all photos: split, evaluation entries, model, facts."""
    root, seed = work.root, work.seed
    write.write_split(root, scene.name, shots)
    write.write_test_config(root, shots, panoramas, stream(seed, scene.name, "sweeps"))
    views = [
        points.View(shot.camera, shot.depth, shot.is_kept, shot.photo)
        for shot in shots
        if not shot.session.is_test
    ]
    focus = cameras.WORLD_FROM_BUILDING @ np.asarray(scene.walk.focus)
    random = stream(seed, scene.name, "points")
    colmap.write_model(root, shots, points.find(views, point_candidates, focus, random))
    made_with = {
        "scene": scene.name,
        "seed": seed,
        "samples": work.samples,
        "mitsuba": version("mitsuba"),
        "max_depth": render.MAX_DEPTH,
    }
    write.write_facts(root, shots, panoramas, made_with)
