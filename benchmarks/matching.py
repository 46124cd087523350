"""How many photos register, and what matching costs, by ways of choosing pairs.

Imports a folder of photos once per way, each in a process of its own, prints a table and writes
results/benchmarks/matching.csv. Without a folder, it makes one: photos of textured walls on a walk
around them, in an order that says nothing.

    python benchmarks/matching.py [--photos FOLDER] [--count 200] [--ways retrieval,exhaustive]
"""

import json
import multiprocessing
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from unittest.mock import patch

import click
import cv2
import numpy as np
import pandas as pd

from r3gw.files import atomic_path
from r3gw.importing.reconstruction import incremental, matching
from r3gw.importing.settings import PhotosScene
from r3gw.importing.stage import import_scene

TARGET = Path("results/benchmarks/matching.csv")
SIZE_PX = (480, 360)
FOCAL_PX = 430.0
SIDES = 6  # walls of the tower that the walk leads around
RADIUS, WALK_RADIUS, HEIGHT = 3.0, 7.5, 3.0


@click.command()
@click.option("--photos", type=click.Path(path_type=Path, exists=True), help="Folder of photos.")
@click.option("--count", default=200, show_default=True, help="Photos to make without a folder.")
@click.option("--ways", default="retrieval,exhaustive", show_default=True, help="Of matching.")
@click.option("--threads", default=2, show_default=True)
def main(photos: Path | None, count: int, ways: str, threads: int) -> None:
    """Import the photos once per way of matching and compare."""
    rows = []
    with tempfile.TemporaryDirectory(prefix="r3gw-") as name:
        folder = photos
        if folder is None:
            folder = Path(name) / "photos"
            make_photos(folder, count)
        for way in ways.split(","):
            context = multiprocessing.get_context("spawn")
            with ProcessPoolExecutor(1, mp_context=context) as pool:
                measured = pool.submit(measure, folder, Path(name) / way, way, threads)
                rows.append(measured.result())
            print(rows[-1], flush=True)
    table = pd.DataFrame(rows)
    with atomic_path(TARGET) as path:
        table.to_csv(path, index=False)
    print(table.to_string(index=False))


def measure(photos: Path, target: Path, way: str, threads: int) -> dict[str, object]:
    """One import; processor seconds of matching and of all, and what registered."""
    seconds: dict[str, float] = {}

    def timed(match: Callable[..., str]) -> Callable[..., str]:
        def run(*arguments: object) -> str:
            start = time.process_time()
            said = match(*arguments)
            seconds["matching"] = time.process_time() - start
            return said

        return run

    settings = PhotosScene.model_validate({"format": "photos", "path": ".", "matching": way})
    start = time.process_time()
    with patch.object(incremental, "match_photos", timed(matching.match_photos)):
        import_scene("benchmark", settings, photos, target, num_threads=threads)
    report = json.loads((target / "sfm_report.json").read_text())
    return {
        "matching": report["matching"],
        "photos": report["photos"],
        "registered": len(report["registered"]),
        "points": report["points"],
        "reprojection_error_px": report["mean_reprojection_error_px"],
        "matching_s": round(seconds["matching"], 1),
        "import_s": round(time.process_time() - start, 1),
    }


def make_photos(folder: Path, count: int) -> None:
    """Write photos of a tower of textured walls from all around, under names in no order."""
    rng = np.random.default_rng(0)
    walls = [_texture(rng) for _ in range(SIDES)]
    names = rng.permutation(count)
    folder.mkdir(parents=True)
    for number in range(count):
        azimuth = 2 * np.pi * number / count
        away = WALK_RADIUS + rng.uniform(-0.8, 0.8)
        centre = np.array([away * np.sin(azimuth), rng.uniform(-0.5, 0.2), -away * np.cos(azimuth)])
        turn = azimuth + rng.uniform(-0.12, 0.12)
        photo = _photo(walls, centre, turn)
        cv2.imwrite(str(folder / f"photo_{names[number]:04d}.jpg"), photo)


def _texture(rng: np.random.Generator) -> np.ndarray:
    """A grey picture of blobs of several sizes."""
    image = np.full((900, 1200), 128.0, np.float32)
    for cells, strength in ((10, 25), (40, 30), (150, 35)):
        noise = rng.normal(size=(cells, cells)).astype(np.float32)
        image += strength * cv2.resize(noise, (1200, 900), interpolation=cv2.INTER_CUBIC)
    return np.clip(image, 0, 255)


def _photo(walls: list[np.ndarray], centre: np.ndarray, turn: float) -> np.ndarray:
    """Cast a ray per pixel onto the walls; the camera looks along +z turned by ``turn`` about y."""
    width, height = SIZE_PX
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = np.stack([x - width / 2, y - height / 2, np.full_like(x, FOCAL_PX)], axis=-1)
    cosine, sine = np.cos(-turn), np.sin(-turn)
    rays = rays @ np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]).T
    image = np.full((height, width), 205.0, np.float32)
    nearest = np.full((height, width), np.inf)
    apothem, half = RADIUS * np.cos(np.pi / SIDES), RADIUS * np.sin(np.pi / SIDES)
    for side, wall in enumerate(walls):
        angle = 2 * np.pi * side / SIDES
        normal = np.array([np.sin(angle), 0, -np.cos(angle)])
        along = np.array([np.cos(angle), 0, np.sin(angle)])
        with np.errstate(divide="ignore"):
            distance = (apothem - centre @ normal) / (rays @ normal)
        hit = centre + distance[..., None] * rays
        across, down = hit @ along, hit[..., 1]
        inside = (distance > 0) & (distance < nearest) & (np.abs(across) < half)
        inside &= np.abs(down) < HEIGHT / 2
        nearest[inside] = distance[inside]
        columns = ((across / half + 1) / 2 * (wall.shape[1] - 1)).astype(np.float32)
        rows = ((down / HEIGHT + 0.5) * (wall.shape[0] - 1)).astype(np.float32)
        image[inside] = cv2.remap(wall, columns, rows, cv2.INTER_LINEAR)[inside]
    return image.round().astype(np.uint8)


if __name__ == "__main__":
    main()
