"""Every lens that docs/data.md promises: what was photographed lies where the camera sees it."""

import json

import numpy as np
import pytest
from support import dots

from r3gw.files import InputError
from r3gw.imaging.files import write_image
from r3gw.importing.settings import ColmapScene, NerfstudioScene
from r3gw.importing.stage import import_scene
from r3gw.scene import load_points

WITHIN_PX = 0.5
BROWN = {"k1": -0.09, "k2": 0.03, "p1": 0.002, "p2": -0.001}
FISHEYE = {"k1": 0.03, "k2": -0.01, "k3": 0.004, "k4": 0.002}
BROWN_K, FISHEYE_K = tuple(BROWN.values()), tuple(FISHEYE.values())


def imported(settings, folder, target):
    scene = import_scene("dots", settings, folder, target, num_threads=1)
    return scene, load_points(target)


def assert_dots_in_place(scene, points, folder):
    assert len(scene.views) == len(dots.TURNS_DEG)
    errors = dots.errors_px(scene, points.xyz.astype(np.float64), folder)
    assert max(errors) < WITHIN_PX


@pytest.mark.slow
@pytest.mark.parametrize("text", [True, False], ids=["text", "binary"])
@pytest.mark.parametrize("per_image", [True, False], ids=["per image", "shared"])
@pytest.mark.parametrize("model", dots.LENSES)
def test_colmap(tmp_path, model, per_image, text):
    dots.colmap(tmp_path / "colmap", model, text=text, per_image=per_image)
    settings = ColmapScene(format="colmap", path=".")
    scene, points = imported(settings, tmp_path / "colmap", tmp_path / "scene")
    assert_dots_in_place(scene, points, tmp_path / "scene")
    # The camera is the photo's own, not one of another photo or of freed memory.
    for view in scene.views:
        assert 0.7 * dots.SIZE[0] < view.width <= 1.3 * dots.SIZE[0]
        assert 0.5 * dots.FOCAL_PX < view.intrinsics[0] < 1.5 * dots.FOCAL_PX


def nerfstudio(folder, model, values, top):
    """transforms.json of the dots, poses in OpenGL's axes, points as a PLY file."""
    made = dots.photograph(folder, model, values)
    frames = [
        {
            "file_path": f"images/{name}",
            "transform_matrix": (np.linalg.inv(pose) @ np.diag([1, -1, -1, 1])).tolist(),
        }
        for name, pose in zip(made.names, made.poses, strict=True)
    ]
    size = {"w": dots.SIZE[0], "h": dots.SIZE[1], "cx": dots.CENTRE[0], "cy": dots.CENTRE[1]}
    content = {"ply_file_path": "points.ply", **size, **top, "frames": frames}
    (folder / "transforms.json").write_text(json.dumps(content))
    kinds = [f"property double {axis}" for axis in "xyz"]
    kinds += [f"property uchar {colour}" for colour in ("red", "green", "blue")]
    head = ["ply", "format ascii 1.0", f"element vertex {len(dots.POINTS)}", *kinds, "end_header"]
    rows = [f"{x!r} {y!r} {z!r} 9 9 9" for x, y, z in dots.POINTS.tolist()]
    (folder / "points.ply").write_text("\n".join([*head, *rows]) + "\n")


