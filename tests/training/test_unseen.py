"""What no photo sees well: it goes where it is near a camera, and scales are bounded."""

from dataclasses import replace

import pytest
import torch
from support.settings import train_settings

from r3gw.model.initial import InitialPoints
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.training.optimizer import make_optimizer
from r3gw.training.schedule import Schedule
from r3gw.training.settings import UnseenSettings
from r3gw.training.start import initial_model
from r3gw.training.unseen import distances_to_nearest, hold_back_unseen

CENTRES = [torch.tensor([0.0, 0.0, -6.0]).double(), torch.tensor([4.0, 0.0, -6.0]).double()]
# Two metres, half a metre and six metres from the first camera, six from the second.
POINTS = torch.tensor([[0.0, 0, -4], [0, 0, -5.5], [0, 0, 0], [4, 0, 0]])
BOUNDS = UnseenSettings(enabled=True, nearest=0.2, widest=0.25)


@pytest.fixture
def model():
    dome = SkyDome(torch.zeros(3), 8.0, (-1.0, 1.0))
    angles = sample_dome(dome, 5, torch.Generator().manual_seed(0))
    return initial_model(InitialPoints(POINTS, dome, angles), ("a", "b"), train_settings())


def test_distances_are_to_the_nearest_camera():
    found = distances_to_nearest(POINTS, CENTRES)
    torch.testing.assert_close(found, torch.tensor([2.0, 0.5, 6.0, 6.0]), rtol=1e-6, atol=0)


def test_what_is_nearer_than_the_share_of_the_median_goes(model):
    """The median of 0.5, 2, 6 and 6 is 2 (torch takes the lower one), a fifth of it is 0.4."""
    optimizer = make_optimizer(model, train_settings())
    assert hold_back_unseen(model, optimizer, CENTRES, BOUNDS) == 0
    closer = BOUNDS.model_copy(update={"nearest": 0.3})
    assert hold_back_unseen(model, optimizer, CENTRES, closer) == 1
    torch.testing.assert_close(model.foreground["means"].detach(), POINTS[[0, 2, 3]])
    group = next(g for g in optimizer.param_groups if g["name"] == "foreground.means")
    assert group["params"][0] is model.foreground["means"]


def test_scales_end_at_a_share_of_the_distance_and_smaller_ones_stay(model):
    rows = model.foreground
    with torch.no_grad():
        rows["log_scales"].copy_(torch.tensor([20.0, 0.01, 0.1]).log().expand(4, 3))
        model.sky.rows["log_scales"].copy_(torch.tensor([100.0, 0.5, 1.9]).log().expand(5, 3))
    hold_back_unseen(model, make_optimizer(model, train_settings()), CENTRES, BOUNDS)
    expected = torch.tensor([[0.5, 0.01, 0.1], [0.125, 0.01, 0.1], [1.5, 0.01, 0.1]])
    found = rows["log_scales"].detach().exp()
    torch.testing.assert_close(found, expected[[0, 1, 2, 2]], rtol=1e-5, atol=0)
    sky = model.sky.rows["log_scales"].detach().exp()
    wanted = torch.tensor([2.0, 0.5, 1.9]).expand(5, 3)  # a quarter of the dome's radius of 8
    torch.testing.assert_close(sky, wanted, rtol=1e-5, atol=0)


def test_cameras_amidst_all_gaussians_take_none_away(model):
    """All would be too near to a camera only if the median were none."""
    optimizer = make_optimizer(model, train_settings())
    with torch.no_grad():
        model.foreground["means"].zero_()
    assert hold_back_unseen(model, optimizer, [torch.zeros(3)], BOUNDS) == 0
    assert len(model.foreground) == 4
    assert model.foreground["log_scales"].isfinite().all()


def test_it_acts_as_often_as_density_changes_and_in_the_end():
    settings = train_settings(iterations=400, density={"interval": 1000, "last": 15000})
    schedule = replace(Schedule.of(settings), iterations=405)
    acting = [i for i in range(1, 406) if schedule.holds_back_unseen(i)]
    assert acting == [*range(10, 405, 10), 405]


def test_it_is_off_in_the_paper_s_settings():
    assert not train_settings().unseen.enabled
