"""Occluders found while training: somebody painted into one photo, and nobody elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from support.settings import train_settings

from r3gw.geometry.cameras import Camera
from r3gw.model.attributes import OPACITY
from r3gw.model.initial import InitialPoints
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.rendering.compose import render
from r3gw.training.disagreement import disagreement
from r3gw.training.occluders import find_occluders, mask_of_excess
from r3gw.training.photos import Photo
from r3gw.training.resolution import PhotoSizes
from r3gw.training.schedule import Schedule
from r3gw.training.start import initial_model

WIDTH, HEIGHT = 128, 96
NAMES = ("a", "b", "c")
SETTINGS = train_settings(occluders={"enabled": True}).occluders


@pytest.fixture(scope="module")
def model():
    """A wall of blotches, five away from cameras that stand side by side."""
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(3000, 3, generator=generator) * torch.tensor([8.0, 6.0, 0.05])
    points += torch.tensor([-4.0, -3.0, 5.0])
    dome = SkyDome(torch.zeros(3), 20.0, (-1.0, 1.0))
    angles = sample_dome(dome, 200, generator)
    made = initial_model(InitialPoints(points, dome, angles), NAMES, train_settings())
    with torch.no_grad():
        made.foreground[OPACITY.name].fill_(3.0)
        made.foreground["albedo_logits"].copy_(3 * torch.randn(3000, 3, generator=generator))
    return made


@pytest.fixture(scope="module")
def photos(model) -> list[Photo]:
    """What cameras would see of the model, but for noise."""
    generator = torch.Generator().manual_seed(1)
    made = []
    for index, name in enumerate(NAMES):
        cam_from_world = torch.eye(4, dtype=torch.float64)
        cam_from_world[0, 3] = 0.3 * (index - 1)
        camera = Camera(cam_from_world, (130.0, 130.0, 64.0, 48.0), WIDTH, HEIGHT)
        with torch.no_grad():
            lit = model.appearance(index)
            colour = render(model, camera, lit.light, lit.sky_light).colour
        noisy = colour + 0.02 * torch.randn(colour.shape, generator=generator)
        planes = (noisy.clamp(0, 1) * 255).round().to(torch.uint8).permute(2, 0, 1).contiguous()
        nowhere = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
        made.append(Photo(name, camera, planes, ~nowhere, nowhere))
    return made


def with_somebody(photo: Photo, place: tuple[slice, slice]) -> Photo:
    """The photo with a striped coat in it."""
    planes = photo.planes.clone()
    stripes = (torch.arange(HEIGHT) // 3 % 2 * 220).to(torch.uint8)[None, :, None]
    planes[:, *place] = stripes.expand(3, HEIGHT, WIDTH)[:, *place]
    return replace(photo, planes=planes)


PLACE = slice(30, 70), slice(40, 62)


def test_somebody_in_one_photo_is_found_there_and_nowhere_else(model, photos):
    crowded = [with_somebody(photos[0], PLACE), *photos[1:]]
    found = find_occluders(model, crowded, SETTINGS)
    truth = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    truth[PLACE] = True
    recall = float((found[0] & truth).sum() / truth.sum())
    precision = float((found[0] & truth).sum() / found[0].sum())
    assert recall > 0.9
    assert precision > 0.6
    assert [float(mask.float().mean()) for mask in found[1:]] == [0.0, 0.0]


def test_a_body_is_found_whole_from_the_part_that_stands_out():
    """Faint where it hangs together with that part, not elsewhere; grown by 1 px (128 x 0.008)."""
    excess = np.full((HEIGHT, WIDTH), 0.02, np.float32)
    excess[20:30, 40:50] = 0.5
    excess[30:60, 38:52] = 0.15
    excess[70:80, 90:100] = 0.15
    found = mask_of_excess(excess, SETTINGS, HEIGHT, WIDTH)
    assert found[22:28, 42:48].all()
    assert found[32:58, 40:50].all()
    assert not found[:, 60:].any()
    assert not found[:18].any()


def test_what_all_photos_show_and_the_model_does_not_is_the_place(model, photos):
    """The same stripes at the same place of the wall: detail that the model lacks."""
    shifted = [
        with_somebody(photo, (PLACE[0], slice(40 + step, 62 + step)))
        for photo, step in zip(photos, (-8, 0, 8), strict=True)  # 0.3 aside, 5 away, 130 px focal
    ]
    found = find_occluders(model, shifted, SETTINGS)
    assert max(float(mask.float().mean()) for mask in found) < 0.02


@pytest.mark.parametrize("count", [1, 2])
def test_what_too_few_photos_see_is_never_an_occluder(model, photos, count):
    """Of two that differ, nobody knows which shows the place."""
    found = find_occluders(model, [with_somebody(photos[0], PLACE), *photos[1:count]], SETTINGS)
    assert not found[0].any()


def test_masks_of_the_user_s_are_not_looked_at(model, photos):
    """Neither does it matter what stands there, nor is it found a second time."""
    is_valid = photos[0].is_valid.clone()
    is_valid[PLACE] = False
    masked = replace(photos[0], is_valid=is_valid)
    plain = find_occluders(model, [masked, *photos[1:]], SETTINGS)
    other = find_occluders(model, [with_somebody(masked, PLACE), *photos[1:]], SETTINGS)
    assert not plain[0].any()
    assert all(torch.equal(a, b) for a, b in zip(plain, other, strict=True))


def test_sky_is_never_an_occluder(model, photos):
    """Where the model has something before a photo's sky, the photo is to say so."""
    is_sky = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    is_sky[:50] = True
    sky = replace(with_somebody(photos[0], PLACE), is_sky=is_sky)
    found = find_occluders(model, [sky, *photos[1:]], SETTINGS)[0]
    assert not found[:50].any()
    assert found[52:68, 42:60].float().mean() > 0.9


