"""Reader of NeRF-OSR scenes as their authors published them: ``final/{train,test}/…``.

Poses and intrinsics are text files with 16 numbers, row by row, in the format of NeRF++
(github.com/Kai-46/nerfplusplus, README, "Data"): the pose is world_from_camera with OpenCV axes.
There is no sparse model, so the initial points are triangulated.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from r3gw.files import InputError
from r3gw.geometry.cameras import Camera
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.folders import require_training_views, session_of
from r3gw.importing.named_files import key_of, pictures_by_key
from r3gw.importing.posed import cam_from_world, camera_of, picture_size
from r3gw.importing.reconstruction.triangulate import triangulated_points
from r3gw.importing.source import SourceMask, SourceScene, SourceView
from r3gw.importing.split import Split
from r3gw.scene import Points

SPLITS: tuple[Split, ...] = ("train", "test")
MATRICES = ("pose", "intrinsics")


def final_folder(source: Path) -> Path:
    """``source/final`` if there is one, else ``source`` itself."""
    return source / "final" if (source / "final").is_dir() else source


def read_nerf_osr_original(source: Path, *, num_threads: int, seed: int) -> SourceScene:
    """Read ``final/{train,test}/{rgb,pose,intrinsics,mask,cityscapes_mask}`` and ``eval_files/``.

    Raises:
        InputError: On a missing file, a matrix that is none, or photos that share no points.
    """
    folder = final_folder(source)
    evaluation = read_evaluation(source / "eval_files")
    views: dict[str, SourceView] = {}
    for split in SPLITS:
        masks = pictures_by_key(folder / split / "mask")
        labels = pictures_by_key(folder / split / "cityscapes_mask")
        for key, photo in pictures_by_key(folder / split / "rgb").items():
            if key in views:
                raise InputError(
                    f"{photo}: is in train and in test; leave it in one, or the test is no test"
                )
            views[key] = SourceView(
                name=photo.stem,
                photo=photo,
                camera=_camera(folder / split, photo),
                split=split,
                session=session_of(photo.stem),
                masks={"is_valid": SourceMask(masks[key])} if key in masks else {},
                labels=labels.get(key),
                evaluation=evaluation.get(key),
            )
    require_training_views((view.split for view in views.values()), folder)
    ordered = tuple(views[key] for key in sorted(views))
    points: Points = triangulated_points(ordered, source, num_threads=num_threads, seed=seed)
    return SourceScene(ordered, points)


def matrix_files(folder: Path, kind: str) -> dict[str, Path]:
    """Text files of one kind of matrix in a split's folder, by the key of their photo."""
    return {
        key_of(path.name): path
        for path in sorted((folder / kind).glob("*"))
        if path.suffix.lower() == ".txt"
    }


def _camera(folder: Path, photo: Path) -> Camera:
    found = {kind: matrix_files(folder, kind).get(key_of(photo.name)) for kind in MATRICES}
    pose_file, intrinsics_file = found["pose"], found["intrinsics"]
    if pose_file is None or intrinsics_file is None:
        kind = "pose" if pose_file is None else "intrinsics"
        raise InputError(
            f"{folder / kind / photo.stem}.txt: no such file, but its photo is there; put it in "
            "place or remove the photo"
        )
    pose = cam_from_world(_matrix(pose_file), str(pose_file))
    matrix = _matrix(intrinsics_file)
    off_axis = matrix[[0, 1, 2, 2], [1, 0, 0, 1]]
    if np.abs(off_axis).max() > 1e-6 or not np.isclose(matrix[2, 2], 1.0, rtol=0, atol=1e-9):
        raise InputError(
            f"{intrinsics_file}: is no pinhole camera (fx 0 cx; 0 fy cy; 0 0 1); correct the matrix"
        )
    fx, fy, cx, cy = (float(matrix[index]) for index in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return camera_of(pose, (fx, fy, cx, cy), *picture_size(photo), str(intrinsics_file))


def _matrix(path: Path) -> NDArray[np.float64]:
    """The 4x4 matrix of a text file, on one line or four."""
    try:
        values = np.array(path.read_text(encoding="utf-8").split(), dtype=np.float64)
    except (ValueError, UnicodeDecodeError):
        values = np.empty(0)
    if values.size != 16:
        raise InputError(f"{path}: does not hold the 16 numbers of a 4x4 matrix; copy it again")
    return values.reshape(4, 4)
