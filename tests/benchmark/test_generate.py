"""A tiny scene on disk: layout, independent checks of ground truth and photos, same bytes."""

import csv
import hashlib
import json
from pathlib import Path

import numpy as np
import pycolmap
import pytest
import torch

from r3gw.benchmark.generate import SCENES, generate
from r3gw.files import InputError
from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.imaging.files import read_linear, read_rgb
from r3gw.imaging.masks import erode, read_mask

pytestmark = pytest.mark.slow

NAME = "chapel"
TINY = {"size_px": (32, 24), "train_views": 2, "test_views": 1, "samples": 1}


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small scene with all of its sessions."""
    target = tmp_path_factory.mktemp("synthetic") / NAME
    generate(
        NAME,
        3,
        target,
        size_px=(80, 60),
        train_views=6,
        test_views=4,
        samples=3,
        show_progress=False,
    )
    return target


@pytest.fixture(scope="module")
def model(root: Path) -> pycolmap.Reconstruction:
    return pycolmap.Reconstruction(str(root / "undistorted" / "sparse" / "0"))


@pytest.fixture(scope="module")
def split(root: Path) -> dict[str, str]:
    with (root / "undistorted" / f"{NAME}_split.csv").open() as lines:
        rows = list(csv.DictReader(lines, delimiter=";"))
    return {Path(row["filename"]).stem: row["split"] for row in rows}


@pytest.fixture(scope="module")
def facts(root: Path) -> dict:
    return json.loads((root / "ground_truth" / "ground_truth.json").read_text())


@pytest.fixture(scope="module")
def cameras(model: pycolmap.Reconstruction) -> dict[str, Camera]:
    found = {}
    for image in model.images.values():
        pose = torch.eye(4, dtype=torch.float64)
        pose[:3] = torch.from_numpy(image.cam_from_world().matrix())
        camera = model.cameras[image.camera_id]
        assert camera.model.name == "PINHOLE"
        fx, fy, cx, cy = (float(value) for value in camera.params)
        found[Path(image.name).stem] = Camera(pose, (fx, fy, cx, cy), camera.width, camera.height)
    return found


def positions(root: Path, stem: str, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """World position of each pixel by back-projection of the depth, and the depth."""
    depth = read_linear(root / "ground_truth" / "depth" / f"{stem}.exr")[..., 0].astype(float)
    local = pixel_rays(camera).numpy() * depth[..., None]
    pose = camera.cam_from_world.numpy()
    return (local - pose[:3, 3]) @ pose[:3, :3], depth


def test_the_layout_is_complete(root: Path, split: dict[str, str], facts: dict) -> None:
    assert sorted(split.values()).count("train") == 6
    assert sorted(split.values()).count("test") == 4
    for stem, part in split.items():
        files = [
            f"undistorted/images/{stem}.jpg",
            f"undistorted/masks/{stem}.png",
            f"undistorted/sky_masks/{stem}.png",
            *(f"ground_truth/{kind}/{stem}.exr" for kind in ("albedo", "normal", "depth")),
        ]
        session = stem.split("_IMG_")[0]
        assert facts["views"][stem]["session"] == session
        files.append(f"ground_truth/envmaps/{session}.exr")
        if part == "test":
            files.append(f"eval_files/eval_mask/{stem}.png")
            files.append(f"eval_files/ENV_MAP_CC/{session}/envmap.jpg")
        for file in files:
            assert (root / file).is_file(), file
        assert read_rgb(root / files[0]).shape == (60, 80, 3)
    config = (root / "eval_files" / "test_config.py").read_text()
    tests = {stem for stem, part in split.items() if part == "test"}
    assert all(f'"{stem}.jpg"' in config for stem in tests)


def test_test_sessions_are_never_trained_on(split: dict[str, str]) -> None:
    sessions = {
        part: {s.split("_IMG_")[0] for s, p in split.items() if p == part}
        for part in ("train", "test")
    }
    assert len(sessions["train"]) == 6
    assert len(sessions["test"]) == 4
    assert not sessions["train"] & sessions["test"]


def test_model_and_split_name_the_same_photos(
    split: dict[str, str], cameras: dict[str, Camera]
) -> None:
    assert set(cameras) == set(split)


def test_cameras_stand_upright_in_front_and_differ(cameras: dict[str, Camera]) -> None:
    for camera in cameras.values():
        assert camera.cam_from_world[1, 1] > 0.9  # The camera's down is the world's +y
        assert camera.centre[2] < 0
        assert -1.5 < camera.centre[1] < -0.9
    assert len({camera.intrinsics[0] for camera in cameras.values()}) == len(cameras)
    assert any(c.intrinsics[2] != c.width / 2 for c in cameras.values())


def test_points_lie_on_the_surface_seen_in_their_photos(
    root: Path, model: pycolmap.Reconstruction, cameras: dict[str, Camera]
) -> None:
    depths = {s: positions(root, s, camera)[1] for s, camera in cameras.items()}
    assert len(model.points3D) > 500
    errors_px, errors = [], []
    for point in model.points3D.values():
        assert point.track.length() >= 2
        for element in point.track.elements:
            image = model.images[element.image_id]
            stem = Path(image.name).stem
            camera = cameras[stem]
            local = camera.cam_from_world.numpy() @ np.append(point.xyz, 1.0)
            fx, fy, cx, cy = camera.intrinsics
            seen = np.array([fx, fy]) * local[:2] / local[2] + [cx, cy]
            noted = image.points2D[element.point2D_idx].xy
            errors_px.append(np.abs(seen - noted).max())
            column, row = np.floor(noted).astype(int)
            errors.append(abs(depths[stem][row, column] / local[2] - 1))
    assert np.max(errors_px) < 1.0
    assert np.median(errors) < 0.008  # Points lie off the pixel centre, on slanted surfaces
    assert np.max(errors) < 0.03


def test_the_scene_is_about_ten_units_wide(model: pycolmap.Reconstruction) -> None:
    xyz = np.array([point.xyz for point in model.points3D.values()])
    reach = np.linalg.norm(xyz - xyz.mean(axis=0), axis=1)
    assert 6 < np.percentile(reach, 99) < 11


def test_normals_are_those_of_the_depth(
    root: Path, cameras: dict[str, Camera], split: dict[str, str]
) -> None:
    for stem, camera in cameras.items():
        if split[stem] != "test":
            continue
        xyz, depth = positions(root, stem, camera)
        normal = read_linear(root / "ground_truth" / "normal" / f"{stem}.exr")
        is_solid = depth > 0
        length = np.linalg.norm(normal, axis=-1)
        np.testing.assert_allclose(length[is_solid], 1.0, rtol=0, atol=1e-5)
        assert (length[~is_solid] == 0).all()
        towards = camera.centre.numpy() - xyz
        facing = (towards * normal).sum(-1)[is_solid] / np.linalg.norm(towards[is_solid], axis=-1)
        assert np.mean(facing > 0) > 0.995
        assert facing.min() > -0.4  # Smooth normals turn away a little at a column's outline
        # On a plane the inverse depth is affine in the pixel: its second differences vanish.
        inverse = 1 / np.where(is_solid, depth, np.inf)
        middle = 2 * inverse[1:-1, 1:-1]
        bend = np.abs(inverse[1:-1, 2:] + inverse[1:-1, :-2] - middle)
        bend += np.abs(inverse[2:, 1:-1] + inverse[:-2, 1:-1] - middle)
        is_evaluated = read_mask(root / "eval_files" / "eval_mask" / f"{stem}.png")  # No leaves
        is_flat = (bend < 1e-5 * middle) & is_evaluated[1:-1, 1:-1]
        right, down = xyz[1:-1, 2:] - xyz[1:-1, :-2], xyz[2:, 1:-1] - xyz[:-2, 1:-1]
        across = np.cross(down, right)
        across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-12)
        cosine = (across * normal[1:-1, 1:-1]).sum(-1)[is_flat]
        assert is_flat.sum() > 300
        assert np.median(cosine) > 0.9999
        assert np.mean(cosine > 0.999) > 0.99


def test_sky_pixels_show_the_map_through_exposure_and_white_balance(
    root: Path, cameras: dict[str, Camera], facts: dict
) -> None:
    """photo = display(map(direction) * exposure * white balance), up to JPEG."""
    compared = 0
    for stem, camera in cameras.items():
        is_sky = ~read_mask(root / "undistorted" / "sky_masks" / f"{stem}.png")
        kept = read_mask(root / "undistorted" / "masks" / f"{stem}.png")
        is_sky = erode(is_sky & kept, 9)
        is_sky[:6] = is_sky[-6:] = is_sky[:, :6] = is_sky[:, -6:] = False
        view = facts["views"][stem]
        light = read_linear(root / "ground_truth" / "envmaps" / f"{view['session']}.exr")
        rays = pixel_rays(camera).numpy()[is_sky] @ camera.cam_from_world.numpy()[:3, :3]
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        height, width = light.shape[:2]
        row = np.arccos(-rays[:, 1]) / np.pi * height
        column = (np.arctan2(rays[:, 0], rays[:, 2]) / (2 * np.pi) + 0.5) * width
        radiance = light[row.astype(int), column.astype(int) % width]
        linear = radiance * view["exposure"] * np.array(view["white_balance"])
        expected = np.clip(linear, 0, 1) ** (1 / 2.2)
        photo = read_rgb(root / "undistorted" / "images" / f"{stem}.jpg")[is_sky] / 255.0
        difference = np.abs(photo - expected)
        assert np.median(difference, axis=0).max() < 0.01 if len(photo) else True
        compared += len(photo)
    assert compared > 2000


def test_albedo_is_plausible_and_masks_agree(root: Path, split: dict[str, str]) -> None:
    for stem, part in split.items():
        albedo = read_linear(root / "ground_truth" / "albedo" / f"{stem}.exr")
        is_solid = read_mask(root / "undistorted" / "sky_masks" / f"{stem}.png")
        depth = read_linear(root / "ground_truth" / "depth" / f"{stem}.exr")[..., 0]
        assert ((depth > 0) == is_solid).all()
        assert (albedo[~is_solid] == 0).all()
        assert 0.1 < albedo[is_solid].mean() < 0.6
        assert albedo.max() <= 0.9
        if part == "test":
            is_evaluated = read_mask(root / "eval_files" / "eval_mask" / f"{stem}.png")
            assert not (is_evaluated & ~is_solid).any()
            assert 0.2 < is_evaluated.mean() < 0.8


def test_passers_by_hide_part_of_some_training_photos_only(
    root: Path, split: dict[str, str]
) -> None:
    hidden = {s: 1 - read_mask(root / "undistorted" / "masks" / f"{s}.png").mean() for s in split}
    assert any(hidden[s] > 0.005 for s, part in split.items() if part == "train")
    assert all(hidden[s] == 0 for s, part in split.items() if part == "test")
    assert max(hidden.values()) < 0.4


def digests(root: Path) -> dict[str, str]:
    files = sorted(path for path in root.rglob("*") if path.is_file())
    return {str(p.relative_to(root)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not(tmp_path: Path) -> None:
    for folder, seed in (("a", 1), ("b", 1), ("c", 2)):
        generate(NAME, seed, tmp_path / folder, show_progress=False, **TINY)
    first, second, other = (digests(tmp_path / folder) for folder in "abc")
    assert first == second
    photos = [name for name in first if name.startswith("undistorted/images/")]
    assert not {first[name] for name in photos} & set(other.values())


def test_bad_requests_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.mkdir()
    (taken / "mine.txt").write_text("keep")
    cases = [
        ("castle", tmp_path / "x", {}, f"choose one of {', '.join(SCENES)}"),
        (NAME, tmp_path / "x", {"size_px": (8, 24)}, "width in pixels is 8"),
        (NAME, tmp_path / "x", {"train_views": 1}, "number of training views is 1"),
        (NAME, taken, {}, "already there"),
    ]
    for name, target, options, message in cases:
        with pytest.raises(InputError, match=message):
            generate(name, 0, target, show_progress=False, **options)
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_an_interrupted_run_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("r3gw.benchmark.write.write_shot", stop)
    with pytest.raises(KeyboardInterrupt):
        generate(NAME, 0, tmp_path / NAME, show_progress=False, **TINY)
    assert list(tmp_path.iterdir()) == []
