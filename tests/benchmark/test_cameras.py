"""Where the embedded scenes' photos are taken from."""

import numpy as np
import pytest
import torch

from r3gw.benchmark import cameras
from r3gw.benchmark.generate import PLACES
from r3gw.benchmark.seeds import stream


@pytest.mark.parametrize("place", sorted(PLACES))
def test_poses_are_rigid_and_have_no_bits_that_differ_from_run_to_run(place):
    walk = PLACES[place].walk
    posed = cameras.train_cameras(walk, 12, (320, 240), stream(0, "cameras"))
    posed += cameras.test_cameras(walk, 4, posed, stream(0, "test cameras"))
    assert len(posed) == 16
    for camera in posed:
        pose = camera.cam_from_world.numpy()
        np.testing.assert_array_equal(pose, pose.round(12))
        np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), rtol=0, atol=1e-11)
        assert torch.linalg.det(camera.cam_from_world[:3, :3]) == pytest.approx(1, abs=1e-11)
