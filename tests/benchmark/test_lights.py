"""Lights: where the sun stands in every map, energy, and what Mitsuba makes of a map."""

from math import pi, radians, sin

import mitsuba as mi
import numpy as np
import pytest
import torch

from r3gw.benchmark import lights, render
from r3gw.benchmark.generate import PLACES
from r3gw.benchmark.lights import Session
from r3gw.benchmark.materials import Material
from r3gw.benchmark.meshes import polygon
from r3gw.benchmark.seeds import stream
from r3gw.geometry.cameras import Camera
from r3gw.lighting import daylight
from r3gw.lighting.envmap import pixel_directions, published_directions

HEIGHT = 64
CLEAR = Session("01-01_00_00", 130.0, 35.0, 3.0, 0.0, 0.0)
GREY = Session("01-01_00_01", 130.0, 35.0, 3.0, 1.0, 0.0)


def light_of(session: Session) -> np.ndarray:
    return lights.environment(session, stream(0, "test"), HEIGHT)


def angle_deg(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


def test_mitsuba_sees_every_pixel_of_a_map_in_our_direction() -> None:
    light = stream(0, "random map").uniform(0, 1, (8, 16, 3))
    emitter = render.emitter(light)
    interaction = mi.SurfaceInteraction3f()
    directions = pixel_directions(8, 16).numpy()
    for row in range(8):
        for column in range(16):
            interaction.wi = mi.Vector3f(-directions[row, column])
            seen = np.asarray(emitter.eval(interaction))
            np.testing.assert_allclose(seen, light[row, column], rtol=1e-3, atol=1e-4)


def test_one_bright_patch_lights_a_plane_from_its_direction() -> None:
    """Radiance of a Lambertian plane is albedo / pi * L * solid angle * cosine."""
    light = np.full((HEIGHT, 2 * HEIGHT, 3), 1e-6)
    light[12, 20] = 1000.0
    towards = pixel_directions(HEIGHT, 2 * HEIGHT)[12, 20].numpy()
    energy = 1000.0 * daylight.solid_angles(HEIGHT)[12, 20, 0]
    square = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    materials = {"matte": Material((0.5, 0.5, 0.5))}
    place = render.scene(
        render.emitter(light), render.shapes([("matte", polygon(square))], materials)
    )
    # Two units above the plane, looking down: x right, y towards -z, z down the world's +y.
    pose = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 2], [0, 0, 0, 1]])
    camera = Camera(torch.from_numpy(pose), (40.0, 40.0, 8.0, 8.0), 16, 16)
    image = render.photo(place, camera, 64, 0)
    expected = 0.5 / pi * energy * -towards[1]
    assert image.mean() == pytest.approx(expected, rel=0.02, abs=0)


def test_the_sun_is_where_the_session_says() -> None:
    light = light_of(CLEAR)
    row, column = np.unravel_index(light.sum(-1).argmax(), light.shape[:2])
    found = pixel_directions(HEIGHT, 2 * HEIGHT)[row, column].numpy()
    assert angle_deg(found, CLEAR.sun_direction) < 180 / HEIGHT
    assert CLEAR.sun_direction[0] > 0  # Azimuth 130: from the right,
    assert CLEAR.sun_direction[2] < 0  # from the street,
    assert CLEAR.sun_direction[1] < 0  # and from above.


def test_the_sun_dominates_a_clear_day_and_is_gone_on_a_grey_one() -> None:
    """Near 35 degrees of height the direct share of clear daylight is between 0.6 and 0.9."""
    for session, low, high in ((CLEAR, 0.6, 0.9), (GREY, 0.0, 0.1)):
        light = light_of(session)
        directions = pixel_directions(HEIGHT, 2 * HEIGHT).numpy()
        weight = daylight.solid_angles(HEIGHT) * np.maximum(-directions[..., 1:2], 0)
        near_sun = (directions @ session.sun_direction > np.cos(radians(6)))[..., None]
        lit = (light * weight).sum((0, 1)).mean()
        assert low < (light * weight * near_sun).sum((0, 1)).mean() / lit < high


