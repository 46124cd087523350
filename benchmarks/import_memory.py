"""Time and peak memory of importing a large set of photos: 500 by default, as a COLMAP folder.

Makes the set in a temporary folder (a few made photos under many names, and a model with tracks),
imports it in a process of its own, prints a table and writes
results/benchmarks/import_memory.csv.

    python benchmarks/import_memory.py [--photos 500] [--folder /var/tmp]
"""

import multiprocessing
import os
import tempfile
import time
from pathlib import Path

import click
import numpy as np
import pandas as pd
import pycolmap

from r3gw.files import atomic_path
from r3gw.files.provenance import peak_rss_mb
from r3gw.imaging.files import write_image
from r3gw.importing.settings import ColmapScene
from r3gw.importing.stage import import_scene

TARGET = Path("results/benchmarks/import_memory.csv")
SIZES = ((1600, 1200), (4000, 3000))
DISTINCT = 8
OBSERVATIONS = 2000  # points that each photo sees
TRACK = 10  # photos that each point is seen by


def make_photos(folder: Path, count: int, width: int, height: int) -> None:
    """Write ``DISTINCT`` photos and link them to ``count`` names."""
    rng = np.random.default_rng(0)
    for number in range(min(count, DISTINCT)):
        coarse = rng.integers(0, 255, (height // 8, width // 8, 3), dtype=np.uint8)
        photo = coarse.repeat(8, axis=0).repeat(8, axis=1)
        photo = photo + rng.integers(0, 30, photo.shape, dtype=np.uint8)
        write_image(folder / f"photo_{number:04d}.jpg", photo)
    for number in range(DISTINCT, count):
        os.link(folder / f"photo_{number % DISTINCT:04d}.jpg", folder / f"photo_{number:04d}.jpg")


def make_model(folder: Path, count: int, width: int, height: int) -> None:
    """Write a model whose cameras stand in a row; tracks join neighbours."""
    rng = np.random.default_rng(1)
    model = pycolmap.Reconstruction()
    parameters = [0.8 * width, 0.8 * width, width / 2, height / 2]
    camera = pycolmap.Camera(
        model="PINHOLE", width=width, height=height, params=parameters, camera_id=1
    )
    model.add_camera_with_trivial_rig(camera)
    for number in range(count):
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(), np.array([-0.02 * number, 0.0, 5.0]))
        image = pycolmap.Image(name=f"photo_{number:04d}.jpg", camera_id=1, image_id=number + 1)
        pixels = rng.uniform(0, (width, height), (OBSERVATIONS, 2))
        image.points2D = pycolmap.Point2DList([pycolmap.Point2D(pixel) for pixel in pixels])
        model.add_image_with_trivial_frame(image, pose)
    for first in range(0, count - TRACK + 1, TRACK):
        for index in range(OBSERVATIONS):
            track = pycolmap.Track()
            for number in range(first, first + TRACK):
                track.add_element(number + 1, index)
            colour = rng.integers(0, 256, 3, dtype=np.uint8)
            model.add_point3D(rng.uniform(-3, 3, 3), track, colour)
    folder.mkdir(parents=True)
    model.write_binary(str(folder))


def make(job: tuple[Path, int, int, int]) -> None:
    """Make one set."""
    folder, count, width, height = job
    make_photos(folder / "images", count, width, height)
    make_model(folder / "sparse", count, width, height)


def measure(job: tuple[Path, int, int, int]) -> dict[str, str | int | float]:
    """Import one set; seconds, and the process's peak memory before and after."""
    folder, count, width, height = job
    before = peak_rss_mb()
    start = time.perf_counter()
    settings = ColmapScene.model_validate({"format": "colmap", "path": "."})
    scene = import_scene("large", settings, folder, folder / "scene", num_threads=1)
    seconds = time.perf_counter() - start
    assert len(scene.views) == count
    return {
        "photos": count,
        "width": width,
        "height": height,
        "imported_width": scene.views[0].width,
        "seconds": seconds,
        "libraries_rss_mb": before,
        "peak_rss_mb": peak_rss_mb(),
        "load": os.getloadavg()[0],
    }


@click.command()
@click.option("--photos", type=click.IntRange(20), default=500, help="Photos in the set.")
@click.option("--folder", type=click.Path(path_type=Path), help="Where the set may lie.")
def main(photos: int, folder: Path | None) -> None:
    """Measure imports of large sets."""
    rows = []
    for width, height in SIZES:
        with tempfile.TemporaryDirectory(dir=folder) as work:
            job = (Path(work), photos, width, height)
            for stage in (make, measure):
                with multiprocessing.get_context("spawn").Pool(1) as pool:
                    (row,) = pool.map(stage, [job])
                    pool.close()
                    pool.join()
            rows.append(row)
    frame = pd.DataFrame(rows)
    print(frame.round(1).to_string(index=False))
    with atomic_path(TARGET) as path:
        frame.to_csv(path, index=False)


if __name__ == "__main__":
    main()
