"""Up, yaw and scale of cameras whose truth is known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from r3gw.files import InputError
from r3gw.importing.gauge import roll_deg, scene_from_source, up_direction, upright_rotation
from r3gw.importing.source import SourcePoints

UP = np.array([0.0, -1.0, 0.0])


def level_cameras(count, spread_deg, pitch_deg, roll_deg, seed=0):
    """cam_from_world of photos around azimuth 0; pitch > 0 looks up, in a world with up = -y."""
    rng = np.random.default_rng(seed)
    angles = np.stack(
        [
            rng.uniform(-spread_deg, spread_deg, count),
            rng.normal(pitch_deg, 3.0, count),
            rng.normal(0, roll_deg, count),
        ],
        axis=1,
    )
    return Rotation.from_euler("YXZ", angles, degrees=True).as_matrix().transpose(0, 2, 1)


def angle_deg(first, second):
    return np.degrees(np.arccos(np.clip(first @ second, -1, 1)))


@pytest.mark.parametrize("pitch_deg", [0.0, 20.0])
def test_up_of_tilted_cameras_in_any_frame(pitch_deg):
    world = level_cameras(30, 60, pitch_deg, 1.0)
    turn = Rotation.from_rotvec([0.7, -1.9, 0.4]).as_matrix()  # source_from_world
    assert angle_deg(up_direction(world @ turn.T), turn @ UP) < 1.0


def test_photos_taken_upright_or_upside_down_do_not_vote():
    world = level_cameras(20, 60, 10.0, 1.0)
    quarter = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    world[:4] = quarter @ world[:4]
    world[4:6] = quarter @ quarter @ world[4:6]
    assert angle_deg(up_direction(world), UP) < 1.5


def test_one_way_photos_have_their_mean_pitch_at_zero_roll():
    world = level_cameras(12, 0.5, 0.0, 0.5)
    assert angle_deg(up_direction(world), UP) < 3.0


def test_roll_is_measured_against_the_horizon():
    camera = Rotation.from_euler("YZ", [35, 7], degrees=True).as_matrix().T[None]
    np.testing.assert_allclose(np.abs(roll_deg(camera, UP)), 7.0, rtol=1e-9, atol=0)


def test_scene_does_not_depend_on_the_source_frame():
    world = level_cameras(15, 40, 12.0, 1.0)
    xyz = np.random.default_rng(1).normal(size=(200, 3)) * [4, 2, 3]
    turn, shift = Rotation.from_rotvec([1.1, 0.3, -2.0]).as_matrix(), np.array([5.0, -3.0, 8.0])
    scenes = []
    for source, rotations in ((xyz, world), (100 * xyz @ turn.T + shift, world @ turn.T)):
        points = SourcePoints(source, np.zeros((200, 3), np.uint8))
        rotation = upright_rotation(rotations)
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), rtol=0, atol=1e-12)
        assert np.linalg.det(rotation) > 0
        similarity = scene_from_source(points, rotation, 10.0)
        moved = similarity.scale * source @ similarity.rotation.numpy().T
        scenes.append(moved + similarity.translation.numpy())
    np.testing.assert_allclose(scenes[0], scenes[1], rtol=0, atol=1e-4)
    distance = np.linalg.norm(scenes[0] - scenes[0].mean(axis=0), axis=1)
    np.testing.assert_allclose(np.percentile(distance, 99), 10.0, rtol=1e-5, atol=0)


def test_mean_view_looks_along_z_and_up_is_minus_y():
    world = level_cameras(15, 40, 12.0, 1.0)
    turned = world @ Rotation.from_rotvec([0.4, 2.0, 0.1]).as_matrix().T
    forward = (turned @ upright_rotation(turned).T)[:, 2].mean(axis=0)
    assert abs(forward[0]) < 1e-12
    assert forward[2] > 0.5
    assert forward[1] == pytest.approx(-np.sin(np.radians(12)), abs=0.05)  # they look up


def test_points_in_one_place_are_refused():
    points = SourcePoints(np.ones((5, 3)), np.zeros((5, 3), np.uint8))
    with pytest.raises(InputError, match="5 points all lie in one place"):
        scene_from_source(points, None, 10.0)
