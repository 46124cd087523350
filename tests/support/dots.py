"""Scenes of a few dots in known places, photographed through any lens, in COLMAP's form.

A dot is a bright blob, drawn where a formula of OpenCV puts it (of pycolmap, for lenses that OpenCV
does not have); after an import it must lie where the imported camera sees the imported point.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pycolmap
from scipy.spatial.transform import Rotation

SIZE = (320, 240)
FOCAL_PX, CENTRE = 260.0, (158.0, 121.5)
SIGMA_PX = 1.5
TURNS_DEG = (-24.0, -8.0, 8.0, 24.0)
# Distortions of about 10 px at the corners, behind COLMAP's focal lengths and principal point.
LENSES: dict[str, tuple[float, ...]] = {
    "SIMPLE_PINHOLE": (),
    "PINHOLE": (),
    "SIMPLE_RADIAL": (-0.08,),
    "RADIAL": (-0.09, 0.03),
    "OPENCV": (-0.09, 0.03, 0.002, -0.001),
    "FULL_OPENCV": (-0.09, 0.03, 0.002, -0.001, 0.01, 0.02, -0.01, 0.005),
    "SIMPLE_RADIAL_FISHEYE": (0.03,),
    "RADIAL_FISHEYE": (0.03, -0.01),
    "OPENCV_FISHEYE": (0.03, -0.01, 0.004, 0.002),
    "SIMPLE_FISHEYE": (),
    "FISHEYE": (),
    "FOV": (0.5,),
    "THIN_PRISM_FISHEYE": (0.03, -0.01, 0.001, -0.001, 0.004, 0.002, 0.001, 0.001),
    "RAD_TAN_THIN_PRISM_FISHEYE": (0.03, -0.01, 0.004, 0, 0, 0, 0.001, 0.001, 0.001, 0, 0, 0),
    "SIMPLE_DIVISION": (-0.05,),
    "DIVISION": (-0.05,),
    "EUCM": (0.5, 1.1),
}
_ONE_FOCAL = ("RADIAL", "RADIAL_FISHEYE")
_APART_PX = 18  # in every photo, so that no blob disturbs another
_COUNT = 14


def parameters(model: str, focal_px: float = FOCAL_PX) -> list[float]:
    """COLMAP's parameters of a lens; two focal lengths differ."""
    one = model.startswith("SIMPLE_") or model in _ONE_FOCAL
    focal = [focal_px] if one else [focal_px, focal_px * 1.02]
    return [*focal, *CENTRE, *LENSES[model]]


def pose(turn_deg: float) -> np.ndarray:
    """``cam_from_world`` of a camera that looks at the dots; the world's up is -y."""
    result = np.eye(4)
    result[:3, :3] = Rotation.from_euler("YX", [turn_deg, 3.0], degrees=True).as_matrix()
    result[:3, 3] = 0.1, -0.05, 6.0
    return result


def _spread_points() -> np.ndarray:
    """Points ``[N, 3]`` that lie apart in all photos."""
    rng = np.random.default_rng(5)
    chosen: list[np.ndarray] = []
    while len(chosen) < _COUNT:
        candidate = rng.uniform([-1.8, -1.2, -0.8], [1.8, 1.2, 0.8])
        if all(_apart_px(candidate, other) > _APART_PX for other in chosen):
            chosen.append(candidate)
    return np.stack(chosen)


def _apart_px(first: np.ndarray, second: np.ndarray) -> float:
    distances = []
    for matrix in map(pose, TURNS_DEG):
        inside = np.stack([first, second]) @ matrix[:3, :3].T + matrix[:3, 3]
        distances.append(np.linalg.norm(np.diff(inside[:, :2] / inside[:, 2:], axis=0)))
    return FOCAL_PX * float(min(distances))


POINTS = _spread_points()


def projected(model: str, values: Sequence[float], xyz: np.ndarray) -> np.ndarray:
    """Pixels ``[N, 2]`` (centres at +0.5) of points in the camera's frame."""
    one = model.startswith("SIMPLE_") or model in _ONE_FOCAL
    fx, fy, cx, cy = (values[0], *values[:3]) if one else values[:4]
    extra = np.array(values[3 if one else 4 :], dtype=np.float64)
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    zero = np.zeros(3)
    if model in ("SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV"):
        brown = extra if len(extra) >= 4 else np.concatenate([extra, np.zeros(4 - len(extra))])
        return cv2.projectPoints(xyz[:, None], zero, zero, matrix, brown)[0][:, 0]
    if model in ("SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE", "OPENCV_FISHEYE"):
        radial = np.concatenate([extra, np.zeros(4 - len(extra))])
        return cv2.fisheye.projectPoints(xyz[:, None], zero, zero, matrix, radial)[0][:, 0]
    camera = pycolmap.Camera(model=model, width=SIZE[0], height=SIZE[1], params=list(values))
    return np.array([camera.img_from_cam(point) for point in xyz])


