"""The plain-torch reference by itself: finite differences in float64."""

import pytest
import torch

from r3gw.raster import reference


@pytest.mark.parametrize("channels", [1, 3, 8, 16])
def test_gradients_by_finite_differences(channels):
    # Broad Gaussians of middling opacity: every alpha stays clear of 1/255 and 0.99.
    generator = torch.Generator().manual_seed(channels)

    def rand(*shape):
        return torch.rand(*shape, generator=generator, dtype=torch.float64)

    count = 3
    means = rand(count, 3) + torch.tensor([-0.5, -0.5, 2.0], dtype=torch.float64)
    inputs = [means, rand(count, 4) + 0.1, 0.8 + rand(count, 3), 0.3 + 0.5 * rand(count)]
    inputs += [rand(count, channels), rand(channels)]
    camera = torch.eye(4, dtype=torch.float64)

    def images(means, quaternions, scales, opacities, features, background):
        gaussians = (means, quaternions, scales, opacities, features)
        result = reference.rasterize(*gaussians, camera, (4.0, 4.5, 2.2, 1.4), 4, 3, background)
        return result.features, result.alpha

    assert torch.autograd.gradcheck(images, [value.requires_grad_() for value in inputs])


def test_held_jacobian_by_finite_differences():
    """A mean far outside the frustum: its Jacobian is held, and its gradient knows."""
    mean = torch.tensor([[4.0, -3.0, 1.0]], dtype=torch.float64, requires_grad=True)
    scales = torch.tensor([[2.0, 3.0, 2.5]], dtype=torch.float64, requires_grad=True)
    quaternion = torch.tensor([[0.9, 0.1, -0.3, 0.2]], dtype=torch.float64, requires_grad=True)
    rest = (torch.full((1,), 0.7, dtype=torch.float64), torch.ones(1, 1, dtype=torch.float64))

    def image(mean, quaternion, scales):
        camera = torch.eye(4, dtype=torch.float64)
        result = reference.rasterize(
            mean, quaternion, scales, *rest, camera, (3.0, 3.0, 2.0, 2.0), 4, 4
        )
        return result.features

    assert float(image(mean, quaternion, scales).detach().min()) > 1 / 255
    assert torch.autograd.gradcheck(image, (mean, quaternion, scales))
