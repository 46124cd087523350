"""Depths and points of a textured, tilted wall whose pictures are known in closed form."""

import numpy as np
import pytest
import torch
from support.settings import train_settings

from r3gw.geometry.cameras import Camera, pixel_rays
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.files import write_image
from r3gw.model.initial import load_initial
from r3gw.model.stage import run_initialise
from r3gw.scene import Gauge, Points, Scene, View, save_points, save_scene
from r3gw.stereo.agreement import confirmed, thinned
from r3gw.stereo.completion import completed
from r3gw.stereo.neighbours import neighbours
from r3gw.stereo.photos import StereoPhoto, lifted, projected
from r3gw.stereo.points import dense_points
from r3gw.stereo.sweep import DepthMap, swept_depth

SIZE = (96, 64)
NORMAL, OFFSET = torch.tensor([0.3, 0.1, -1.0]), -6.0  # the wall: NORMAL . x = OFFSET
SHIFTS = (0.0, 0.9, -0.8)
# Exposure and tone of each photo: stereo must not mind.
TONES = ((1.0, 1.0), (0.5, 0.8), (0.7, 1.3))


def camera_at(shift: float) -> Camera:
    pose = torch.eye(4, dtype=torch.float64)
    pose[0, 3] = -shift
    return Camera(pose, (90.0, 90.0, 48.0, 32.0), *SIZE)


def wall_depth(camera: Camera) -> torch.Tensor:
    """Camera z of the wall at every pixel; the cameras are not turned."""
    rays = pixel_rays(camera)
    return (OFFSET - camera.centre.float() @ NORMAL) / (rays @ NORMAL)


def wall_picture(camera: Camera, tone: tuple[float, float]) -> torch.Tensor:
    """Smooth noise on the wall, 0 to 1."""
    generator = torch.Generator().manual_seed(1)
    noise = torch.rand(1, 1, 120, 120, generator=generator)
    places = pixel_rays(camera) * wall_depth(camera)[..., None] + camera.centre.float()
    sampled = torch.nn.functional.grid_sample(
        noise, places[None, ..., :2] / 8.0, mode="bicubic", align_corners=False
    )[0, 0]
    exposure, power = tone
    return (exposure * sampled.clamp(0.02, 1.0) ** power).clamp(0.0, 1.0)


def sparse_points() -> torch.Tensor:
    """A grid of 8 x 6 points on the wall, of the middle camera's pixels."""
    camera = camera_at(0.0)
    chosen = torch.zeros(SIZE[1], SIZE[0], dtype=torch.bool)
    chosen[4::10, 4::12] = True
    return lifted(wall_depth(camera), chosen, camera)


def wall_photos() -> list[StereoPhoto]:
    points = sparse_points()
    photos = []
    for shift, tone in zip(SHIFTS, TONES, strict=True):
        camera = camera_at(shift)
        everywhere = torch.ones(SIZE[1], SIZE[0], dtype=torch.bool)
        known = projected(points, camera)
        photos.append(StereoPhoto(camera, wall_picture(camera, tone), everywhere, known))
    return photos


def test_depth_of_a_wall_in_photos_of_other_tone():
    photos = wall_photos()
    found = swept_depth(photos[0], photos[1:])
    assert float(found.is_found.float().mean()) > 0.6
    error = (found.depth / wall_depth(photos[0].camera) - 1).abs()[found.is_found]
    assert float(error.median()) < 0.005
    assert float((error < 0.02).float().mean()) > 0.97


def test_what_no_other_photo_shows_has_no_depth():
    photos = wall_photos()
    noise = torch.rand(24, 24, generator=torch.Generator().manual_seed(5))
    photos[0].grey[20:44, 30:54] = noise
    found = swept_depth(photos[0], photos[1:])
    assert float(found.is_found[24:40, 34:50].float().mean()) < 0.02


def test_sky_and_occluders_have_no_depth():
    photos = wall_photos()
    photos[0].is_matched[:30] = False
    found = swept_depth(photos[0], photos[1:])
    assert not found.is_found[:30].any()
    assert found.is_found[30:].any()


def test_a_depth_that_no_other_map_holds_is_dropped():
    photos = wall_photos()
    maps = [swept_depth(photo, [p for p in photos if p is not photo]) for photo in photos]
    wrong = maps[0].depth.clone()
    wrong[:32] *= 1.1
    upper = torch.zeros_like(maps[0].is_found)
    upper[:32] = True
    kept = confirmed(0, photos, [DepthMap(wrong, maps[0].is_found), *maps[1:]])
    assert not (kept & upper).any()
    assert float(kept[32:].float().mean()) > 0.5
    assert not (kept & ~maps[0].is_found).any()


def test_neighbours_share_points_and_stand_apart():
    photos = wall_photos()
    points = sparse_points()
    same_place = StereoPhoto(
        photos[0].camera, photos[0].grey, photos[0].is_matched, photos[0].known
    )
    elsewhere = camera_at(100.0)
    blind = StereoPhoto(
        elsewhere, photos[0].grey, photos[0].is_matched, projected(points, elsewhere)
    )
    assert sorted(neighbours(0, [*photos, same_place, blind], points)) == [1, 2]