def picture(pixels: np.ndarray, size: tuple[int, int] = SIZE) -> np.ndarray:
    """A grey picture with a bright blob at each of ``pixels``."""
    down, right = np.mgrid[: size[1], : size[0]] + 0.5
    image = np.full(size[::-1], 20.0)
    for x, y in pixels:
        image += 220 * np.exp(-((right - x) ** 2 + (down - y) ** 2) / (2 * SIGMA_PX**2))
    return np.clip(image, 0, 255).round().astype(np.uint8)


@dataclass
class Dots:
    """A written scene: its folder, its poses and the names of its photos."""

    folder: Path
    poses: list[np.ndarray]
    names: list[str]


def photograph(
    folder: Path, model: str, values: Sequence[float], names: Sequence[str] | None = None
) -> Dots:
    """Write ``folder/images`` with a photo per camera."""
    poses = [pose(turn) for turn in TURNS_DEG]
    names = list(names or [f"photo_{number}.png" for number in range(len(poses))])
    for name, cam_from_world in zip(names, poses, strict=True):
        path = folder / "images" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        inside = POINTS @ cam_from_world[:3, :3].T + cam_from_world[:3, 3]
        path.write_bytes(
            cv2.imencode(path.suffix, picture(projected(model, values, inside)))[1].tobytes()
        )
    return Dots(folder, poses, names)


def reconstruction(
    dots: Dots,
    model: str,
    values: Sequence[float],
    *,
    per_image: bool = False,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
    images: Sequence[int] | None = None,
) -> pycolmap.Reconstruction:
    """COLMAP's model of dots whose world begins at ``offset``, of all photos or some."""
    result = pycolmap.Reconstruction()
    chosen = range(len(dots.poses)) if images is None else images
    for number in range(len(dots.poses) if per_image else 1):
        camera = pycolmap.Camera(
            model=model, width=SIZE[0], height=SIZE[1], params=list(values), camera_id=number + 1
        )
        result.add_camera_with_trivial_rig(camera)
    for number in chosen:
        matrix = dots.poses[number][:3].copy()
        matrix[:, 3] -= matrix[:, :3] @ np.array(offset, dtype=np.float64)
        image = pycolmap.Image(
            name=dots.names[number], camera_id=number + 1 if per_image else 1, image_id=number + 1
        )
        result.add_image_with_trivial_frame(image, pycolmap.Rigid3d(matrix))
    for point in POINTS + np.array(offset, dtype=np.float64):
        result.add_point3D(point, pycolmap.Track(), np.array([200, 180, 20], np.uint8))
    return result


def colmap(folder: Path, model: str = "PINHOLE", *, text: bool = True, **options) -> Dots:
    """A COLMAP folder of dots, its model in ``sparse/0``."""
    names = options.pop("names", None)
    values = parameters(model)
    dots = photograph(folder, model, values, names)
    write_model(reconstruction(dots, model, values, **options), folder / "sparse" / "0", text=text)
    return dots


def write_model(model: pycolmap.Reconstruction, folder: Path, *, text: bool = True) -> None:
    """Write the three files of a model, without the rigs and frames of newer COLMAP."""
    folder.mkdir(parents=True, exist_ok=True)
    (model.write_text if text else model.write_binary)(str(folder))
    for name in ("rigs", "frames"):
        (folder / f"{name}{'.txt' if text else '.bin'}").unlink()


def errors_px(scene, xyz: np.ndarray, folder: Path) -> list[float]:
    """How far each blob of an imported scene lies from where its camera sees its point, in px."""
    errors = []
    for view in scene.views:
        image = cv2.imread(str(folder / view.image), cv2.IMREAD_GRAYSCALE).astype(np.float64)
        matrix = np.array(view.cam_from_world)
        inside = xyz @ matrix[:3, :3].T + matrix[:3, 3]
        fx, fy, cx, cy = view.intrinsics
        for x, y in inside[:, :2] / inside[:, 2:] * [fx, fy] + [cx, cy]:
            if 8 < x < view.width - 8 and 8 < y < view.height - 8:
                errors.append(_distance_to_blob(image, x, y))
    assert len(errors) > 0.7 * len(POINTS) * len(scene.views)
    return errors


def _distance_to_blob(image: np.ndarray, x: float, y: float) -> float:
    """From (x, y) to the centroid of what is bright within some pixels."""
    left, top = int(x) - 7, int(y) - 7
    window = np.maximum(image[top : top + 15, left : left + 15] - 60, 0)
    if not window.any():
        return np.inf
    down, right = np.mgrid[:15, :15] + 0.5
    centre = [(grid * window).sum() / window.sum() for grid in (right, down)]
    return float(np.hypot(centre[0] + left - x, centre[1] + top - y))
