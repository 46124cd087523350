"""Dropped Gaussians: how many, which, and what becomes of the others."""

import torch
from support.small_model import camera, model, settings  # noqa: F401

from r3gw.rendering.splats import splats_of
from r3gw.training.dropping import LARGEST_OPACITY, dropped, share_at

LIGHT = torch.zeros(25, 3)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def test_the_share_of_the_foreground_is_gone_and_the_sky_is_whole(model, camera):  # noqa: F811
    with torch.no_grad():
        splats = splats_of(model, camera, LIGHT, None)
        gone = sum(
            (dropped(splats, 0.3, generator(seed)).opacities[:60] == 0).float().mean()
            for seed in range(200)
        )
        # 12,000 draws of 0.3: their mean's standard deviation is 0.0042.
        assert abs(float(gone) / 200 - 0.3) < 0.017
        assert torch.equal(dropped(splats, 0.3, generator()).opacities[60:], splats.opacities[60:])


def test_those_left_make_up_for_those_gone(model, camera):  # noqa: F811
    with torch.no_grad():
        splats = splats_of(model, camera, LIGHT, None)
        mean = torch.stack(
            [dropped(splats, 0.2, generator(seed)).opacities for seed in range(2000)]
        ).mean(0)
    small = splats.opacities < 0.2
    assert int(small[:60].sum()) > 20
    torch.testing.assert_close(mean[small], splats.opacities[small], rtol=0.06, atol=0)
    assert float(dropped(splats, 0.9, generator()).opacities[:60].max()) < LARGEST_OPACITY + 1e-6


def test_gradients_reach_those_left_alone(model, camera):  # noqa: F811
    splats = dropped(splats_of(model, camera, LIGHT, None), 0.5, generator())
    splats.opacities.sum().backward()
    gradient = model.foreground["opacity_logits"].grad
    is_gone = splats.opacities[:60].detach() == 0
    assert torch.equal(gradient == 0, is_gone)
    assert 10 < int(is_gone.sum()) < 50


def test_nothing_is_dropped_or_drawn_at_first(model, camera):  # noqa: F811
    splats = splats_of(model, camera, LIGHT, None)
    draws = generator()
    before = draws.get_state()
    assert dropped(splats, share_at(100, 3000, 0.0), draws) is splats
    assert torch.equal(draws.get_state(), before)
    assert share_at(3000, 3000, 0.2) == 0.2
    assert abs(share_at(750, 3000, 0.2) - 0.05) < 1e-12
