"""Clone, split and prune keep rows, optimizer state and the sky's hemisphere consistent."""

from math import pi

import pytest
import torch
from support.settings import train_settings

from r3gw.model.initial import InitialPoints
from r3gw.model.model import SceneModel
from r3gw.model.sky import SkyDome, sample_dome
from r3gw.training.density import (
    GradientStatistics,
    densify,
    reset_opacity,
    split_children,
)
from r3gw.training.growth import Growth, growth_at, rising_threshold, threshold_of_strongest
from r3gw.training.optimizer import make_optimizer
from r3gw.training.schedule import Schedule
from r3gw.training.start import initial_model

EXTENT = 10.0
DENSITY = train_settings().density
THRESHOLD = 1e-3


@pytest.fixture
def model(settings) -> SceneModel:
    """Twenty foreground and thirty sky Gaussians."""
    generator = torch.Generator().manual_seed(0)
    dome = SkyDome(torch.zeros(3), 8.0, (-1.0, 1.0))
    initial = InitialPoints(
        torch.randn(20, 3, generator=generator), dome, sample_dome(dome, 30, generator)
    )
    return initial_model(initial, ("a", "b"), settings)


@pytest.fixture
def optimizer(model, settings) -> torch.optim.Adam:
    """Adam after one step in which every row got its own gradient."""
    adam = make_optimizer(model, settings)
    for rows in (model.foreground, model.sky.rows):
        for value in rows.values.values():
            per_row = torch.arange(1.0, len(rows) + 1)
            value.grad = per_row.view(-1, *[1] * (value.dim() - 1)).expand_as(value).clone()
    adam.step()
    return adam


def grow(model, optimizer, gradients, density=DENSITY, **changes):
    arguments = {
        "growth": Growth(density.max_gaussians, THRESHOLD),
        "extent": EXTENT,
        "prune_huge": False,
        "sky_stays": False,
        "generator": torch.Generator().manual_seed(1),
    }
    densify(model, optimizer, gradients, density, **(arguments | changes))


def set_scales(rows, scale):
    with torch.no_grad():
        rows["log_scales"].fill_(torch.tensor(scale).log())


def test_small_gaussian_is_cloned_with_fresh_moments(model, optimizer):
    set_scales(model.foreground, 0.01)
    gradients = torch.zeros(50)
    gradients[3] = 2 * THRESHOLD
    before = model.foreground["means"].detach().clone()
    moment = optimizer.state[model.foreground["means"]]["exp_avg"].clone()
    grow(model, optimizer, gradients)
    after = model.foreground["means"].detach()
    assert len(model.foreground) == 21
    torch.testing.assert_close(after[:20], before, rtol=0, atol=0)
    torch.testing.assert_close(after[20], before[3], rtol=0, atol=0)
    state = optimizer.state[model.foreground["means"]]["exp_avg"]
    torch.testing.assert_close(state[:20], moment, rtol=0, atol=0)
    assert float(state[20].abs().max()) == 0.0


def test_large_gaussian_is_split_in_two_smaller_ones(model, optimizer):
    set_scales(model.foreground, 0.5)
    gradients = torch.zeros(50)
    gradients[7] = 2 * THRESHOLD
    before = model.foreground["means"].detach().clone()
    moment = optimizer.state[model.foreground["means"]]["exp_avg"].clone()
    grow(model, optimizer, gradients)
    assert len(model.foreground) == 21
    others = [i for i in range(20) if i != 7]
    after = model.foreground["means"].detach()
    torch.testing.assert_close(after[:19], before[others], rtol=0, atol=0)
    state = optimizer.state[model.foreground["means"]]["exp_avg"]
    torch.testing.assert_close(state[:19], moment[others], rtol=0, atol=0)
    scales = model.foreground["log_scales"].detach().exp()[19:]
    torch.testing.assert_close(scales, torch.full((2, 3), 0.5 / 1.6), rtol=1e-5, atol=0)
    assert 0 < float((after[19] - after[20]).norm()) < 6 * 0.5


