"""Normal maps that come with photos: every way of writing the same normals gives the same ones."""

import numpy as np
import pytest
import torch
from PIL import Image
from scipy.spatial.transform import Rotation

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.files import read_linear, write_exr, write_image
from r3gw.importing.normals import with_normals, world_normals
from r3gw.importing.source import SourceNormals, SourcePoints, SourceScene, SourceView
from r3gw.importing.write import write_scene

WIDTH, HEIGHT = 24, 18
TURN = Rotation.from_euler("yx", [40, -15], degrees=True).as_matrix()


def camera() -> Camera:
    pose = torch.eye(4, dtype=torch.float64)
    pose[:3, :3] = torch.from_numpy(TURN)
    return Camera(pose, (30.0, 30.0, WIDTH / 2, HEIGHT / 2), WIDTH, HEIGHT)


def true_normals() -> np.ndarray:
    """Unit normals in world axes, scattered about the way back to the camera."""
    back = -pixel_rays(camera()).double().numpy()
    random = np.random.default_rng(0).normal(0, 0.3, back.shape)
    seen = back / np.linalg.norm(back, axis=-1, keepdims=True) + random
    seen /= np.linalg.norm(seen, axis=-1, keepdims=True)
    return seen @ TURN  # world from camera


def in_axes(axes: str) -> np.ndarray:
    if axes == "world":
        return true_normals()
    seen = true_normals() @ TURN.T
    return seen * [1, -1, -1] if axes == "opengl" else seen


def written(folder, values: np.ndarray, kind: str):
    path = folder / f"a.{'exr' if kind == 'exr' else 'png'}"
    if kind == "exr":
        write_exr(path, values.astype(np.float32))
    elif kind == "png":
        write_image(path, np.round(127.5 * (values + 1)).astype(np.uint8))
    return path


def angles_deg(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip((first * second).sum(-1), -1, 1)))


@pytest.mark.parametrize("kind", ["exr", "png"])
@pytest.mark.parametrize("axes", ["opencv", "opengl", "world"])
def test_all_axes_and_files_mean_the_same(tmp_path, axes, kind):
    path = written(tmp_path, in_axes(axes), kind)
    found = world_normals(SourceNormals(path, axes), camera(), None, (WIDTH, HEIGHT))
    # A step of 8 bits is 0.45 degrees of a unit vector's component.
    assert angles_deg(found, true_normals()).max() < (0.1 if kind == "exr" else 0.6)
    np.testing.assert_allclose(np.linalg.norm(found, axis=-1), 1, rtol=0, atol=1e-5)


def test_what_is_no_vector_is_no_normal(tmp_path):
    values = in_axes("opencv")
    values[:4] = -1.0  # black
    values[4:6] = 0.0  # grey
    path = written(tmp_path, values, "png")
    found = world_normals(SourceNormals(path, "opencv"), camera(), None, (WIDTH, HEIGHT))
    assert not found[:6].any()
    assert (np.linalg.norm(found[6:], axis=-1) > 0.99).all()


@pytest.mark.parametrize(
    ("axes", "change", "said"),
    [
        ("opengl", lambda v: v, "with opengl axes only 0 % of its normals face the camera"),
        ("opencv", lambda v: v[:-2], "24x16 px but its photo is 24x18 px"),
        ("opencv", lambda v: 0.1 * v, "hardly any unit vector"),
    ],
)
def test_maps_that_cannot_be_meant_are_refused(tmp_path, axes, change, said):
    path = written(tmp_path, change(in_axes("opencv")), "png")
    with pytest.raises(InputError) as error:
        world_normals(SourceNormals(path, axes), camera(), None, (WIDTH, HEIGHT))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_grey_picture_is_refused(tmp_path):
    Image.fromarray(np.full((HEIGHT, WIDTH), 200, np.uint8)).save(tmp_path / "a.png")
    with pytest.raises(InputError, match="three channels, x, y and z"):
        world_normals(SourceNormals(tmp_path / "a.png", "opencv"), camera(), None, (WIDTH, HEIGHT))


def test_they_turn_and_shrink_with_the_scene(tmp_path):
    """Found by the photo's name, turned as the import turns the world, pixels kept whole."""
    (tmp_path / "normals").mkdir()
    written(tmp_path / "normals", in_axes("opengl"), "exr")
    write_image(tmp_path / "a.jpg", np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    write_image(tmp_path / "b.jpg", np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    views = tuple(SourceView(n, tmp_path / n, camera(), "train") for n in ("a.jpg", "b.jpg"))
    points = SourcePoints(np.zeros((1, 3)), np.zeros((1, 3), np.uint8))
    found = with_normals(SourceScene(views, points), "opengl", tmp_path / "normals")
    assert found.notes == ("1 of 2 photos have a normal map, read with opengl axes",)
    up = torch.from_numpy(Rotation.from_euler("z", 90, degrees=True).as_matrix())
    turned = Similarity(2.0, up, torch.zeros(3, dtype=torch.float64))
    folder = tmp_path / "scene"
    made = write_scene(found, turned, folder, name="a", source_format="colmap", max_image_px=12)
    first, second = made.views
    assert second.normals is None
    assert first.normals == "given/normals/a.exr"
    stored = read_linear(folder / first.normals)
    assert stored.shape == (9, 12, 3)
    x, y, z = np.moveaxis(true_normals()[1::2, 1::2], -1, 0)
    assert angles_deg(stored, np.stack([-y, x, z], axis=-1)).max() < 0.1
