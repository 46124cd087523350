"""Frames of a video: the sharp ones are taken, and they register."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.made_up_place import FOCAL_PX, SIZE, place_photo

from r3gw.files import InputError
from r3gw.imaging.files import read_rgb
from r3gw.importing.reconstruction.video import extract_frames
from r3gw.importing.settings import PhotosScene
from r3gw.importing.stage import import_scene

pytestmark = pytest.mark.slow


def write_video(path, frames):
    height, width = frames[0].shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10, (width, height))
    for frame in frames:
        writer.write(frame if frame.ndim == 3 else np.repeat(frame[..., None], 3, axis=2))
    writer.release()


def test_the_sharpest_frame_of_each_stretch_is_taken(tmp_path):
    rng = np.random.default_rng(0)
    sharp = {1, 5, 8}  # one in each stretch of four
    frames = []
    for number in range(12):
        noise = rng.integers(0, 60, (48, 64), dtype=np.uint8)
        noise = noise if number in sharp else cv2.GaussianBlur(noise, (9, 9), 3)
        noise[:, :32] = 20 * number  # a mark that survives compression
        frames.append(noise)
    write_video(tmp_path / "walk.avi", frames)
    extract_frames(tmp_path / "walk.avi", tmp_path / "frames", 3)
    taken = sorted((tmp_path / "frames").iterdir())
    assert [path.name for path in taken] == [f"frame_0000{n}.png" for n in range(3)]
    marks = {round(read_rgb(path)[:, :24].mean() / 20) for path in taken}
    assert marks == sharp
    extract_frames(tmp_path / "walk.avi", tmp_path / "all", 100)
    assert len(list((tmp_path / "all").iterdir())) == 12


def test_a_file_that_is_no_video_is_refused(tmp_path):
    (tmp_path / "walk.mp4").write_bytes(b"no video")
    settings = PhotosScene(format="photos", path=".")
    with pytest.raises(InputError, match=r"walk\.mp4: not a readable video .* convert it to MP4"):
        import_scene("walk", settings, tmp_path / "walk.mp4", tmp_path / "scene", num_threads=1)


def test_a_walk_past_the_place_registers_with_one_camera(tmp_path):
    frames = []
    for number, azimuth in enumerate(np.linspace(-24, 24, 9)):
        angle = np.radians(azimuth)
        centre = np.array([4 * np.sin(angle), -0.1 * number, 5 - 5 * np.cos(angle)])
        turn = Rotation.from_euler("YX", [-azimuth, 5], degrees=True)
        frames += [place_photo(turn.as_matrix().T, centre)] * 2
    write_video(tmp_path / "walk.avi", frames)
    settings = PhotosScene(format="photos", path=".", video_frames=9)
    scene = import_scene(
        "walk", settings, tmp_path / "walk.avi", tmp_path / "scene", num_threads=1, seed=1
    )
    assert len(scene.views) == 9
    assert len({view.intrinsics for view in scene.views}) == 1
    first = scene.views[0]
    assert first.intrinsics[0] == pytest.approx(FOCAL_PX * first.width / SIZE[0], rel=0.1)
    centres = np.stack([view.camera.centre.numpy() for view in scene.views])
    steps = np.linalg.norm(np.diff(centres, axis=0), axis=1)
    assert steps.max() < 1.3 * steps.min()  # even steps, in order of time
