"""Photos to scene, on pictures of a made place whose cameras are known, and on real photos."""

import json
import os
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation
from support.exif import with_orientation
from support.made_up_place import SIZE, place_photo

from r3gw.files import InputError
from r3gw.imaging.files import read_grey, read_rgb
from r3gw.imaging.masks import read_mask
from r3gw.importing.reconstruction.prepared import PreparedPhoto
from r3gw.importing.reconstruction.registration import Mapped, lost_photos
from r3gw.importing.settings import PhotosScene
from r3gw.importing.stage import import_scene
from r3gw.scene import load_points

pytestmark = pytest.mark.slow

MASKS = {"is_valid": "masks", "is_sky": "sky_masks"}
PATTERNS = {  # white of row and column, at full size
    "is_valid": lambda _row, column: column < 0.9 * SIZE[0],
    "is_sky": lambda row, _column: row >= 0.2 * SIZE[1],
}
REPOSITORY = Path(__file__).parents[3]
SACRE_COEUR = Path(
    os.environ.get("R3GW_SACRE_COEUR", REPOSITORY.parent / "shared" / "data" / "sacre_coeur")
)


# Some photos are no JPEG; that in WebP is transparent in its left columns.
OTHER_SUFFIXES = {3: ".TIFF", 4: ".webp"}
TRANSPARENT_COLUMNS = 12