def test_children_scatter_as_the_parent(model):
    """Many splits of one anisotropic, rotated parent: sample covariance equals R S S^T R^T."""
    count = len(model.foreground)
    scales = torch.tensor([0.9, 0.3, 0.2])
    half = torch.tensor(pi / 8)  # a turn of 45 degrees about z
    with torch.no_grad():
        model.foreground["means"].zero_()
        model.foreground["log_scales"].copy_(scales.log().expand(count, 3))
        turn = torch.stack([half.cos(), half * 0, half * 0, half.sin()])
        model.foreground["quaternions"].copy_(turn.expand(count, 4))
    generator, draws = torch.Generator().manual_seed(5), []
    everyone = torch.ones(count, dtype=torch.bool)
    for _ in range(200):
        draws.append(split_children(model, model.foreground, everyone, generator)["means"])
    covariance = torch.cov(torch.cat(draws).T)
    c = 0.5**0.5
    rotation = torch.tensor([[c, -c, 0], [c, c, 0], [0, 0, 1]])
    expected = rotation @ torch.diag(scales.square()) @ rotation.T
    torch.testing.assert_close(covariance, expected, rtol=0, atol=0.04)


def test_split_sky_stays_on_the_hemisphere(model, optimizer):
    set_scales(model.sky.rows, 3.0)
    gradients = torch.cat([torch.zeros(20), torch.full((30,), 2 * THRESHOLD)])
    grow(model, optimizer, gradients)
    assert len(model.sky.rows) == 60
    offsets = model.sky.means().detach() - model.sky.centre
    torch.testing.assert_close(
        offsets.norm(dim=-1), model.sky.radius.detach().expand(60), rtol=1e-5, atol=0
    )
    phi = model.sky.rows["angles"].detach()[:, 1]
    assert -1.0 <= float(phi.min()) <= float(phi.max()) <= 1.0
    assert len(model.foreground) == 20


def test_transparent_and_huge_gaussians_go(model, optimizer):
    set_scales(model.foreground, 0.01)
    with torch.no_grad():
        model.foreground["opacity_logits"][2] = -7.0
        model.foreground["log_scales"][5] = 1.0
    grow(model, optimizer, torch.zeros(50))
    assert len(model.foreground) == 19
    grow(model, optimizer, torch.zeros(49), prune_huge=True)
    assert len(model.foreground) == 18


@pytest.mark.parametrize(("share", "expected"), [(1.0, 60), (0.4, 40), (0.2, 30)])
def test_the_sky_grows_to_its_share_alone(model, optimizer, share, expected):
    """Of 100 Gaussians; the foreground, untouched here, is not counted."""
    density = DENSITY.model_copy(
        update={"max_gaussians": 100, "sky_share": share, "min_opacity": 1e-6}
    )
    grown = torch.cat([torch.zeros(20), torch.full((30,), 2 * THRESHOLD)])
    grow(model, optimizer, grown, density)
    assert (len(model.foreground), len(model.sky.rows)) == (20, expected)


def test_budget_takes_the_strongest(model, optimizer):
    set_scales(model.foreground, 0.01)
    capped = DENSITY.model_copy(update={"max_gaussians": 52})
    gradients = torch.cat([torch.linspace(1, 2, 20), torch.zeros(30)])
    last = model.foreground["means"].detach()[[18, 19]].clone()
    grow(model, optimizer, gradients, capped)
    assert model.num_gaussians == 52
    added = model.foreground["means"].detach()[20:]
    torch.testing.assert_close(added.sort(0).values, last.sort(0).values, rtol=0, atol=0)


def test_training_goes_on_after_density_changes(model, optimizer):
    set_scales(model.foreground, 0.01)
    grow(model, optimizer, torch.full((50,), 1.0))
    parameters = [p for g in optimizer.param_groups for p in g["params"]]
    for parameter in parameters:
        parameter.grad = torch.ones_like(parameter)
    before = model.foreground["means"].detach().clone()
    optimizer.step()
    assert bool((model.foreground["means"].detach() < before).all())


