"""The one-kernel Adam step against torch's own Adam in float64; rates that fall."""

import pytest
import torch
from support.flat_world import flat_points
from support.settings import train_settings

from r3gw.training.optimizer import EPSILON, POSITIONS, adam_step, make_optimizer, set_rates
from r3gw.training.schedule import Schedule
from r3gw.training.start import initial_model

RATES = (1e-3, 0.05)
SHAPES = ((), (7, 3), (20000, 2))


def groups(values):
    """Two groups: two tensors at one rate, one at another."""
    return [
        {"params": [values[0], values[1]], "lr": RATES[0]},
        {"params": [values[2]], "lr": RATES[1]},
    ]


def start(dtype):
    """Parameters of one value, a few, and more than one block of the kernel; all 0."""
    return [torch.zeros(shape, dtype=dtype, requires_grad=True) for shape in SHAPES]


def gradients(round_):
    """Gradients over twelve orders of magnitude, some of them 0."""
    generator = torch.Generator().manual_seed(100 + round_)
    for shape in SHAPES:
        size = 10 ** (12 * torch.rand(shape, generator=generator) - 10)
        kept = torch.rand(shape, generator=generator) < 0.9
        yield torch.randn(shape, generator=generator) * size * kept


def test_equals_torch_in_double_precision():
    values, exact = start(torch.float32), start(torch.float64)
    ours = torch.optim.Adam(groups(values), eps=EPSILON)
    theirs = torch.optim.Adam(groups(exact), eps=EPSILON, foreach=False, fused=False)
    for round_ in range(6):
        for value, plain, gradient in zip(values, exact, gradients(round_), strict=True):
            value.grad, plain.grad = gradient, gradient.double()
        adam_step(ours)
        theirs.step()
        assert all(value.grad is None for value in values)
    for value, plain in zip(values, exact, strict=True):
        # Steps of both signs add up to less than each: hence what rounding leaves of a rate.
        torch.testing.assert_close(value.double(), plain, rtol=1e-5, atol=1e-7)
        assert float(value.detach().abs().amax()) > 1e-5
        for key in ("exp_avg", "exp_avg_sq"):
            found, wanted = ours.state[value][key].double(), theirs.state[plain][key]
            atol = 1e-7 * float(wanted.abs().amax())  # The mean's terms cancel.
            torch.testing.assert_close(found, wanted, rtol=1e-6, atol=atol)
        assert ours.state[value]["step"].item() == 6


def test_a_parameter_without_gradient_stays():
    values = start(torch.float32)
    adam = torch.optim.Adam(groups(values), eps=EPSILON)
    values[1].grad = torch.ones_like(values[1])
    adam_step(adam)
    assert values[1].all()
    for i in (0, 2):
        assert not values[i].any()
        assert adam.state[values[i]]["step"] == 0


@pytest.mark.parametrize("threads", [1, 2])
def test_goes_on_from_the_state_of_torch(threads):
    """Whoever takes the second step, and with however many threads, the state is the same."""
    before = torch.get_num_threads()
    torch.set_num_threads(threads)
    values, others = start(torch.float32), start(torch.float32)
    ours = torch.optim.Adam(groups(values), eps=EPSILON, fused=True)
    theirs = torch.optim.Adam(groups(others), eps=EPSILON, fused=True)
    for round_ in range(2):
        for value, other, gradient in zip(values, others, gradients(round_), strict=True):
            value.grad, other.grad = gradient, gradient.clone()
        theirs.step()
        ours.step() if round_ == 0 else adam_step(ours)
    torch.set_num_threads(before)
    for value, other in zip(values, others, strict=True):
        torch.testing.assert_close(value, other, rtol=1e-6, atol=1e-6)
        assert ours.state[value]["step"] == theirs.state[other]["step"]


def rates_at(iteration, **late):
    settings = train_settings(iterations=400, rates=late)
    optimizer = make_optimizer(initial_model(flat_points(), ("a", "b"), settings), settings)
    for i in (1, iteration):
        set_rates(optimizer, settings.rates, Schedule.of(settings), i)
    return {group["name"]: group["lr"] for group in optimizer.param_groups}


def test_late_rates_fall_for_all_but_positions():
    late = {"late_share": 0.1, "late_from": 20000}
    first, last = rates_at(2, **late), rates_at(400, **late)
    usual = rates_at(400)
    assert len(first) > len(POSITIONS)
    for name, rate in first.items():
        if name in POSITIONS:
            assert last[name] == usual[name] < rate
        else:
            assert usual[name] == rate
            assert last[name] == pytest.approx(0.1 * rate, rel=1e-9)