def test_thinned_points_are_means_of_cubes():
    points = torch.tensor([[0.1, 0.1, 0.1], [0.3, 0.1, 0.1], [1.5, -0.5, 0.0]])
    expected = torch.tensor([[0.2, 0.1, 0.1], [1.5, -0.5, 0.0]])
    got = thinned(points, 1.0)
    torch.testing.assert_close(got[got[:, 0].argsort()], expected, rtol=0, atol=1e-6)
    assert thinned(points[:0], 1.0).shape == (0, 3)


def test_completion_keeps_what_is_known_and_stays_between():
    values = torch.zeros(37, 53)
    weights = torch.zeros(37, 53)
    values[:, 3], values[:, 50] = 1.0, 2.0
    weights[:, 3], weights[:, 50] = 1.0, 1.0
    got = completed(values, weights)
    assert torch.equal(got[weights > 0], values[weights > 0])
    assert float(got.min()) >= 1.0 - 1e-6
    assert float(got.max()) <= 2.0 + 1e-6
    assert float(got[:, 10].mean()) < 1.4 < 1.6 < float(got[:, 44].mean())


def wall_scene(tmp_path, sky_rows: int) -> Scene:
    """The wall's photos and masks as files, the topmost rows said to be sky."""
    views = []
    for number, (shift, tone) in enumerate(zip(SHIFTS, TONES, strict=True)):
        camera, name = camera_at(shift), f"photo{number}"
        grey = (wall_picture(camera, tone) * 255).round().numpy().astype(np.uint8)
        write_image(tmp_path / f"images/{name}.png", np.repeat(grey[..., None], 3, axis=2))
        is_sky = np.zeros(grey.shape, dtype=np.bool_)
        is_sky[:sky_rows] = True
        write_image(tmp_path / f"masks/is_sky/{name}.png", is_sky)
        write_image(tmp_path / f"masks/is_valid/{name}.png", np.ones_like(is_sky))
        views.append(
            View(
                name=name,
                image=f"images/{name}.png",
                width=SIZE[0],
                height=SIZE[1],
                intrinsics=camera.intrinsics,
                cam_from_world=camera.cam_from_world.tolist(),
                split="train",
                session=None,
            )
        )
    gauge = Gauge.of(Similarity.identity())
    scene = Scene(name="wall", source_format="photos", views=tuple(views), scene_from_source=gauge)
    points = sparse_points().float()
    save_points(Points(points.numpy(), np.zeros((len(points), 3), np.uint8)), tmp_path)
    save_scene(scene, tmp_path)
    return scene


@pytest.mark.parametrize("sky_rows", [0, 30])
def test_points_of_a_scene_lie_on_its_wall(tmp_path, sky_rows):
    scene, points = wall_scene(tmp_path, sky_rows), sparse_points().float()
    found = dense_points(scene, tmp_path, tmp_path / "masks", points)
    assert len(found) > 5 * len(points)
    off = (found @ NORMAL - OFFSET).abs() / NORMAL.norm()
    assert float(off.median()) < 0.03  # of a wall 5 to 7 units away
    # Guesses continue a depth beyond what two photos show, but not the wall's slant.
    assert float((off < 0.5).float().mean()) > 0.95
    seen = projected(found.double(), scene.views[0].camera)
    assert float((seen.y < sky_rows - 1).float().mean()) < 0.02


def test_hundreds_of_photos_start_from_no_more_than_training_bears(tmp_path, monkeypatch):
    monkeypatch.setattr("r3gw.stereo.points.MOST_FOUND", 100)
    monkeypatch.setattr("r3gw.stereo.points.MOST_GUESSED", 20)
    found = dense_points(
        wall_scene(tmp_path, 1), tmp_path, tmp_path / "masks", sparse_points().float()
    )
    assert len(found) == 120


def test_photos_without_any_marked_sky_get_no_guesses(tmp_path, monkeypatch):
    """A guess continues depths upwards, where sky may be that nobody marked."""
    monkeypatch.setattr("r3gw.stereo.points.MOST_FOUND", 0)
    points = sparse_points().float()
    found = {
        rows: dense_points(wall_scene(tmp_path, rows), tmp_path, tmp_path / "masks", points)
        for rows in (0, 1)
    }
    assert len(found[0]) == 0
    assert len(found[1]) > 100


def test_photos_that_share_nothing_give_no_points(tmp_path, caplog):
    scene = wall_scene(tmp_path, 0)
    found = dense_points(scene, tmp_path, tmp_path / "masks", sparse_points()[:5].float())
    assert found.shape == (0, 3)
    assert "sparse points alone" in caplog.text


def test_the_initialise_stage_adds_them_where_masks_are_named(tmp_path):
    wall_scene(tmp_path, 0)
    sky = train_settings().sky
    run_initialise(tmp_path, sky, tmp_path / "sparse.npz")
    run_initialise(tmp_path, sky, tmp_path / "dense.npz", tmp_path / "masks")
    run_initialise(tmp_path, sky, tmp_path / "again.npz", tmp_path / "masks")
    sparse, dense = (load_initial(tmp_path / f"{name}.npz") for name in ("sparse", "dense"))
    count = len(sparse.foreground)
    assert count == len(sparse_points()) < len(dense.foreground) / 5
    torch.testing.assert_close(dense.foreground[:count], sparse.foreground, rtol=0, atol=0)
    assert (tmp_path / "dense.npz").read_bytes() == (tmp_path / "again.npz").read_bytes()
