"""Triangulated points lie on the walls that the photos show."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.made_up_place import FOCAL_PX, PLANES, SIZE, place_photo

from r3gw.files import InputError
from r3gw.importing.settings import NerfOsrOriginalScene
from r3gw.importing.stage import import_scene
from r3gw.scene import load_points

pytestmark = pytest.mark.slow


def write(folder, split, number, image, pose):
    for kind in ("rgb", "pose", "intrinsics"):
        (folder / "final" / split / kind).mkdir(parents=True, exist_ok=True)
    base = folder / "final" / split
    cv2.imwrite(str(base / "rgb" / f"photo {number}.png"), image)
    intrinsics = np.diag([FOCAL_PX, FOCAL_PX, 1.0, 1.0])
    intrinsics[:2, 2] = SIZE[0] / 2, SIZE[1] / 2
    np.savetxt(base / "pose" / f"photo {number}.txt", pose)
    np.savetxt(base / "intrinsics" / f"photo {number}.txt", intrinsics.reshape(1, 16))


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """Photos of the made place in the original NeRF-OSR layout; blanks in their names."""
    folder = tmp_path_factory.mktemp("place")
    for number, azimuth in enumerate(np.linspace(-25, 25, 5)):
        angle = np.radians(azimuth)
        pose = np.eye(4)  # world_from_camera
        pose[:3, 3] = 4 * np.sin(angle), -0.2 * (number % 3), 5 - 5 * np.cos(angle)
        pose[:3, :3] = Rotation.from_euler("YX", [-azimuth, 4], degrees=True).as_matrix()
        image = place_photo(pose[:3, :3].T, pose[:3, 3])
        write(folder, "test" if number == 2 else "train", number, image, pose)
    return folder


def distance_to_planes(xyz):
    distances = []
    for point, first, second, _ in PLANES:
        normal = np.cross(first, second)
        distances.append(np.abs((xyz - np.array(point)) @ (normal / np.linalg.norm(normal))))
    return np.min(distances, axis=0)


def test_points_lie_on_the_walls(source, tmp_path):
    settings = NerfOsrOriginalScene(format="nerf-osr-original", path=".", extent=None, up="given")
    scene = import_scene("place", settings, source, tmp_path, num_threads=1)
    assert [view.split for view in scene.views] == ["train", "train", "test", "train", "train"]
    points = load_points(tmp_path)
    assert len(points.xyz) > 200
    distance = distance_to_planes(points.xyz.astype(float))
    assert np.median(distance) < 0.01  # of 5 to 8 units away
    assert np.quantile(distance, 0.95) < 0.05
    assert points.rgb.std() > 5


def test_same_seed_gives_the_same_points(source, tmp_path):
    settings = NerfOsrOriginalScene(format="nerf-osr-original", path=".")
    for name in ("first", "second"):
        import_scene("place", settings, source, tmp_path / name, num_threads=2, seed=4)
    first, second = (tmp_path / name / "points.npz" for name in ("first", "second"))
    assert first.read_bytes() == second.read_bytes()


def test_photos_that_share_nothing_are_refused(tmp_path):
    rng = np.random.default_rng(0)
    for number in range(3):
        noise = rng.integers(0, 255, (SIZE[1], SIZE[0], 3), dtype=np.uint8)
        pose = np.eye(4)
        pose[0, 3] = number
        write(tmp_path, "train" if number else "test", number, noise, pose)
    settings = NerfOsrOriginalScene(format="nerf-osr-original", path=".")
    with pytest.raises(InputError, match=r"only 0 points could be triangulated .* import the"):
        import_scene("noise", settings, tmp_path, tmp_path / "scene", num_threads=1)
