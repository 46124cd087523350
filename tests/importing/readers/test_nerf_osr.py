"""Import of the NeRF-OSR layout: against pycolmap's projection and pictures made in the test."""

import numpy as np
import pytest
import torch
from support import nerf_osr_layout

from r3gw.files import InputError
from r3gw.imaging.files import read_grey, read_rgb
from r3gw.importing.settings import NerfOsrScene
from r3gw.importing.stage import import_scene
from r3gw.scene import load_points, load_scene


@pytest.fixture
def place(tmp_path):
    return nerf_osr_layout.build(tmp_path / "place")


def imported(place, **changes):
    settings = NerfOsrScene(format="nerf-osr", path=".", **changes)
    target = place.folder.parent / "scene"
    return import_scene("place", settings, place.folder, target, num_threads=1), target


def projected(view, xyz):
    camera = view.camera
    inside = xyz.double() @ camera.cam_from_world[:3, :3].T + camera.cam_from_world[:3, 3]
    fx, fy, cx, cy = camera.intrinsics
    x, y, z = inside.unbind(-1)
    return torch.stack([fx * x / z + cx, fy * y / z + cy], dim=-1).numpy()


@pytest.mark.parametrize("camera_model", ["PINHOLE", "SIMPLE_PINHOLE"])
@pytest.mark.parametrize("extent", [None, 10.0])
@pytest.mark.parametrize("max_px", [1600, 32])
def test_points_project_where_pycolmap_puts_them(tmp_path, camera_model, extent, max_px):
    place = nerf_osr_layout.build(tmp_path / "place", camera_model=camera_model)
    scene, target = imported(place, extent=extent, max_image_px=max_px)
    xyz = torch.from_numpy(load_points(target).xyz)
    ordered = [place.model.points3D[i].xyz for i in sorted(place.model.points3D)]
    shrink = min(1.0, max_px / 64)
    for view, image in zip(
        scene.views, sorted(place.model.images.values(), key=lambda i: i.name), strict=True
    ):
        expected = np.array([image.project_point(point) for point in ordered]) * shrink
        np.testing.assert_allclose(projected(view, xyz), expected, rtol=1e-5, atol=1e-3)
        assert read_rgb(target / view.image).shape == (view.height, view.width, 3)
        assert view.source_size_px == (None if max_px == 1600 else (64, 48))


def test_gauge_maps_back_to_the_source(place):
    scene, target = imported(place, extent=10.0)
    xyz = load_points(target).xyz
    distance = np.linalg.norm(xyz - xyz.mean(axis=0), axis=1)
    np.testing.assert_allclose(np.percentile(distance, 99), 10.0, rtol=1e-5, atol=0)
    back = scene.scene_from_source.similarity.inverse().points(torch.from_numpy(xyz).double())
    source = [place.model.points3D[i].xyz for i in sorted(place.model.points3D)]
    np.testing.assert_allclose(back.numpy(), np.array(source), rtol=1e-5, atol=1e-5)


def test_without_extent_nothing_moves(place):
    scene, _ = imported(place)
    similarity = scene.scene_from_source.similarity
    assert similarity.scale == 1.0
    assert torch.equal(similarity.rotation, torch.eye(3, dtype=torch.float64))
    assert not similarity.translation.any()


def test_text_model_gives_the_same_scene(place):
    scene, target = imported(place)
    points = load_points(target)
    place.write_model(text=True)
    again, _ = imported(place)
    for view, other in zip(scene.views, again.views, strict=True):
        np.testing.assert_allclose(
            np.array(view.cam_from_world), np.array(other.cam_from_world), rtol=1e-12, atol=1e-12
        )
    np.testing.assert_allclose(points.xyz, load_points(target).xyz, rtol=1e-6, atol=1e-6)
    assert np.array_equal(points.rgb, load_points(target).rgb)


