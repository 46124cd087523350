"""Tensors follow the device of what they belong to: plain forms run where the scene lies.

torch's device ``meta`` has shapes and no memory. An operation that mixes it with a tensor made on
the CPU raises an error, as one between a GPU and the CPU would.
"""

import torch

from r3gw.lighting.irradiance import irradiance
from r3gw.rendering.shading import shade_foreground
from r3gw.rendering.splats import splats_of
from r3gw.training.losses import geometry, lighting, reconstruction, separation, ssim

META = torch.device("meta")


def test_splats_of_a_scene_elsewhere(model, camera):
    """The camera stays on the CPU, as its docstring says; no kernel exists for the device."""
    model.foreground.to(META)
    model.sky.to(META)
    light, sky_light = torch.zeros(25, 3, device=META), torch.zeros(4, 3, device=META)
    splats = splats_of(model, camera, light, sky_light)
    assert splats.features.shape[0] == model.num_gaussians
    for tensor in (splats.means, splats.features, splats.depths, splats.smallest_scales):
        assert tensor.device == META


def test_the_light_of_a_scene_elsewhere(model):
    model.appearance.to(META)
    lit = model.appearance(0)
    assert lit.light.device == lit.sky_light.device == META


def test_relit_colours_elsewhere():
    rows = torch.zeros(5, 3, device=META)
    light = torch.zeros(9, 3, device=META)
    roughness, centre = torch.zeros(5, device=META), torch.zeros(3)
    colours = shade_foreground(rows, rows, rows, roughness, centre, light, with_specular=True)
    assert colours.device == irradiance(light, rows).device == META


def test_losses_elsewhere(camera):
    size = (camera.height, camera.width)
    colour, plane = torch.zeros(*size, 3, device=META), torch.ones(*size, device=META)
    mask = torch.ones(*size, dtype=torch.bool, device=META)
    light = torch.zeros(25, 3, device=META)
    found = [
        reconstruction.masked_l1(colour, colour, mask),
        ssim.mean_ssim(colour, colour, mask),
        geometry.normal_loss(colour, geometry.normals_from_depth(plane, camera), mask),
        geometry.flatness_loss(plane[0], mask[0]),
        separation.separation_loss(plane, plane, mask, mask),
        separation.silhouette_loss(plane, mask, mask, 0.1),
        lighting.positivity_loss(light, colour[0]),
    ]
    for loss in found:
        assert loss.device == META
        assert loss.shape == ()