FOCAL = {"fl_x": dots.FOCAL_PX, "fl_y": dots.FOCAL_PX}
ANGLE = {"camera_angle_x": 2 * np.arctan(0.5 * dots.SIZE[0] / dots.FOCAL_PX)}
NERFSTUDIO = {
    "PINHOLE": (FOCAL | {"camera_model": "PINHOLE"}, "OPENCV", ()),
    "SIMPLE_PINHOLE": (ANGLE | {"camera_model": "SIMPLE_PINHOLE"}, "OPENCV", ()),
    "SIMPLE_RADIAL": (FOCAL | {"camera_model": "SIMPLE_RADIAL", "k1": -0.09}, "OPENCV", (-0.09,)),
    "RADIAL": (
        FOCAL | {"camera_model": "RADIAL", "k1": -0.09, "k2": 0.03}, "OPENCV", (-0.09, 0.03)
    ),
    "OPENCV": (FOCAL | {"camera_model": "OPENCV"} | BROWN, "OPENCV", BROWN_K),
    "no model": (FOCAL | BROWN, "OPENCV", BROWN_K),
    # nerfstudio takes the distortion whatever the name of a perspective camera.
    "PINHOLE with k": (FOCAL | {"camera_model": "PINHOLE"} | BROWN, "OPENCV", BROWN_K),
    "k3": (
        FOCAL | {"camera_model": "OPENCV", "k3": 0.02} | BROWN,
        "FULL_OPENCV",
        (*BROWN_K, 0.02, 0, 0, 0),
    ),
    "OPENCV_FISHEYE": (
        FOCAL | {"camera_model": "OPENCV_FISHEYE"} | FISHEYE, "OPENCV_FISHEYE",
        FISHEYE_K,
    ),
    "is_fisheye": (FOCAL | {"is_fisheye": True} | FISHEYE, "OPENCV_FISHEYE", FISHEYE_K),
    "x_fov": (
        {"x_fov": float(np.degrees(ANGLE["camera_angle_x"])), "aabb_scale": 4}, "OPENCV", ()
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", NERFSTUDIO)
def test_nerfstudio(tmp_path, case):
    top, model, extra = NERFSTUDIO[case]
    extra = (*extra, 0, 0, 0, 0)[: max(4, len(extra))]
    values = [dots.FOCAL_PX, dots.FOCAL_PX, *dots.CENTRE, *extra]
    nerfstudio(tmp_path / "ns", model, values, top)
    settings = NerfstudioScene(format="nerfstudio", path=".")
    scene, points = imported(settings, tmp_path / "ns", tmp_path / "scene")
    assert_dots_in_place(scene, points, tmp_path / "scene")


@pytest.mark.parametrize(
    ("top", "sentence"),
    [
        ({"k4": 0.02}, r"k4 \(0\.02\) of a perspective camera .* fit the camera again"),
        ({"k5": 0.01}, r"the key 'k5' \(0\.01\) changes what the cameras see"),
        ({"ftheta_p0": 1.0}, r"the key 'ftheta_p0'"),
        ({"orthographic": True}, r"the key 'orthographic'"),
        ({"rolling_shutter": [0.1, 0, 0, 0]}, r"the key 'rolling_shutter'"),
        ({"distortion_params": [0.1]}, r"the key 'distortion_params'"),
        ({"camera_model": "EQUIRECTANGULAR"}, r"the camera model EQUIRECTANGULAR"),
        ({"is_fisheye": True, "camera_model": "PINHOLE"}, r"contradict each other"),
        ({"is_fisheye": True, "p1": 0.1}, r"a fisheye camera has no p1 and p2"),
        ({"cx": 0.5, "cy": 0.5, "fl_x": 0.8, "fl_y": 0.8}, r"a focal length of 0\.8 px cannot"),
        ({"cx": 0.5, "cy": 0.5}, r"the principal point \(0\.5, 0\.5\) is stated in pixels"),
        ({"cx": 5000.0}, r"the principal point \(5000, 121\.5\) px lies far outside"),
        ({"w": 320.5}, r"the size 320\.5x240 px is none"),
        ({"fl_x": None, "camera_angle_x": 4.0}, r"a field of view of 229\.183 degrees is none"),
    ],
)
def test_what_would_change_geometry_unread_is_refused(tmp_path, top, sentence):
    values = [dots.FOCAL_PX, dots.FOCAL_PX, *dots.CENTRE, 0, 0, 0, 0]
    nerfstudio(tmp_path / "ns", "OPENCV", values, FOCAL | top)
    with pytest.raises(InputError, match=sentence):
        imported(NerfstudioScene(format="nerfstudio", path="."), tmp_path / "ns", tmp_path / "s")


def test_unknown_keys_that_say_nothing_of_geometry_are_named(tmp_path, caplog):
    values = [dots.FOCAL_PX, dots.FOCAL_PX, *dots.CENTRE, 0, 0, 0, 0]
    harmless = {"photographer": "me", "applied_transform": [[1, 0, 0, 0]], "k5": 0.0}
    nerfstudio(tmp_path / "ns", "OPENCV", values, FOCAL | harmless)
    imported(NerfstudioScene(format="nerfstudio", path="."), tmp_path / "ns", tmp_path / "scene")
    assert "keys of transforms.json that r3gw does not know: photographer" in caplog.text


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_byte_order_marks_and_backslashes_of_windows(tmp_path, encoding):
    values = [dots.FOCAL_PX, dots.FOCAL_PX, *dots.CENTRE, 0, 0, 0, 0]
    nerfstudio(tmp_path / "ns", "OPENCV", values, FOCAL)
    path = tmp_path / "ns" / "transforms.json"
    path.write_text(path.read_text().replace("images/", ".\\\\images\\\\"), encoding=encoding)
    settings = NerfstudioScene(format="nerfstudio", path=".")
    assert_dots_in_place(
        *imported(settings, tmp_path / "ns", tmp_path / "scene"), tmp_path / "scene"
    )


def test_transforms_in_latin_1_name_the_cause(tmp_path):
    nerfstudio(tmp_path, "OPENCV", [*[dots.FOCAL_PX] * 2, *dots.CENTRE, 0, 0, 0, 0], FOCAL)
    path = tmp_path / "transforms.json"
    path.write_bytes(path.read_bytes().replace(b"photo_0", b"caf\xe9"))
    with pytest.raises(InputError, match=r"is not text in UTF-8 \(Latin-1\?\)"):
        imported(NerfstudioScene(format="nerfstudio", path="."), tmp_path, tmp_path / "scene")


def test_masks_of_no_photo_are_named(tmp_path, caplog):
    values = [dots.FOCAL_PX, dots.FOCAL_PX, *dots.CENTRE, 0, 0, 0, 0]
    nerfstudio(tmp_path / "ns", "OPENCV", values, FOCAL)
    write_image(tmp_path / "ns/masks/mask_0001.png", np.ones((2, 2), np.bool_))
    imported(NerfstudioScene(format="nerfstudio", path="."), tmp_path / "ns", tmp_path / "scene")
    assert "masks in masks/ that belong to no photo are not used: mask_0001.png; " in caplog.text
    report = json.loads((tmp_path / "scene/sfm_report.json").read_text())
    assert any("mask_0001.png" in note for note in report["notes"])