def test_splatting_keeps_direction_and_irradiance() -> None:
    light = daylight.splat(np.array([2.0, 3.0, 4.0]), CLEAR.sun, HEIGHT)
    power = light * daylight.solid_angles(HEIGHT)
    np.testing.assert_allclose(power.sum((0, 1)), [2, 3, 4], rtol=1e-12, atol=0)
    directions = pixel_directions(HEIGHT, 2 * HEIGHT).numpy()
    mean = (power[..., :1] * directions).sum((0, 1))
    assert angle_deg(mean / np.linalg.norm(mean), CLEAR.sun_direction) < 0.1


def test_the_ground_half_is_lambertian_ground_under_the_upper_half() -> None:
    light = light_of(CLEAR)
    directions = pixel_directions(HEIGHT, 2 * HEIGHT).numpy()
    up = np.maximum(-directions[..., 1:2], 0)
    irradiance = (light * daylight.solid_angles(HEIGHT) * up)[: HEIGHT // 2].sum((0, 1))
    ground = daylight.GROUND_ALBEDO / pi * irradiance
    np.testing.assert_allclose(light[-1, 5], ground, rtol=1e-9, atol=0)


def test_an_overcast_zenith_is_three_times_the_horizon() -> None:
    sky = lights._overcast(
        np.array([[[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]]), np.array([1.0, 1.0, 1.0]), 1.0
    )
    assert sky[0, 0, 0] / sky[0, 1, 0] == pytest.approx(3.0, rel=1e-12)


def test_the_panorama_is_the_map_turned_by_the_yaw() -> None:
    light = light_of(GREY)
    yaw = lights.whole_pixel_yaw(1.3, HEIGHT)
    straight, turned = lights.phone_panorama(light, 0.0), lights.phone_panorama(light, yaw)
    shift = round(yaw / (2 * pi) * 2 * HEIGHT)
    assert shift != 0
    # The picture's azimuth psi shows the world's azimuth psi + yaw.
    np.testing.assert_array_equal(turned[:, 10], straight[:, (10 + shift) % (2 * HEIGHT)])


@pytest.mark.parametrize(("session", "low", "high"), [(CLEAR, 5.0, 100.0), (GREY, 1.0, 1.5)])
def test_scaled_clipped_pixels_give_the_panorama_its_light_back(
    session: Session, low: float, high: float
) -> None:
    """Linear light of the whole sphere, relative to the ground's, which is never clipped."""
    light = light_of(session)
    scale = lights.clipped_scale(light)
    assert low <= scale < high
    picture = lights.phone_panorama(light, 0.0).astype(float)
    restored = np.where(picture > lights.CLIPPED, picture**2.2 * scale, picture**2.2)
    exposure = float((restored[-1, 5] / light[-1, 5]).mean())
    weight = daylight.solid_angles(HEIGHT)
    expected = exposure * float((light * weight).sum())
    assert float((restored * weight).sum()) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("yaw", [-2.0, 0.4, 3.0])
def test_the_published_mapping_at_our_angle_meets_the_true_sun(yaw: float) -> None:
    light = 0.3 + daylight.splat(np.full(3, 50.0), CLEAR.sun, HEIGHT)
    panorama = lights.phone_panorama(light, yaw)
    bright = panorama.min(axis=-1) > 0.999
    angle = lights.published_sun_angle(CLEAR, lights.whole_pixel_yaw(yaw, HEIGHT))
    directions = published_directions(HEIGHT, 2 * HEIGHT, -pi / 2, angle).numpy()
    middle = directions[bright].mean(axis=0)
    middle /= np.linalg.norm(middle)
    level = np.array([1.0, 0.0, 1.0])
    flat, sun = middle * level, CLEAR.sun_direction * level
    assert angle_deg(flat / np.linalg.norm(flat), sun / np.linalg.norm(sun)) < 180 / HEIGHT
    assert middle[1] == pytest.approx(-sin(radians(35)), abs=0.1)


@pytest.mark.parametrize("name", PLACES)
def test_sessions_are_varied_and_test_light_is_never_trained_on(name: str) -> None:
    sessions = PLACES[name].sessions
    assert len({s.name for s in sessions}) == len(sessions)
    trained = [s for s in sessions if not s.is_test]
    assert len(trained) >= 6
    for test in (s for s in sessions if s.is_test):
        for s in trained:
            is_apart = angle_deg(test.sun_direction, s.sun_direction) > 5
            assert is_apart or abs(test.overcast - s.overcast) > 0.2
