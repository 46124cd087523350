"""Same inputs, same bytes: whatever the number of threads, and whatever else is in flight."""

import pytest
import torch

from r3gw.raster import rasterize


@pytest.fixture
def set_threads():
    before = torch.get_num_threads()
    yield torch.set_num_threads
    torch.set_num_threads(before)


def bytes_of(result, gradients):
    tensors = [result.features, result.alpha, result.radii_px, result.means2d, *gradients.values()]
    return [tensor.detach().numpy().tobytes() for tensor in tensors]


@pytest.mark.parametrize("channels", [3, 9, 20])
def test_bytes_do_not_depend_on_threads(make_scene, set_threads, channels):
    scene = make_scene(count=20_000, channels=channels, width=150, height=90, scale=0.03)
    outcomes = []
    for threads in (1, 2, 3):
        set_threads(threads)
        outcomes.append(bytes_of(*scene.run(rasterize)))
    assert outcomes[0] == outcomes[1] == outcomes[2]


def test_frames_in_flight_do_not_disturb_each_other(make_scene):
    scenes = [make_scene(seed=seed, count=40 + 30 * seed, channels=20) for seed in range(4)]
    alone = [scene.run(rasterize)[1]["means"] for scene in scenes]
    inputs, losses = [], []
    for scene in scenes:
        means = scene.means.clone().requires_grad_()
        result = rasterize(
            *(means, scene.quaternions, scene.scales, scene.opacities, scene.features),
            *(scene.cam_from_world, scene.intrinsics, scene.width, scene.height),
            scene.background,
        )
        inputs.append(means)
        loss = (result.features * scene.features_weight).sum()
        losses.append(loss + (result.alpha * scene.alpha_weight).sum())
    for loss in reversed(losses):
        loss.backward()
    for means, expected in zip(inputs, alone, strict=True):
        assert torch.equal(means.grad, expected)


def test_backward_can_be_repeated(make_scene):
    scene = make_scene(channels=20)
    means = scene.means.clone().requires_grad_()
    result = rasterize(
        *(means, scene.quaternions, scene.scales, scene.opacities, scene.features),
        *(scene.cam_from_world, scene.intrinsics, scene.width, scene.height),
    )
    loss = (result.features * scene.features_weight).sum()
    first, second = (torch.autograd.grad(loss, means, retain_graph=True)[0] for _ in range(2))
    assert torch.equal(first, second)
