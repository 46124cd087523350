"""Photos in memory: 8 bits per value, once."""

import subprocess
import sys

import numpy as np
import pytest
import torch
from support import nerf_osr_layout

from r3gw.imaging.files import write_image
from r3gw.importing.settings import NerfOsrScene
from r3gw.importing.stage import import_scene
from r3gw.masks.settings import MaskSources
from r3gw.masks.stage import make_masks
from r3gw.scene import load_scene, save_scene
from r3gw.training.photos import load_photos

SIZE = (896, 1200)
PEAK = """
import sys
from pathlib import Path
from r3gw.masks.stage import make_masks
from r3gw.scene import load_scene
from r3gw.masks.settings import MaskSources
from r3gw.training.photos import load_photos

scene, masks = Path(sys.argv[1]), Path(sys.argv[2])
def peak_bytes():
    status = Path("/proc/self/status").read_text()
    return 1024 * int(status.split("VmHWM:")[1].split()[0])
views = load_scene(scene)
load_photos(views.model_copy(update={"views": views.views[:1]}), scene, masks)  # libraries warm
"""
LOAD = """
before = peak_bytes()
photos = load_photos(views, scene, masks)
print(peak_bytes() - before)
"""
MAKE = """
before = peak_bytes()
make_masks(scene, masks, MaskSources(sky_masks="none", valid_masks="all"))
print(peak_bytes() - before)
"""


def growth_bytes(script, *folders):
    """What a fresh process's largest resident memory grows by."""
    command = [sys.executable, "-c", PEAK + script, *map(str, folders)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return int(done.stdout)


def large_scene(tmp_path):
    """Twelve noisy training photos of 1200 x 896 px with masks."""
    place = nerf_osr_layout.build(tmp_path / "place")
    settings = NerfOsrScene(format="nerf-osr", path=".")
    scene = import_scene("place", settings, place.folder, tmp_path / "scene", num_threads=1)
    first = scene.views[0]
    noise = np.random.default_rng(0).integers(0, 255, (SIZE[0] // 8, SIZE[1] // 8, 3), np.uint8)
    picture = noise.repeat(8, axis=0).repeat(8, axis=1)
    size = {"width": SIZE[1], "height": SIZE[0]}
    views = []
    for number in range(12):
        name = f"photo{number:02d}"
        write_image(tmp_path / "scene" / "images" / f"{name}.png", picture)
        changes = {"name": name, "image": f"images/{name}.png", **size}
        views.append(first.model_copy(update=changes))
    save_scene(scene.model_copy(update={"views": tuple(views)}), tmp_path / "scene")
    sources = MaskSources(sky_masks="none", valid_masks="all")
    make_masks(tmp_path / "scene", tmp_path / "masks", sources)
    return tmp_path / "scene", tmp_path / "masks"


@pytest.mark.slow
def test_photos_are_held_as_bytes_once(tmp_path):
    scene, masks = large_scene(tmp_path)
    photos = load_photos(load_scene(scene), scene, masks)
    pixels = SIZE[0] * SIZE[1]
    assert len(photos) == 12
    for photo in photos:
        assert photo.planes.dtype == torch.uint8
        kept = (photo.planes, photo.is_valid, photo.is_sky)
        assert sum(t.untyped_storage().nbytes() for t in kept) == 5 * pixels
    grown = growth_bytes(LOAD, scene, masks)
    # Eleven more photos, and while one is read, OpenCV's copy of it.
    assert grown < 1.1 * 11 * 5 * pixels + 8 * pixels
    assert grown > 0.9 * 11 * 5 * pixels - 8 * pixels


@pytest.mark.slow
def test_masks_are_made_one_photo_at_a_time(tmp_path):
    scene, masks = large_scene(tmp_path)
    assert growth_bytes(MAKE, scene, masks) < 12 * SIZE[0] * SIZE[1]
