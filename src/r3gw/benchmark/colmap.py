"""The COLMAP models of a generated scene: of its pinhole photos, and of its distorted originals."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pycolmap
from numpy.typing import NDArray

from r3gw.benchmark.devices import Device
from r3gw.benchmark.points import Points
from r3gw.benchmark.write import ORIGINALS, Taken


def write_model(root: Path, shots: Sequence[Taken], points: Points) -> None:
    """The COLMAP model: PINHOLE cameras, poses, points with tracks.

    Every photo has a camera of its own, or shares its device's. Where there are devices, the folder
    ``originals`` gets a second model, of the photos as they left the device: the same poses and
    points, and one SIMPLE_RADIAL camera per device. Tracks number the training shots only, in the
    order of ``shots``.
    """
    folder = root / "undistorted" / "sparse" / "0"
    _model(shots, points, _pinholes(shots), lambda _, pixels: pixels, folder)
    if any(shot.device is not None for shot in shots):
        folder = root / ORIGINALS / "sparse" / "0"
        _model(shots, points, _lenses(shots), _in_original, folder)


def _pinholes(shots: Sequence[Taken]) -> list[pycolmap.Camera]:
    """A PINHOLE camera per shot, with the number of the first shot of the same device."""
    first: dict[Device, int] = {}
    cameras = []
    for i, shot in enumerate(shots):
        number = i if shot.device is None else first.setdefault(shot.device, i)
        cameras.append(
            pycolmap.Camera(
                model="PINHOLE",
                width=shot.camera.width,
                height=shot.camera.height,
                params=list(shot.camera.intrinsics),
                camera_id=number + 1,
            )
        )
    return cameras


def _lenses(shots: Sequence[Taken]) -> list[pycolmap.Camera]:
    """The SIMPLE_RADIAL camera of each shot's device, numbered as by `_pinholes`."""
    cameras = []
    for shot, pinhole in zip(shots, _pinholes(shots), strict=True):
        assert shot.device is not None  # the caller's choice
        width, height = shot.device.original_size(shot.camera)
        focal_px = shot.camera.intrinsics[0]
        cameras.append(
            pycolmap.Camera(
                model="SIMPLE_RADIAL",
                width=width,
                height=height,
                params=[focal_px, width / 2, height / 2, shot.device.distortion],
                camera_id=pinhole.camera_id,
            )
        )
    return cameras


def _in_original(shot: Taken, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    assert shot.device is not None  # the caller's choice
    return shot.device.distorted(pixels, shot.camera)


def _model(
    shots: Sequence[Taken],
    points: Points,
    cameras: Sequence[pycolmap.Camera],
    place_pixels: Callable[[Taken, NDArray[np.float64]], NDArray[np.float64]],
    folder: Path,
) -> None:
    """Write one model; ``place_pixels`` says where a shot's keypoints lie in its picture."""
    model = pycolmap.Reconstruction()
    trained = [i for i, shot in enumerate(shots) if not shot.session.is_test]
    seen: dict[int, list[tuple[float, float]]] = {i: [] for i in range(len(shots))}
    places: list[list[tuple[int, int]]] = []
    for track in points.tracks:
        places.append([])
        for number, x, y in track:
            shown = trained[number]
            places[-1].append((shown + 1, len(seen[shown])))
            seen[shown].append((x, y))
    known = set()
    for i, (shot, camera) in enumerate(zip(shots, cameras, strict=True)):
        if camera.camera_id not in known:
            known.add(camera.camera_id)
            model.add_camera_with_trivial_rig(camera)
        keypoints = place_pixels(shot, np.array(seen[i], dtype=np.float64).reshape(-1, 2))
        image = pycolmap.Image(f"{shot.stem}.jpg", keypoints, camera.camera_id, i + 1)
        pose = pycolmap.Rigid3d(shot.camera.cam_from_world.numpy()[:3])
        model.add_image_with_trivial_frame(image, pose)
    for xyz, rgb, spots in zip(points.xyz, points.rgb, places, strict=True):
        elements = [pycolmap.TrackElement(number, index) for number, index in spots]
        model.add_point3D(xyz, pycolmap.Track(elements), rgb)
    folder.mkdir(parents=True)
    model.write_binary(str(folder))