def write_other(path, bgr):
    image = Image.fromarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB))
    if path.suffix == ".webp":
        alpha = np.full(bgr.shape[:2], 255, np.uint8)
        alpha[:, :TRANSPARENT_COLUMNS] = 0
        image.putalpha(Image.fromarray(alpha))
        image.save(path, lossless=True)
    else:
        image.save(path)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Seven photos of the place, one stored turned, and one of nothing."""
    folder = tmp_path_factory.mktemp("made")
    photos = folder / "photos"
    photos.mkdir()
    rng = np.random.default_rng(3)
    centres = {}
    for number, azimuth in enumerate(np.linspace(-40, 40, 7)):
        angle = np.radians(azimuth)
        centre = np.array([4 * np.sin(angle), -0.2 * (number % 3), 5 - 5 * np.cos(angle)])
        turn = Rotation.from_euler("YXZ", [-azimuth, rng.uniform(0, 8), rng.normal(0, 0.5)], True)
        centres[f"photo_{number}"] = centre
        image = place_photo(turn.as_matrix().T, centre)
        if number == 2:
            with_orientation(photos / "photo_2.jpg", np.rot90(image), 6)
        elif number in OTHER_SUFFIXES:
            write_other(photos / f"photo_{number}{OTHER_SUFFIXES[number]}", image)
        else:
            cv2.imwrite(str(photos / f"photo_{number}.{'JPG' if number else 'png'}"), image)
    for name, folder_name in MASKS.items():
        (photos / folder_name).mkdir()
        mask = (PATTERNS[name](*np.mgrid[: SIZE[1], : SIZE[0]]) * 255).astype(np.uint8)
        for stem in ("photo_1", "photo_2"):
            # That of the turned photo is of its stored pixels.
            stored = np.rot90(mask) if stem == "photo_2" else mask
            cv2.imwrite(str(photos / folder_name / f"{stem}.png"), stored)
    noise = rng.integers(0, 255, (30, 40), dtype=np.uint8)
    cv2.imwrite(str(photos / "elsewhere.png"), cv2.resize(noise, SIZE))
    cv2.imwrite(str(photos / "fog.png"), np.full(SIZE[::-1], 90, np.uint8))
    settings = PhotosScene(format="photos", path=".", max_image_px=200)
    scene = import_scene("made", settings, photos, folder / "scene", num_threads=2, seed=1)
    return folder, scene, centres


def test_camera_positions_match_the_truth(made):
    _, scene, centres = made
    found = np.stack([view.camera.centre.numpy() for view in scene.views])
    truth = np.stack([centres[view.name] for view in scene.views])
    found, truth = found - found.mean(axis=0), truth - truth.mean(axis=0)
    rotation, _ = Rotation.align_vectors(truth, found)
    scale = np.linalg.norm(truth) / np.linalg.norm(found)
    np.testing.assert_allclose(scale * rotation.apply(found), truth, rtol=0, atol=0.1)
    # The alignment may turn about up only: gravity was found from the photos alone.
    tilt = np.degrees(np.arccos(rotation.as_matrix()[1, 1]))
    assert tilt < 1.5


def test_points_have_the_asked_extent_and_scene_is_small(made):
    folder, scene, _ = made
    xyz = load_points(folder / "scene").xyz
    distance = np.linalg.norm(xyz - xyz.mean(axis=0), axis=1)
    np.testing.assert_allclose(np.percentile(distance, 99), 10.0, rtol=1e-4, atol=0)
    assert all(max(view.width, view.height) == 200 for view in scene.views)
    assert all(view.split == "train" and view.session is None for view in scene.views)


def test_turned_photo_is_upright(made):
    folder, scene, _ = made
    upright = read_rgb(folder / "photos" / "photo_2.jpg")[..., 0]  # OpenCV applies the tag
    assert upright.shape == (SIZE[1], SIZE[0])
    view = next(view for view in scene.views if view.name == "photo_2")
    assert view.width > view.height
    found = read_rgb(folder / "scene" / view.image)[..., 0]
    expected = cv2.resize(upright, (view.width, view.height), interpolation=cv2.INTER_AREA)
    assert np.corrcoef(found.ravel(), expected.ravel())[0, 1] > 0.8


def test_masks_beside_photos_are_undistorted_with_them(made):
    """The lens that SfM found is weak, so edges stay within a few pixels of the scaled mask."""
    folder, scene, _ = made
    for name in MASKS:
        assert len(list((folder / "scene" / "given" / name).iterdir())) == 2
    for view in scene.views[1:3]:
        assert (view.width, view.height) == (200, pytest.approx(150, abs=2))
        row, column = np.mgrid[: view.height, : view.width] * 2 + 0.5
        for name, pattern in PATTERNS.items():
            mask = read_grey(folder / "scene" / "given" / name / f"{view.name}.png") >= 128
            white = mask if name == "is_valid" else ~mask
            assert np.mean(white == pattern(row, column)) > 0.98


def test_photo_of_elsewhere_falls_out_and_is_reported(made):
    folder, scene, _ = made
    report = json.loads((folder / "scene" / "sfm_report.json").read_text())
    assert [view.name for view in scene.views] == [f"photo_{n}" for n in range(7)]
    assert (report["photos"], len(report["registered"])) == (9, 7)
    assert report["not_registered"] == {
        "elsewhere.png": "matches no other photo",
        "fog.png": "only 0 features (blurred, plain or masked)",
    }
    left = {path.name for path in (folder / "scene").iterdir()}
    assert left == {"scene.json", "sfm_report.json", "points.npz", "images", "given"}


def test_a_second_group_of_photos_is_named(tmp_path):
    groups = []
    for names in (("a", "b", "c"), ("x", "y")):
        model = pycolmap.Reconstruction()
        camera = pycolmap.Camera.create_from_model_id(1, pycolmap.CameraModelId.PINHOLE, 9, 9, 9)
        model.add_camera_with_trivial_rig(camera)
        for number, name in enumerate(names, start=1):
            image = pycolmap.Image(name=f"{name}.png", camera_id=1, image_id=number)
            model.add_image_with_trivial_frame(image, pycolmap.Rigid3d())
        groups.append(model)
    groups[0].add_point3D(np.ones(3), pycolmap.Track(), np.zeros(3, np.uint8))
    photos = [
        PreparedPhoto(f"day/{name}.jpg", tmp_path / f"{name}.png", None, None, {})
        for name in "abcxy"
    ]
    mapped = Mapped(groups[0], groups[1:], tmp_path / "database.db", "exhaustive, 10 pairs")
    reason = "belongs to another group of 2 photos that does not connect"
    assert lost_photos(photos, mapped) == {"day/x.jpg": reason, "day/y.jpg": reason}


def test_same_seed_gives_the_same_bytes(made):
    folder, _, _ = made
    settings = PhotosScene(format="photos", path=".", max_image_px=200)
    import_scene("made", settings, folder / "photos", folder / "again", num_threads=2, seed=1)
    for path in sorted((folder / "scene").rglob("*.*")):
        other = folder / "again" / path.relative_to(folder / "scene")
        assert path.read_bytes() == other.read_bytes(), path.name


def test_too_few_photos_and_photos_without_overlap_get_advice(tmp_path):
    settings = PhotosScene(format="photos", path=".")
    photos = tmp_path / "photos"
    photos.mkdir()
    with pytest.raises(InputError, match="0 photos are here, but at least 3 are needed"):
        import_scene("few", settings, photos, tmp_path / "scene", num_threads=1)
    cv2.imwrite(str(photos / "0.png"), np.zeros((30, 40), np.uint8))
    with pytest.raises(InputError, match="one photo is here, but at least 3 are needed; take more"):
        import_scene("few", settings, photos, tmp_path / "scene", num_threads=1)
    for seed in range(3):
        noise = np.random.default_rng(seed).integers(0, 255, (15, 20), dtype=np.uint8)
        cv2.imwrite(str(photos / f"{seed}.png"), cv2.resize(noise, (160, 120)))
    with pytest.raises(InputError, match=r"only 0 photos could be registered.*more overlap"):
        import_scene("few", settings, photos, tmp_path / "scene", num_threads=1)
    assert not list((tmp_path / "scene").iterdir())


@pytest.mark.skipif(not SACRE_COEUR.is_dir(), reason=f"no Sacré-Cœur photos in {SACRE_COEUR}")
def test_real_tourist_photos_register_upright(tmp_path):
    settings = PhotosScene(format="photos", path=".", max_image_px=400)
    scene = import_scene("sacre", settings, SACRE_COEUR, tmp_path / "scene", num_threads=2)
    assert len(scene.views) == 10
    for view in scene.views:
        right, down, forward = np.array(view.cam_from_world)[:3, :3]
        assert abs(np.degrees(np.arcsin(right[1]))) < 5  # no roll
        assert 5 < np.degrees(np.arcsin(-forward[1])) < 45  # all look up at the church
        assert down[1] > 0
    centres = [view.camera.centre.numpy() for view in scene.views]
    assert all(np.linalg.norm(a - b) > 0.1 for a, b in pairwise(centres))


def test_transparent_columns_are_kept_as_not_opaque(made):
    folder, scene, _ = made
    found = list((folder / "scene" / "given" / "is_opaque").iterdir())
    assert [path.name for path in found] == ["photo_4.png"]
    view = next(view for view in scene.views if view.name == "photo_4")
    columns = read_mask(found[0], view.width, view.height).mean(axis=0)
    edge = TRANSPARENT_COLUMNS * view.width / SIZE[0]
    # Undistorting moves the edge by a few pixels at most.
    assert columns[: int(edge) - 4].max() < 0.5
    assert columns[int(edge) + 5 :].min() > 0.5
