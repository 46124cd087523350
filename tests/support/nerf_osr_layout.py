"""Builds a tiny scene in the NeRF-OSR layout (docs/data.md), by pycolmap, with made pictures."""

from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import pycolmap

STEMS = (
    "01-08_07_30_IMG_0001",
    "01-08_07_30_IMG_0002",
    "02-08_12_00_IMG_0003",
    "03-08_18_00_IMG_0004",
)
TEST_STEM = STEMS[3]
SIZE = (64, 48)  # width, height
CONFIG = """
import numpy as np

# The author's own paths.
test_views = {{
    "{stem}.JPG": {{
        "mask_path": "/home/author/data/eval_mask/{stem}.png",
        "env_map_path": "/home/author/data/ENV_MAP_CC/03-08_18_00/envmap.jpg",
        "initial_env_map_rotation": {{"x": -95 / 180 * np.pi, "y": 0, "z": 0.0}},
        "env_map_scaling": {{"threshold": 0.99, "scale": 30}},
        "sun_angles": [-(np.pi / 2), np.pi - 0.5],
    }},
}}
"""


@dataclass
class LayoutA:
    """Where the made scene lies, and its model."""

    folder: Path
    model: pycolmap.Reconstruction
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    @property
    def undistorted(self) -> Path:
        """The folder of photos, masks, model and split."""
        return self.folder / "undistorted"

    @property
    def eval_files(self) -> Path:
        """The folder of evaluation masks and environment maps."""
        return self.folder / "eval_files"

    def write_model(self, *, text: bool = False) -> None:
        """Write the model as .bin or .txt, and no other."""
        folder = self.undistorted / "sparse" / "0"
        folder.mkdir(parents=True, exist_ok=True)
        for path in folder.iterdir():
            path.unlink()
        (self.model.write_text if text else self.model.write_binary)(str(folder))

    def write_split(self, text: str | None = None) -> None:
        """Write the split list; by default the last view is a test view."""
        lines = [f"{s}.jpg;{'test' if s == TEST_STEM else 'train'}" for s in STEMS]
        text = "\n".join(["filename;split", *lines]) if text is None else text
        (self.undistorted / "place_split.csv").write_text(text + "\n")

    def write_config(self, text: str | None = None) -> None:
        """Write test_config.py; by default with one entry."""
        text = CONFIG.format(stem=TEST_STEM) if text is None else text
        (self.eval_files / "test_config.py").write_text(text)


def build(folder: Path, *, camera_model: str = "PINHOLE", points: int = 30) -> LayoutA:
    """Write a whole scene of four views in ``folder``."""
    scene = LayoutA(folder, _model(camera_model, points))
    (scene.undistorted).mkdir(parents=True)
    scene.write_model()
    for number, stem in enumerate(STEMS):
        photo = _photo(number)
        suffix = (".jpg", ".JPG", ".png", ".JPEG")[number]
        picture(scene.undistorted / "images" / f"{stem}{suffix}", photo)
        picture(scene.undistorted / "masks" / f"{stem}.PNG", _grey(lambda x, _y: x < 56))
        picture(scene.undistorted / "sky_masks" / f"{stem}.png", _grey(lambda _x, y: y >= 16))
    picture(scene.eval_files / "eval_mask" / f"{TEST_STEM}.png", _grey(lambda x, _y: x >= 32))
    for session, value in (("03-08_18_00", 200), ("01-08_07_30", 100)):
        env_map = np.full((16, 32, 3), value, np.uint8)
        picture(scene.eval_files / "ENV_MAP_CC" / session / "envmap.jpg", env_map)
    scene.write_split()
    scene.write_config()
    return scene


def picture(path: Path, pixels: np.ndarray) -> None:
    """Write a picture with OpenCV itself; folders are made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), pixels)


def _photo(number: int) -> np.ndarray:
    noise = np.random.default_rng(number).integers(60, 120, (SIZE[1], SIZE[0], 3), dtype=np.uint8)
    noise[:16] = (230, 180, 140)  # a blue sky, BGR
    return noise


def _grey(is_white) -> np.ndarray:
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    return is_white(x, y).astype(np.uint8) * 255


def _model(camera_model: str, points: int) -> pycolmap.Reconstruction:
    rng = np.random.default_rng(7)
    model = pycolmap.Reconstruction()
    parameters = {
        "PINHOLE": [70.0, 72.0, 30.5, 25.0],
        "SIMPLE_PINHOLE": [70.0, 30.5, 25.0],
        "SIMPLE_RADIAL": [70.0, 32.0, 24.0, 0.1],
    }
    camera = pycolmap.Camera(
        model=camera_model,
        width=SIZE[0],
        height=SIZE[1],
        params=parameters[camera_model],
        camera_id=1,
    )
    model.add_camera_with_trivial_rig(camera)
    for number, stem in enumerate(STEMS):
        rotation = pycolmap.Rotation3d(np.array([0.05 * number, 0.2 - 0.1 * number, 0.03]))
        pose = pycolmap.Rigid3d(rotation, np.array([0.3 * number, -0.2, 6.0]))
        image = pycolmap.Image(name=f"{stem}.jpg", camera_id=1, image_id=number + 1)
        model.add_image_with_trivial_frame(image, pose)
    for _ in range(points):
        xyz, rgb = rng.uniform(-2, 2, 3), rng.integers(0, 256, 3, dtype=np.uint8)
        model.add_point3D(xyz, pycolmap.Track(), rgb)
    return model
