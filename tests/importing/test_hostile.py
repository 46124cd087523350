"""Broken COLMAP, nerfstudio and original NeRF-OSR folders: each gets its one sentence."""

import json
import shutil

import cv2
import numpy as np
import pytest
from support import formats, nerf_osr_layout

from r3gw.files import InputError
from r3gw.importing.settings import ColmapScene, NerfOsrOriginalScene, NerfstudioScene
from r3gw.importing.stage import import_scene

STEM = nerf_osr_layout.STEMS[0]


@pytest.fixture
def source(tmp_path):
    """A tiny scene in the NeRF-OSR layout, all photos .jpg."""
    place = nerf_osr_layout.build(tmp_path / "place")
    images = place.undistorted / "images"
    for path in list(images.iterdir()):
        pixels = cv2.imread(str(path))
        path.unlink()
        cv2.imwrite(str(images / f"{path.stem}.jpg"), pixels)
    for path in (place.undistorted / "masks").iterdir():
        path.rename(path.with_suffix(".png"))
    return place.folder


def refused(settings, folder, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        import_scene("place", settings, folder, folder.parent / "scene", num_threads=1)
    assert "\n" not in str(caught.value)
    assert not (folder.parent / "scene" / "scene.json").exists()


def cut(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])


def edit_frame(**changes):
    def edit(folder):
        path = folder / "transforms.json"
        content = json.loads(path.read_text())
        content["frames"][0] |= changes
        path.write_text(json.dumps(content))

    return edit


def edit_top(**changes):
    def edit(folder):
        path = folder / "transforms.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | changes))

    return edit


def nan_in_transforms(folder):
    path = folder / "transforms.json"
    content = json.loads(path.read_text())
    content["frames"][0]["transform_matrix"][1][3] = float("nan")
    path.write_text(json.dumps(content))


def double_frame(folder):
    path = folder / "transforms.json"
    content = json.loads(path.read_text())
    content["frames"].append(content["frames"][0])
    path.write_text(json.dumps(content))


def empty_ply(folder):
    path = folder / "sparse_pc.ply"
    text = path.read_text().replace("element vertex 30", "element vertex 0")
    path.write_text(text[: text.index("end_header") + 11])


MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0]).tolist()
FIRST_TWO = [f"images/{stem}.jpg" for stem in nerf_osr_layout.STEMS[:2]]


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda f: (f / "transforms.json").unlink(), r"one file is missing .*transforms\.json"),
        (lambda f: cut(f / "transforms.json"), r"transforms\.json: key '\(whole file\)'"),
        (lambda f: cut(f / "images" / f"{STEM}.jpg"), r"jpg: not a readable picture"),
        (lambda f: (f / "images" / f"{STEM}.jpg").unlink(), rf"one file .*images/{STEM}\.jpg"),
        (lambda f: (f / "masks" / f"{STEM}.png").unlink(), rf"one file .*masks/{STEM}\.png"),
        (lambda f: (f / "sparse_pc.ply").unlink(), r"one file is missing .*sparse_pc\.ply"),
        (lambda f: (f / "sparse_pc.ply").write_text("hello"), r"not readable as a PLY"),
        (empty_ply, r"holds no points"),
        (nan_in_transforms, r"jpg: the pose holds NaN or infinity; correct it or remove"),
        (double_frame, r"has the same stem as"),
        (edit_frame(transform_matrix=MIRROR), r"is no rotation with a translation"),
        (edit_frame(transform_matrix=[[1, 2]]), r"'transform_matrix' is not 4x4"),
        (edit_frame(transform_matrix="up"), r"key 'frames\.0\.transform_matrix'"),
        (edit_frame(fl_x=-1), r"a focal length of -1 px"),
        (edit_frame(fl_x=None), r"states no focal length \(fl_x\); add it"),
        (edit_frame(w=60, h=48), r"the photo is 64x48 px but its camera is 60x48 px"),
        (edit_top(camera_model="EQUIRECTANGULAR"), r"the camera model EQUIRECTANGULAR"),
        (edit_top(train_filenames=FIRST_TWO[:1]), r"only one training photo is left"),
        (edit_top(frames=[]), r"no training photo is left"),
    ],
)
def test_nerfstudio(source, damage, sentence):
    folder = source.parent / "nerfstudio"
    formats.nerfstudio(source, folder)
    damage(folder)
    refused(NerfstudioScene(format="nerfstudio", path="."), folder, sentence)


