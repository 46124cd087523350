"""r3gw.model.lights: learned lights are the network's."""

import torch

from r3gw.lighting import envmap
from r3gw.model.lights import photo_light


def test_learned_light_is_the_networks(tiny):
    light = photo_light(tiny.model, "a_0").sh
    torch.testing.assert_close(light, tiny.model.appearance(0)[0].detach(), rtol=0, atol=0)
    assert not light.requires_grad
    assert envmap.draw(light, 8).shape == (8, 16, 3)