def test_opacity_reset(model, optimizer):
    with torch.no_grad():
        model.foreground["opacity_logits"].fill_(2.0)
        model.foreground["opacity_logits"][0] = -6.0
    reset_opacity(model, optimizer, 0.01)
    opacity = model.foreground["opacity_logits"].detach().sigmoid()
    torch.testing.assert_close(opacity[1:], torch.full((19,), 0.01), rtol=1e-5, atol=0)
    assert float(opacity[0]) < 0.01
    state = optimizer.state[model.foreground["opacity_logits"]]
    assert float(state["exp_avg"].abs().max()) == 0.0


def test_threshold_rises_exponentially():
    assert rising_threshold(0.0, 1e-4, 4e-4) == pytest.approx(1e-4, rel=1e-12)
    assert rising_threshold(0.5, 1e-4, 4e-4) == pytest.approx(2e-4, rel=1e-12)
    assert rising_threshold(1.0, 1e-4, 4e-4) == pytest.approx(4e-4, rel=1e-12)


def test_threshold_without_last_value_stays_the_first():
    assert {rising_threshold(progress, 2e-4, None) for progress in (0.0, 0.5, 1.0)} == {2e-4}


@pytest.mark.parametrize("count", [0, 1, 7, 50, 60])
def test_the_strongest_lie_above_their_threshold(count):
    gradients = torch.rand(50, generator=torch.Generator().manual_seed(3)) + 0.1
    chosen = gradients > threshold_of_strongest(gradients, count)
    expected = torch.zeros(50, dtype=torch.bool)
    expected[torch.argsort(gradients, descending=True)[:count]] = True
    assert torch.equal(chosen, expected)


def test_even_growth_reaches_the_largest_number_at_the_last_densification(model, optimizer):
    """130 Gaussians from 50 in four times: 20 each time, whatever was asked for by thresholds."""
    settings = train_settings()
    changes = {"growth": "even", "max_gaussians": 130, "first": 10, "last": 40, "interval": 10}
    density = settings.density.model_copy(update=changes | {"min_opacity": 1e-6})
    scaled = {"iterations": 100, "paper_iterations": 100, "density": density}
    schedule = Schedule.of(settings.model_copy(update=scaled))
    generator = torch.Generator().manual_seed(0)
    counts = []
    for iteration in (10, 20, 30, 40):
        assert schedule.densifies(iteration)
        gradients = torch.rand(model.num_gaussians, generator=generator) + 1e-9
        growth = growth_at(iteration, gradients, density, schedule)
        grow(model, optimizer, gradients, density, growth=growth)
        counts.append(model.num_gaussians)
    assert counts == [70, 90, 110, 130]


def test_a_threshold_lets_grow_what_exceeds_it_up_to_the_largest_number():
    settings = train_settings()
    schedule = Schedule.of(settings)
    density = settings.density
    first, last = (
        growth_at(iteration, torch.ones(3), density, schedule)
        for iteration in (schedule.densify_first, schedule.densify_last)
    )
    assert first == Growth(density.max_gaussians, pytest.approx(density.threshold_first, rel=1e-9))
    assert last == Growth(density.max_gaussians, pytest.approx(density.threshold_last, rel=1e-9))


def test_statistics_average_over_seen_views_in_ndc():
    statistics = GradientStatistics(3)
    gradient = torch.tensor([[3.0, 0.0], [0.0, 4.0], [9.0, 9.0]])
    radii = torch.tensor([2.0, 5.0, 0.0])
    statistics.add(gradient, radii, width=200, height=100)
    statistics.add(gradient, torch.tensor([2.0, 0.0, 0.0]), width=200, height=100)
    torch.testing.assert_close(
        statistics.mean(), torch.tensor([300.0, 200.0, 0.0]), rtol=1e-6, atol=0
    )


def test_statistics_lie_where_the_gaussians_do(model):
    model.foreground.to("meta")
    statistics = GradientStatistics.of(model)
    assert statistics.total.device.type == statistics.views.device.type == "meta"
    assert len(statistics.total) == model.num_gaussians