def nan_pose_text(folder):
    path = folder / "final" / "train" / "pose" / f"{STEM}.txt"
    words = path.read_text().split()
    path.write_text(" ".join(["nan", *words[1:]]))


def skewed(folder):
    path = folder / "final" / "train" / "intrinsics" / f"{STEM}.txt"
    words = path.read_text().split()
    path.write_text(" ".join([words[0], "3.0", *words[2:]]))


def in_both_splits(folder):
    for kind in ("rgb", "pose", "intrinsics"):
        for path in (folder / "final" / "train" / kind).glob(f"{STEM}*"):
            shutil.copy(path, folder / "final" / "test" / kind)


def leave_one(folder):
    for path in sorted((folder / "final" / "train" / "rgb").iterdir())[1:]:
        path.unlink()


def small_labels(folder):
    path = folder / "final" / "train" / "cityscapes_mask" / f"{STEM}.png"
    nerf_osr_layout.picture(path, np.zeros((24, 32, 3), np.uint8))


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda f: (f / "final/train/pose" / f"{STEM}.txt").unlink(), rf"train/pose/{STEM}\.txt"),
        (lambda f: cut(f / "final/train/pose" / f"{STEM}.txt"), r"does not hold the 16 numbers"),
        (lambda f: cut(f / "final/train/rgb" / f"{STEM}.jpg"), r"not a readable picture"),
        (lambda f: shutil.rmtree(f / "final/test"), r"one file is missing .*test/rgb/"),
        (nan_pose_text, r"pose/.*txt: the pose holds NaN or infinity"),
        (skewed, r"intrinsics/.*txt: is no pinhole camera"),
        (in_both_splits, r"is in train and in test"),
        (leave_one, r"only one training photo is left"),
        (small_labels, r"the label map is 32x24 px but its photo is 64x48 px"),
    ],
)
def test_original_nerf_osr(source, damage, sentence, monkeypatch):
    from r3gw.importing.readers import nerf_osr_original
    from r3gw.importing.readers.colmap_model import read_model

    folder = source.parent / "osr"
    formats.nerf_osr_original(source, folder)
    points = read_model(source / "undistorted" / "sparse" / "0").points
    monkeypatch.setattr(nerf_osr_original, "triangulated_points", lambda *_args, **_keys: points)
    damage(folder)
    refused(NerfOsrOriginalScene(format="nerf-osr-original", path="."), folder, sentence)


def two_masks(folder):
    shutil.copy(folder / "masks" / f"{STEM}.jpg.png", folder / "masks" / f"{STEM}.png")


def wrong_separator(folder):
    (path,) = folder.glob("*_split.csv")
    path.write_text(path.read_text().replace(";", ","))


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda f: shutil.rmtree(f / "sparse"), r"one file is missing .*cameras,images,points3D"),
        (lambda f: shutil.rmtree(f / "images"), r"one file is missing .*\(images/\)"),
        (lambda f: (f / "images" / f"{STEM}.jpg").unlink(), rf"not in images/ \({STEM}\.jpg\)"),
        (lambda f: cut(f / "images" / f"{STEM}.jpg"), r"not a readable picture"),
        (lambda f: cut(f / "sparse" / "images.bin"), r"images\.bin: the file is damaged"),
        (two_masks, r"is for the same photo as"),
        (wrong_separator, r"separated by a comma"),
    ],
)
def test_colmap(source, damage, sentence):
    folder = source.parent / "colmap"
    formats.colmap_folder(source, folder)
    damage(folder)
    refused(ColmapScene(format="colmap", path="."), folder, sentence)