def test_names_split_sessions_and_masks(place):
    scene, target = imported(place)
    assert [view.name for view in scene.views] == sorted(nerf_osr_layout.STEMS)
    assert [view.split for view in scene.views] == ["train", "train", "train", "test"]
    assert scene.views[0].session == "01-08_07_30"
    is_sky = read_grey(target / "given" / "is_sky" / f"{nerf_osr_layout.STEMS[0]}.png")
    is_valid = read_grey(target / "given" / "is_valid" / f"{nerf_osr_layout.STEMS[0]}.png")
    assert np.array_equal(is_sky == 255, np.mgrid[:48, :64][0] < 16)  # white = NOT sky there
    assert np.array_equal(is_valid == 255, np.mgrid[:48, :64][1] < 56)
    assert load_scene(target) == scene


def test_evaluation_entry_is_resolved_by_file_name(place):
    entry = imported(place)[0].views[3].evaluation
    target = place.folder.parent / "scene"
    np.testing.assert_allclose(entry.rotation_rad, np.radians([-95, 0, 0]), rtol=1e-12, atol=0)
    np.testing.assert_allclose(entry.sun_angles_rad, (-np.pi / 2, np.pi - 0.5), rtol=1e-12, atol=0)
    assert (entry.threshold, entry.scale) == (0.99, 30.0)
    # Two sessions have an envmap.jpg; the value tells which was taken.
    assert abs(int(read_rgb(target / entry.env_map).mean()) - 200) <= 2
    assert np.array_equal(read_grey(target / entry.mask) == 255, np.mgrid[:48, :64][1] >= 32)


def test_second_import_leaves_nothing_of_the_first(place):
    _, target = imported(place)
    place.write_split(
        f"filename;split\n{nerf_osr_layout.STEMS[0]}.JPG;train\n{nerf_osr_layout.STEMS[2]};train"
    )
    scene, _ = imported(place)
    assert len(scene.views) == 2
    left = {path.stem for path in (target / "images").iterdir()}
    assert left == {nerf_osr_layout.STEMS[0], nerf_osr_layout.STEMS[2]}


def test_views_outside_the_split_are_left_out_with_a_warning(place, caplog):
    place.write_split(
        f"filename;split\n{nerf_osr_layout.STEMS[0]}.png;train\n{nerf_osr_layout.STEMS[1]};train"
    )
    assert len(imported(place)[0].views) == 2
    assert "2 of 4 photos are left out: 2 not in place_split.csv" in caplog.text


def break_photo(place):
    (place.undistorted / "images" / f"{nerf_osr_layout.STEMS[0]}.jpg").unlink()


def break_photo_size(place):
    path = place.undistorted / "images" / f"{nerf_osr_layout.STEMS[0]}.jpg"
    nerf_osr_layout.picture(path, np.zeros((48, 60, 3), np.uint8))


def cut_photo_in_half(place):
    path = place.undistorted / "images" / f"{nerf_osr_layout.STEMS[0]}.jpg"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def truncate_photo(place):
    (place.undistorted / "images" / f"{nerf_osr_layout.STEMS[0]}.jpg").write_bytes(
        b"\xff\xd8\xff\xe0"
    )


def break_mask_size(place):
    path = place.undistorted / "masks" / f"{nerf_osr_layout.STEMS[1]}.PNG"
    nerf_osr_layout.picture(path, np.zeros((24, 32), np.uint8))


def double_stem(place):
    path = place.undistorted / "images" / f"{nerf_osr_layout.STEMS[0].lower()}.png"
    nerf_osr_layout.picture(path, np.zeros((48, 64, 3), np.uint8))


def no_split(place):
    (place.undistorted / "place_split.csv").unlink()


def env_map_not_two_to_one(place):
    path = place.eval_files / "ENV_MAP_CC" / "03-08_18_00" / "envmap.jpg"
    nerf_osr_layout.picture(path, np.zeros((16, 20, 3), np.uint8))


