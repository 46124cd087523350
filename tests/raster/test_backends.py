"""One rasterizer, several implementations: found by name or by device, held to the same checks."""

import pytest
import torch

from r3gw.native import kernels
from r3gw.raster import RasterResult, backends, rasterize

ON_META = torch.device("meta")


@pytest.mark.parametrize("wanted", [None, 3])
def test_both_backends_agree(make_scene, monkeypatch, wanted):
    """Also where only some channels send a gradient to the features."""
    scene = make_scene(seed=2, channels=5).without_cutoffs(monkeypatch)
    options = {"num_feature_gradients": wanted}
    ours, our_gradients = scene.run(rasterize, backend="cpp", **options)
    theirs, their_gradients = scene.run(rasterize, torch.float64, backend="torch", **options)
    torch.testing.assert_close(ours.radii_px.double(), theirs.radii_px, rtol=1e-4, atol=1e-4)
    for name, gradient in our_gradients.items():
        size = float(their_gradients[name].abs().max())
        torch.testing.assert_close(
            gradient.double(), their_gradients[name], rtol=1e-4, atol=2e-5 * max(size, 1e-3)
        )


@pytest.mark.parametrize("backend", ["cpp", "torch"])
def test_bad_values_are_named_by_every_backend(make_scene, backend):
    scene = make_scene()
    scene.means[3, 1] = torch.nan
    with pytest.raises(ValueError, match="means must be finite: 1 of 180 values are not"):
        scene.run(rasterize, backend=backend)


def test_the_kernels_take_float32_alone(make_scene):
    with pytest.raises(ValueError, match="means must be a float32 tensor on a device of type cpu"):
        make_scene().run(rasterize, torch.float64)


def test_tensors_are_of_one_kind(make_scene):
    scene = make_scene()
    arguments = [scene.means, scene.quaternions, scene.scales.double(), scene.opacities]
    with pytest.raises(ValueError, match=r"scales must be a float32 tensor on cpu as means is"):
        rasterize(*arguments, scene.features, scene.cam_from_world, scene.intrinsics, 8, 8)


def test_a_name_that_nobody_has():
    with pytest.raises(ValueError, match="no rasterizer backend is called 'cuda'; there are: cpp"):
        backends.backend_named("cuda", torch.device("cpu"))


def test_the_device_chooses_and_another_backend_can_be_registered(make_scene, monkeypatch):
    monkeypatch.setattr(backends, "_BACKENDS", dict(backends._BACKENDS))
    monkeypatch.setattr(backends, "_DEFAULTS", dict(backends._DEFAULTS))
    seen = []

    def mine(means, *arguments) -> RasterResult:
        seen.append(means.device.type)
        return backends.backend_named("cpp", means.device)(means, *arguments)

    assert backends.backend_named(None, ON_META) is backends.backend_named("torch", ON_META)
    backends.register_backend("mine", mine, devices=["meta"])
    assert backends.backend_named(None, ON_META) is mine
    assert backends.backend_named(None, torch.device("cpu")) is not mine
    make_scene().run(rasterize, backend="mine")
    assert seen == ["cpu"]


def test_without_kernels_everything_is_plain():
    with kernels.switched_off():
        plain = backends.backend_named(None, torch.device("cpu"))
    assert plain is backends.backend_named("torch", torch.device("cpu"))