def test_no_photo_loses_more_than_the_largest_share(model, photos):
    bounded = SETTINGS.model_copy(update={"most": 0.02})
    found = find_occluders(model, [with_somebody(photos[0], PLACE), *photos[1:]], bounded)
    share = float(found[0].float().mean())
    assert 0.0 < share < 0.05  # a little more: outlines are added


def test_the_model_stays_as_it_is(model, photos):
    model.appearance.train()
    before = {name: value.clone() for name, value in model.appearance.state_dict().items()}
    find_occluders(model, photos, SETTINGS)
    assert model.appearance.training
    after = model.appearance.state_dict()
    assert all(torch.equal(value, after[name]) for name, value in before.items())
    assert all(value.grad is None for value in model.foreground.values.values())


def test_disagreement_is_blind_to_exposure_and_sees_other_structure():
    generator = np.random.default_rng(0)
    ours = torch.from_numpy(generator.random((96, 128, 3))).float()
    other = torch.from_numpy(generator.random((96, 128, 3))).float()
    everywhere = torch.ones(96, 128, dtype=torch.bool)
    assert float(disagreement(ours, ours, everywhere).abs().max()) < 1e-5
    assert float(disagreement(ours, 0.8 * ours + 0.1, everywhere).max()) < 0.1
    assert float(disagreement(ours, other, everywhere).mean()) == pytest.approx(1.0, abs=0.1)
    assert float(disagreement(ours, other, ~everywhere).abs().max()) == 0.0


def test_left_out_pixels_come_back_when_they_are_found_no_more(photos):
    sizes = PhotoSizes(photos, Schedule.of(train_settings()))
    is_occluder = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    is_occluder[PLACE] = True
    sizes.leave_out([is_occluder] * 3)
    assert torch.equal(sizes.photo(1, 1).is_valid, ~is_occluder)
    sizes.leave_out([torch.zeros_like(is_occluder)] * 3)
    assert sizes.photo(1, 1).is_valid.all()


def test_they_are_found_from_the_first_time_on_at_intervals():
    settings = train_settings(iterations=400, occluders={"first": 8000, "interval": 10000})
    schedule = Schedule.of(settings)
    assert [i for i in range(1, 401) if schedule.finds_occluders(i)] == [80, 180, 280, 380]


def test_nobody_is_looked_for_in_the_paper_s_settings():
    assert not train_settings().occluders.enabled