def no_env_map(place):
    for path in (place.eval_files / "ENV_MAP_CC").rglob("*.jpg"):
        path.unlink()


def truncated(name):
    def cut(place):
        path = place.undistorted / "sparse" / "0" / f"{name}.bin"
        path.write_bytes(path.read_bytes()[:-20])

    return cut


def nan_pose(place):
    place.write_model(text=True)
    folder = place.undistorted / "sparse" / "0"
    for name in ("rigs", "frames"):
        (folder / f"{name}.txt").unlink()
    lines = (folder / "images.txt").read_text().splitlines()
    nan = [" ".join([w if i not in range(1, 8) else "nan" for i, w in enumerate(l.split())])
           if l.endswith(".jpg") else l for l in lines]  # fmt: skip
    (folder / "images.txt").write_text("\n".join(nan))


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (
            break_photo,
            r"one file is missing .*\(undistorted/images/01-08_07_30_IMG_0001.jpg\)",
        ),
        (break_photo_size, r"the photo is 60x48 px but its camera is 64x48 px"),
        (cut_photo_in_half, r"IMG_0001.jpg: not a readable picture"),
        (truncate_photo, r"IMG_0001.jpg: not a readable picture"),
        (break_mask_size, r"IMG_0002.PNG: the mask is 32x24 px but its photo is 64x48 px"),
        (double_stem, r"has the same stem as"),
        (no_split, r"no \*_split.csv here"),
        (env_map_not_two_to_one, r"20x16 px; an equirectangular map must be twice as wide"),
        (
            no_env_map,
            r"one file is missing .*ENV_MAP_CC/03-08_18_00/envmap.jpg",
        ),
        (truncated("points3D"), r"points3D.bin: the file is damaged or cut off"),
        (truncated("images"), r"images.bin: the file is damaged or cut off"),
        (truncated("cameras"), r"cameras.bin: the file is damaged or cut off"),
        (nan_pose, r"the pose holds NaN or infinity"),
    ],
)
def test_broken_source_gets_one_sentence(place, damage, sentence):
    damage(place)
    with pytest.raises(InputError, match=sentence) as caught:
        imported(place)
    assert "\n" not in str(caught.value)
    assert not (place.folder.parent / "scene" / "scene.json").exists()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("filename,split\na.jpg,train", "separated by a comma; separate them by a semicolon"),
        ("filename\tsplit\na.jpg\ttrain", "separated by a tab"),
        ("a.jpg;train", "the first line is 'a.jpg;train'; it must be 'filename;split'"),
        ("filename;split\na.jpg;val", "line 2 puts a.jpg in the split 'val'"),
        ("filename;split\na.jpg;train\nA.JPG;test", "line 3 names A.JPG a second time"),
        ("filename;split\na.jpg", "line 2 has 1 columns"),
        ("", "is empty"),
        (f"filename;split\n{nerf_osr_layout.STEMS[0]}.jpg;test", "no training photo is left"),
        (
            f"filename;split\n{nerf_osr_layout.STEMS[0]}.jpg;train",
            "only one training photo is left",
        ),
    ],
)
def test_wrong_split_file_gets_one_sentence(place, text, sentence):
    place.write_split(text)
    with pytest.raises(InputError, match=sentence):
        imported(place)


def test_distorted_cameras_are_refused(tmp_path):
    place = nerf_osr_layout.build(tmp_path / "place", camera_model="SIMPLE_RADIAL")
    with pytest.raises(InputError, match="has the model SIMPLE_RADIAL"):
        imported(place)


def test_model_without_images_or_with_nothing_to_triangulate_is_refused(tmp_path):
    place = nerf_osr_layout.build(tmp_path / "place", points=0)
    with pytest.raises(InputError, match="only 0 points could be triangulated"):
        imported(place)
    place.model = type(place.model)()
    place.write_model()
    with pytest.raises(InputError, match="has no images with a pose"):
        imported(place)
