"""Collections of tourists as they come: no sky marked, a photo at night, no sessions.

The settings are those of config/photos.yaml, shortened; every case must end with a finite model.
"""

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from support.flat_world import flat_photos, flat_points

from r3gw.files.strict import read_yaml
from r3gw.imaging.colour import display_from_linear, linear_from_display
from r3gw.model.lights import photo_light
from r3gw.model.model import SceneModel
from r3gw.pipeline.config import load_config, run_settings
from r3gw.training.first_values import with_first_values
from r3gw.training.loop import train
from r3gw.training.photos import Photo
from r3gw.training.settings import TrainSettings
from r3gw.training.start import model_of_photos
from r3gw.training.visible_sky import visible_sky

CONFIG = Path(__file__).parents[2] / "config"
DARK = 25.0


@pytest.fixture(scope="module")
def settings() -> TrainSettings:
    """Of config/photos.yaml, in 40 iterations without new Gaussians."""
    values = read_yaml(CONFIG / "photos.yaml")
    values["train"]["iterations"] = 40
    values["train"]["density"]["last"] = 0
    files = {f"{kind}_file": CONFIG / f"{kind}.yaml" for kind in ("train", "variants")}
    config = load_config(values)
    return run_settings(config, config.variants[0], 0, **files)


def collection() -> list[Photo]:
    """Three photos; they show enough sky to count."""
    first, second = flat_photos()
    photos = [first, second, replace(first, name="c")]
    return [
        replace(photo, seen_sky=visible_sky(photo.camera, photo.planes, photo.is_sky))
        for photo in photos
    ]


def without_sky(photo: Photo) -> Photo:
    """As it comes when nobody found its sky."""
    return replace(photo, is_sky=torch.zeros_like(photo.is_sky), seen_sky=None)


def at_night(photo: Photo) -> Photo:
    """25 times darker."""
    linear = linear_from_display(photo.planes.float() / 255.0) / DARK
    planes = (display_from_linear(linear) * 255).round().byte()
    return replace(photo, planes=planes, seen_sky=visible_sky(photo.camera, planes, photo.is_sky))


CASES = {
    "as they should be": collection,
    "no sky marked": lambda: [without_sky(photo) for photo in collection()],
    "one without sky": lambda: [without_sky(collection()[0]), *collection()[1:]],
    "one at night": lambda: [*collection()[:2], at_night(collection()[2])],
    "one black": lambda: [
        *collection()[:2],
        replace(collection()[2], planes=torch.zeros(3, 24, 32, dtype=torch.uint8), seen_sky=None),
    ],
}


def trained(photos: list[Photo], settings: TrainSettings) -> SceneModel:
    """Without sessions: every photo has a light of its own."""
    settings = with_first_values(settings, photos)
    model = model_of_photos(flat_points(), photos, settings)
    return train(model, photos, settings).model


@pytest.mark.parametrize("case", CASES)
def test_every_collection_ends_with_a_finite_model(case, settings):
    model = trained(CASES[case](), settings)
    rows = {**model.foreground.values, **model.sky.rows.values, **model.appearance.state_dict()}
    for name, value in rows.items():
        assert torch.isfinite(value).all(), name
    for photo in model.photos:
        assert torch.isfinite(photo_light(model, photo).sh).all()


def test_a_photo_at_night_has_a_dark_camera_and_the_light_of_the_others(settings):
    gains = settings.gains.model_copy(update={"enabled": True})
    settings = settings.model_copy(update={"gains": gains})
    model = trained(CASES["one at night"](), settings)
    dark = model.appearance.gains().detach()[2]
    assert float(dark.log().mean().exp()) == pytest.approx(1 / DARK, rel=0.3)
    strengths = [photo_light(model, photo).strength for photo in model.photos]
    assert strengths[2] == pytest.approx(strengths[0], rel=0.3)
