"""Segmentation by an ONNX network: tiny networks built here, whose answer is known."""

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from r3gw.files import InputError
from r3gw.masks.network import SegmentationNetwork
from r3gw.masks.settings import NetworkSettings

PLAIN = {"mean": (0, 0, 0), "std": (1, 1, 1), "width_px": 96, "height_px": 64}


def write_network(path, *, ids=False, weights=True):
    """Scores: class 0 is 0.2, class 1 is blue minus red, class 2 is red minus blue."""
    names = ["x", "w", "b"] if weights else ["x"]
    kernel = np.zeros((3, 3, 1, 1), np.float32)
    kernel[1, :, 0, 0], kernel[2, :, 0, 0] = (-1, 0, 1), (1, 0, -1)
    nodes = [helper.make_node("Conv" if weights else "ReduceMean", names, ["scores"])]
    if ids:
        nodes.append(helper.make_node("ArgMax", ["scores"], ["ids"], axis=1, keepdims=0))
    output = ("scores", TensorProto.FLOAT, [1, 3, 64, 96] if weights else [1, 1, 1, 1])
    if ids:
        output = ("ids", TensorProto.INT64, [1, 64, 96])
    graph = helper.make_graph(
        nodes,
        "tiny",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, 3, 64, 96])],
        [helper.make_tensor_value_info(*output)],
        [
            numpy_helper.from_array(kernel, "w"),
            numpy_helper.from_array(np.array([0.2, 0, 0], np.float32), "b"),
        ][: 2 * weights],
    )
    opset = [helper.make_opsetid("", 13)]
    onnx.save(helper.make_model(graph, opset_imports=opset, ir_version=8), str(path))
    return str(path)


def photo(height, width):
    """A blue sky above; below, a red thing on the left and grey on the right."""
    pixels = np.full((height, width, 3), 120, np.uint8)
    pixels[: height // 2] = (60, 100, 220)
    pixels[height // 2 :, : width // 4] = (230, 40, 30)
    return pixels


@pytest.mark.parametrize("ids", [False, True])
@pytest.mark.parametrize("size", [(64, 96), (128, 192), (32, 48)])
def test_classes_become_masks(tmp_path, ids, size):
    model = write_network(tmp_path / "tiny.onnx", ids=ids)
    settings = NetworkSettings(model=model, sky=(1,), occluders=(2,), **PLAIN)
    pixels = photo(*size)
    is_valid, is_sky = SegmentationNetwork(settings)(pixels)
    blue_minus_red = pixels[..., 2].astype(int) - pixels[..., 0]
    wrong = (is_sky != (blue_minus_red > 51)) | (is_valid != (blue_minus_red > -51))
    # Where the photo is scaled, colours of neighbours mix along a border.
    assert not wrong.any() if size == (64, 96) else wrong.mean() < 0.04


def test_colours_are_normalised(tmp_path):
    model = write_network(tmp_path / "tiny.onnx")
    # (blue - 0.5) - red > 0.2 holds for no colour of the photo but blue above 0.7 + red.
    settings = NetworkSettings(model=model, sky=(1,), **PLAIN | {"mean": (0, 0, 0.5)})
    assert not SegmentationNetwork(settings)(photo(64, 96))[1].any()
    settings = NetworkSettings(model=model, sky=(1,), **PLAIN | {"mean": (0, 0, 0.4)})
    assert SegmentationNetwork(settings)(photo(64, 96))[1][:30].all()


def test_what_is_no_network_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.onnx: no such network"):
        SegmentationNetwork(NetworkSettings(model=str(tmp_path / "nowhere.onnx"), sky=(1,)))
    (tmp_path / "text.onnx").write_text("no network")
    with pytest.raises(InputError, match=r"text\.onnx: OpenCV cannot read"):
        SegmentationNetwork(NetworkSettings(model=str(tmp_path / "text.onnx"), sky=(1,)))


def test_unknown_class_and_wrong_answer_are_one_sentence(tmp_path):
    model = write_network(tmp_path / "tiny.onnx")
    network = SegmentationNetwork(NetworkSettings(model=model, sky=(7,), **PLAIN))
    with pytest.raises(InputError, match="knows 3 classes, but the settings name class 7"):
        network(photo(64, 96))
    model = write_network(tmp_path / "mean.onnx", weights=False)
    network = SegmentationNetwork(NetworkSettings(model=model, sky=(1,), **PLAIN))
    with pytest.raises(InputError, match=r"shape .* is no map of classes"):
        network(photo(64, 96))
