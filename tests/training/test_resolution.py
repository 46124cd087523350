"""Smaller photos: their pixels, masks and cameras, and when a run trains on which size."""

import numpy as np
import pytest
import torch
from PIL import Image
from support.flat_world import flat_photos, flat_points
from support.settings import train_settings

from r3gw.geometry.cameras import Camera
from r3gw.model.model_file import save_model
from r3gw.training.checkpoint import Checkpoints
from r3gw.training.loop import train
from r3gw.training.photos import Photo
from r3gw.training.resolution import PhotoSizes, smaller
from r3gw.training.schedule import Schedule
from r3gw.training.start import initial_model

GROWING = {"smallest": 0.25, "whole_from": 20000}
WIDTH, HEIGHT = 90, 66


@pytest.fixture
def photo() -> Photo:
    """Noise, of which a corner is occluded and the upper part sky."""
    generator = torch.Generator().manual_seed(0)
    planes = torch.randint(0, 256, (3, HEIGHT, WIDTH), generator=generator, dtype=torch.uint8)
    is_valid = torch.ones(HEIGHT, WIDTH, dtype=torch.bool)
    is_valid[40:, :31] = False
    is_sky = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    is_sky[:20] = True
    camera = Camera.looking_at(
        (0.0, 0.0, 5.0), position=(1.0, 0.0, 0.0), width=WIDTH, height=HEIGHT
    )
    return Photo("noise", camera, planes, is_valid, is_sky)


def test_pixels_average_what_they_cover_as_pillow_has_it(photo):
    half = smaller(photo, 0.5)
    image = Image.fromarray(np.asarray(photo.planes.permute(1, 2, 0)))
    expected = np.asarray(image.resize((45, 33), Image.Resampling.BOX)).astype(int)
    found = np.asarray(half.planes.permute(1, 2, 0)).astype(int)
    unoccluded = np.ones((33, 45), bool)
    unoccluded[20:, :16] = False
    assert np.abs(found - expected)[unoccluded].max() <= 1  # Each rounds in its own way.
    assert np.abs(found - expected)[~unoccluded].max() > 1


def test_occluders_lend_no_colour(photo):
    """The column of blocks at the occluder's edge shows its visible half alone."""
    other = photo.planes.clone()
    other[:, 40:, :31] = 255
    changed = smaller(Photo(photo.name, photo.camera, other, photo.is_valid, photo.is_sky), 0.5)
    kept = smaller(photo, 0.5)
    edge = photo.planes[:, 40:42, 31].float().mean(dim=1).round()
    torch.testing.assert_close(kept.planes[:, 20, 15].float(), edge, rtol=0, atol=1)
    assert torch.equal(changed.planes[:, kept.is_valid], kept.planes[:, kept.is_valid])


def test_masks_go_with_the_majority(photo):
    third = smaller(photo, 1 / 3)
    assert (third.camera.width, third.camera.height) == (32, 32)  # A third is 30 and 22.
    half = smaller(photo, 0.5)
    assert torch.equal(half.is_valid[20:].sum(dim=1), torch.full((13,), 45 - 15))
    assert half.is_valid[:20].all()
    assert torch.equal(half.is_sky.sum(dim=1) == 45, torch.arange(33) < 10)


def test_a_point_falls_on_the_same_share_of_the_picture(photo):
    half = smaller(photo, 0.5).camera
    point = torch.tensor([0.3, 0.2, 4.0, 1.0], dtype=torch.float64)

    def seen(camera):
        x, y, z, _ = (camera.cam_from_world @ point).tolist()
        fx, fy, cx, cy = camera.intrinsics
        return (fx * x / z + cx) / camera.width, (fy * y / z + cy) / camera.height

    assert seen(half) == pytest.approx(seen(photo.camera), rel=1e-12)


def test_photos_are_whole_from_the_start_unless_asked(photo):
    sizes = PhotoSizes([photo], Schedule.of(train_settings(iterations=100)))
    assert all(sizes.photo(0, iteration) is photo for iteration in range(1, 101))


def test_photos_grow_in_steps_until_they_are_whole(photo):
    schedule = Schedule.of(train_settings(iterations=160, resolution=GROWING))
    sizes = PhotoSizes([photo], schedule)
    widths = [sizes.photo(0, iteration).camera.width for iteration in range(1, 161)]
    assert widths == sorted(widths)
    assert widths[:20] == [32] * 20  # a quarter would be 22 pixels
    assert {round(width / WIDTH, 2) for width in widths[30:]} == {0.38, 0.5, 0.62, 0.76, 0.88, 1.0}
    assert widths.index(WIDTH) + 1 == 80  # 20,000 of 40,000
    assert sizes.photo(0, 40) is sizes.photo(0, 49)


def test_gaussians_go_with_the_photos():
    """The square of the side at first, the side itself in the end; all once photos are whole."""
    schedule = Schedule.of(train_settings(iterations=40000, resolution=GROWING))
    assert schedule.gaussians_share(1) == pytest.approx(0.25**2, rel=1e-3)
    assert schedule.gaussians_share(10000) == pytest.approx(0.5**1.5, rel=1e-9)
    assert schedule.gaussians_share(20000) == 1.0
    assert Schedule.of(train_settings()).gaussians_share(1) == 1.0


def test_a_run_that_breaks_off_on_small_photos_ends_with_the_same_bytes(tmp_path):
    class Interrupted(Exception):
        pass

    class BreaksAt15(Checkpoints):
        def save_if_due(self, state):
            super().save_if_due(state)
            if state.iteration == 15:
                raise Interrupted

    settings = train_settings(
        iterations=60,
        resolution=GROWING,
        density={"reset_interval": None, "max_gaussians": 600},
    )

    def run(checkpoints):
        model = initial_model(flat_points(), ("a", "b"), settings)
        return train(model, flat_photos(), settings, checkpoints).model

    save_model(run(None), tmp_path / "whole.safetensors")
    with pytest.raises(Interrupted):
        run(BreaksAt15(tmp_path, {"settings": "a"}, interval_s=0.0))
    save_model(run(Checkpoints(tmp_path, {"settings": "a"})), tmp_path / "resumed.safetensors")
    whole = (tmp_path / "whole.safetensors").read_bytes()
    assert whole == (tmp_path / "resumed.safetensors").read_bytes()
