"""One pass returns consistent layers, and the model file keeps everything."""

import pytest
import torch

from r3gw.files import InputError
from r3gw.geometry.rotations import rotation_from_quaternion, shortest_axes
from r3gw.model.initial import InitialPoints
from r3gw.model.model_file import load_model, save_model
from r3gw.model.sky import SkyDome
from r3gw.rendering.channels import FOREGROUND, NORMAL, SKY, Layers
from r3gw.rendering.compose import draw, render
from r3gw.rendering.splats import splats_of
from r3gw.training.start import initial_model


@pytest.fixture
def rendering(model, camera):
    return render(model, camera, *model.appearance(0)[:2])


def test_layers_add_up_to_the_picture(rendering):
    total = rendering.planes[FOREGROUND] + rendering.planes[SKY]
    torch.testing.assert_close(total, rendering.colour.sum(-1), rtol=1e-5, atol=1e-5)


def test_opacity_layers_draw_what_the_foreground_covers(model, camera):
    """As drawing the foreground as white and the sky as black does, whatever the settings."""
    light, sky_light = model.appearance(0)[:2]
    rendering = render(model, camera, light, sky_light, Layers.OPACITY)
    colours = torch.zeros(model.num_gaussians, 3)
    colours[: len(model.foreground)] = 1.0
    splats = splats_of(model, camera, light, sky_light)
    white = draw(splats.with_colours(colours), camera).colour[..., 0]
    torch.testing.assert_close(rendering.foreground_opacity, white, rtol=1e-6, atol=1e-7)
    assert 0.3 < float(white.detach().max()) <= 1.0
    torch.testing.assert_close(rendering.colour, draw(splats, camera).colour, rtol=0, atol=0)
    with pytest.raises(ValueError, match="drawn with <Layers"):
        _ = draw(splats, camera).foreground_opacity


def test_depth_lies_between_the_nearest_and_the_farthest(rendering, model, camera):
    del model, camera
    covered = rendering.alpha > 0.5
    assert int(covered.sum()) > 100
    seen = rendering.splats.depths[rendering.radii_px > 0].detach()
    depth = rendering.depth.detach()[covered]
    assert float(seen.min()) - 1e-3 <= float(depth.min())
    assert float(depth.max()) <= float(seen.max()) + 1e-3


def test_normals_face_the_camera_and_leave_the_sky_out(model, camera):
    normals = splats_of(model, camera, *model.appearance(0)[:2]).features[
        : len(model.foreground), NORMAL
    ]
    to_camera = -model.foreground["means"].detach()
    assert bool(((normals.detach() * to_camera).sum(-1) >= 0).all())
    with torch.no_grad():
        model.foreground["opacity_logits"].fill_(-20.0)
    only_sky = render(model, camera, *model.appearance(0)[:2])
    assert float(only_sky.normal.detach().abs().max()) == 0.0
    assert float(only_sky.planes[FOREGROUND].detach().abs().max()) == 0.0
    assert float(only_sky.planes[SKY].detach().max()) > 0.1


def test_normal_is_the_shortest_axis(model):
    rows = model.foreground
    rotations = rotation_from_quaternion(rows["quaternions"].detach())
    normals = shortest_axes(rows["quaternions"].detach(), rows["log_scales"].detach())
    index = rows["log_scales"].detach().argmin(-1)
    for i in (0, 7, 31):
        torch.testing.assert_close(normals[i], rotations[i][:, index[i]], rtol=0, atol=1e-6)


def test_white_sky(model, camera):
    with torch.no_grad():
        model.foreground["opacity_logits"].fill_(-20.0)
    white = render(model, camera, model.appearance(0)[0], None)
    expected = white.alpha[..., None].expand(-1, -1, 3)
    torch.testing.assert_close(white.colour, expected, rtol=0, atol=1e-5)


def test_every_parameter_gets_a_gradient(model, camera):
    rendering = render(model, camera, *model.appearance(0)[:2])
    loss = rendering.colour.sum() + rendering.depth.mean() + rendering.normal.sum()
    torch.autograd.backward(loss)
    for part in (model.foreground, model.sky, model.appearance):
        for name, parameter in part.named_parameters():
            assert parameter.grad is not None, name
            assert float(parameter.grad.abs().max()) > 0, name
    assert rendering.means2d.grad is not None


def test_layer_channels_move_geometry_but_not_colour(model, camera):
    rendering = render(model, camera, *model.appearance(0)[:2])
    torch.autograd.backward(rendering.planes[FOREGROUND].sum() + rendering.planes[SKY].sum())
    assert float(model.foreground["opacity_logits"].grad.abs().max()) > 0
    albedo = model.foreground["albedo_logits"].grad
    assert albedo is None or float(albedo.abs().max()) == 0.0


def test_single_set_makes_the_sky_points_foreground(settings):
    one_set = settings.model.model_copy(update={"separate_sky": False})
    dome = SkyDome(torch.zeros(3), 5.0, (-1.0, 1.0))
    initial = InitialPoints(torch.rand(10, 3), dome, torch.rand(7, 2))
    model = initial_model(initial, ("a",), settings.model_copy(update={"model": one_set}))
    assert len(model.foreground) == 17
    assert len(model.sky.rows) == 0
    torch.testing.assert_close(
        model.foreground["means"].detach()[10:], initial.sky_points(), rtol=0, atol=1e-6
    )


def test_model_file_keeps_the_picture(model, camera, tmp_path):
    save_model(model, tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    assert again.photos == ("a", "b")
    model.appearance.eval()
    before = render(model, camera, *model.appearance(1)[:2]).colour
    after = render(again, camera, *again.appearance(1)[:2]).colour
    torch.testing.assert_close(after, before, rtol=0, atol=0)


def test_model_file_does_not_depend_on_its_name(model, tmp_path):
    """The temporary name holds the process id; it must not reach the bytes."""
    save_model(model, tmp_path / "one.safetensors")
    save_model(model, tmp_path / "another.safetensors")
    one, another = (tmp_path / f"{name}.safetensors" for name in ("one", "another"))
    assert one.read_bytes() == another.read_bytes()


def test_missing_model_is_a_clear_error(tmp_path):
    with pytest.raises(InputError, match=r"no such model; train the scene first"):
        load_model(tmp_path / "model.safetensors")
