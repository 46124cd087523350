"""All light models behind one interface: described, written, started and trained alike."""

import pytest
import torch
from support.settings import train_settings

from r3gw.geometry.cameras import Camera
from r3gw.model.initial import InitialPoints
from r3gw.model.light_models.daylight import Daylight
from r3gw.model.light_models.fixed import FixedLight
from r3gw.model.light_models.free import FreeLight
from r3gw.model.light_models.outdoor import OutdoorLight
from r3gw.model.model_file import load_model, save_model
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.training.lights.kinds import TRAININGS, first_light
from r3gw.training.loop import train
from r3gw.training.photos import Photo
from r3gw.training.start import initial_model
from r3gw.training.visible_sky import visible_sky

NAMES, SESSIONS = ("one", "two", "three"), ("a", "b", "a")
TRUE = 0.3 * torch.randn(3, 25, 3, generator=torch.Generator().manual_seed(4))
TRUE[:, 0] += 2.0


def settings(kind: str):
    return train_settings(
        iterations=8,
        warm_up=0,
        geometry_losses_from=0,
        density={"first": 0, "interval": 1_000_000, "reset_interval": None},
        model={"share_session_light": kind != "free", "embedding_size": 6, "hidden_size": 8},
        outdoor={"enabled": kind == "outdoor"},
        daylight={"enabled": kind == "daylight"},
        occlusion={"enabled": kind == "daylight"},
    )


def photo(name: str, shift: float) -> Photo:
    pose = torch.eye(4, dtype=torch.float64)
    pose[0, 3] = shift
    camera = Camera(pose, (30.0, 30.0, 16.0, 12.0), 32, 24)
    is_sky = torch.zeros(24, 32, dtype=torch.bool)
    is_sky[:10] = True
    planes = torch.full((3, 24, 32), 120, dtype=torch.uint8)
    planes[2, :10] = 200
    everywhere = torch.ones_like(is_sky)
    return Photo(name, camera, planes, everywhere, is_sky, visible_sky(camera, planes, is_sky))


PHOTOS = [photo(name, 0.2 * i) for i, name in enumerate(NAMES)]


def model_of(kind: str):
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(80, 3, generator=generator) * torch.tensor([6.0, 2.4, 0.2])
    dome = SkyDome(torch.tensor([0.0, 0.5, 0.0]), 8.0, (-1.0, 1.0))
    initial = InitialPoints(
        points + torch.tensor([-3.0, -0.5, 4.0]), dome, sample_dome(dome, 40, generator)
    )
    given = FixedLight(TRUE) if kind == "fixed" else None
    seen = [each.seen_sky for each in PHOTOS]
    return initial_model(initial, NAMES, settings(kind), SESSIONS, seen, given)


KINDS = {"free": FreeLight, "outdoor": OutdoorLight, "daylight": Daylight, "fixed": FixedLight}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_chosen_described_and_written(kind, tmp_path):
    model = model_of(kind)
    assert type(model.appearance.light_model) is KINDS[kind]
    assert model.description.light == model.appearance.light_model.describe()
    assert (model.description.light.kind, model.description.light_degree) == (kind, 4)
    save_model(model, tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    assert again.description == model.description
    for i in range(3):
        found, expected = again.appearance(i), model.appearance.eval()(i)
        torch.testing.assert_close(found.light, expected.light, rtol=0, atol=0)
        torch.testing.assert_close(found.sky_light, expected.sky_light, rtol=0, atol=0)


def test_settings_ask_for_a_light_and_every_light_has_a_training():
    assert set(TRAININGS) == set(KINDS.values())
    rows = [(), ()]
    assert type(first_light(settings("free"), rows)) is FreeLight
    assert type(first_light(settings("outdoor"), rows)) is OutdoorLight
    assert type(first_light(settings("daylight"), rows)) is Daylight


@pytest.mark.parametrize(
    ("kind", "has_loss"),
    [("free", True), ("outdoor", True), ("daylight", True), ("fixed", False)],
)
def test_training_moves_what_the_kind_learns(kind, has_loss):
    model = model_of(kind)
    before = {name: value.clone() for name, value in model.appearance.state_dict().items()}
    state = train(model, PHOTOS, settings(kind))
    after = state.model.appearance.state_dict()
    moved = {name.split(".")[0] for name in after if not torch.equal(after[name], before[name])}
    own = {
        name
        for name in after
        if "light_model" in name and not torch.equal(after[name], before[name])
    }
    assert "sky_head" in moved
    assert ("light_head" in moved) == (kind != "fixed")
    assert ("log_exposure" in moved) == (kind in ("outdoor", "daylight"))
    suns = {"sun_directions", "log_sun_powers"}
    expected = {"outdoor": suns, "daylight": suns | {"sky_colours", "sky_suns"}}.get(kind, set())
    assert own == {f"light_model.{name}" for name in expected}
    assert any("loss_light" in row for row in state.history.rows) == has_loss


def test_known_lights_are_what_the_photos_get():
    model = model_of("fixed")
    for i in range(3):
        torch.testing.assert_close(model.appearance(i).light, TRUE[i], rtol=0, atol=0)
