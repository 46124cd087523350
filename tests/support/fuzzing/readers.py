"""What is fuzzed: a reader, the folder of whole files that it reads, and which of them mutate."""

import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

import cv2
import numpy as np
import onnx
import OpenEXR
import pycolmap
import torch
from onnx import TensorProto, helper, numpy_helper
from PIL import Image

from r3gw.files.strict import read_yaml
from r3gw.geometry.similarity import Similarity
from r3gw.imaging.decode import read_picture
from r3gw.imaging.files import read_linear, read_rgb, write_exr
from r3gw.imaging.masks import read_mask
from r3gw.importing.evaluation_config import read_evaluation
from r3gw.importing.reader import Effort
from r3gw.importing.readers.colmap import ColmapReader
from r3gw.importing.readers.nerf_osr import NerfOsrReader
from r3gw.importing.readers.nerf_osr_original import NerfOsrOriginalReader
from r3gw.importing.readers.nerfstudio import NerfstudioReader
from r3gw.importing.readers.ply_points import read_ply_points
from r3gw.importing.settings import (
    ColmapScene,
    NerfOsrOriginalScene,
    NerfOsrScene,
    NerfstudioScene,
)
from r3gw.importing.source import SourcePoints
from r3gw.importing.split import read_split
from r3gw.lighting.envmap import read_env_map
from r3gw.lighting.light import Light
from r3gw.lighting.skies import LearnedSky
from r3gw.masks.labels import read_label_masks
from r3gw.masks.network import SegmentationNetwork
from r3gw.masks.settings import NetworkSettings
from r3gw.model.initial import InitialPoints, load_initial, save_initial
from r3gw.model.model_file import load_model, save_model
from r3gw.model.sky import SkyDome
from r3gw.pipeline.config import load_config
from r3gw.relight.files.lights_file import write_lights
from r3gw.relight.files.ply import Baked, Placement, read_ply, write_ply
from r3gw.relight.gaussians import Relightable
from r3gw.scene import (
    Gauge,
    Points,
    Scene,
    View,
    load_points,
    load_scene,
    save_points,
    save_scene,
)
from r3gw.training.checkpoint import Checkpoints
from r3gw.training.settings import load_train_settings
from r3gw.training.state import first_state
from support import formats, heic, nerf_osr_layout
from support.settings import train_settings
from support.small_model import small_model

REPOSITORY = Path(__file__).parents[3]


@dataclass(frozen=True)
class Target:
    """One reader to fuzz.

    Attributes:
        make: Writes whole files into a folder.
        read: Reads them; it may raise InputError and nothing else.
        files: Pattern of the files that mutate.
        weight: Share of all inputs, relative to others.
    """

    make: Callable[[Path], object]
    read: Callable[[Path], object]
    files: str = "*"
    weight: float = 1.0


def noise(height: int, width: int, channels: int = 3) -> np.ndarray:
    """A picture with runs, edges and noise, so that every coding of a format is used."""
    image = np.random.default_rng(0).integers(0, 256, (height, width, channels), dtype=np.uint8)
    image[: height // 2, : width // 2] = 77
    return image


def picture(form: str, name: str, channels: int = 3, **options: object) -> Target:
    """A photo of a format."""

    def make(folder: Path) -> None:
        Image.fromarray(noise(16, 32, channels).squeeze()).save(folder / name, form, **options)

    return Target(make, lambda folder: read_picture(folder / name).upright())


def _heic(folder: Path) -> None:
    (folder / "a.heic").write_bytes(heic.TURNED)


def _deep_png(folder: Path) -> None:
    values = np.random.default_rng(1).integers(0, 65536, (12, 16, 4), dtype=np.uint16)
    cv2.imwrite(str(folder / "a.png"), values)


def _mask(folder: Path) -> None:
    alpha = np.where(noise(16, 32)[..., 0] > 99, 255, 0).astype(np.uint8)
    Image.fromarray(np.dstack([noise(16, 32), alpha])).save(folder / "a.png")


def _exr(folder: Path) -> None:
    write_exr(folder / "a.exr", noise(8, 16).astype(np.float32))


def _layered_exr(folder: Path) -> None:
    plane = noise(8, 16)[..., 0].astype(np.float16)
    names = ("L.R", "L.G", "L.B", "L.A", "Z")
    header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.tiledimage}
    header["tiles"] = OpenEXR.TileDescription()
    header["tiles"].xSize = header["tiles"].ySize = 8
    OpenEXR.File(header, dict.fromkeys(names, plane)).write(str(folder / "a.exr"))


def _hdr(folder: Path) -> None:
    cv2.imwrite(str(folder / "a.hdr"), noise(8, 16).astype(np.float32))


def _gaussians() -> Relightable:
    return Relightable(
        torch.randn(6, 3),
        torch.randn(6, 4),
        torch.randn(6, 3),
        torch.randn(6),
        torch.rand(4, 3),
        torch.rand(4),
        {"p": Light(torch.rand(25, 3), LearnedSky(torch.rand(4, 3)))},
        4,
        True,
        torch.rand(4, 25),
    )


def _relightable(folder: Path) -> None:
    gaussians = _gaussians()
    baked = Baked(torch.rand(6, 3), torch.zeros(6, 3))
    placement = Placement("source", replace(Similarity.identity(), scale=2.0))
    write_ply(folder / "a.ply", gaussians, baked, placement, relightable=True)
    write_lights(gaussians.lights, "source", folder)


def _scene_in(folder: Path) -> Path:
    """A scene in layout A, as `support.formats` needs it: photos .jpg, masks .png."""
    layout = nerf_osr_layout.build(folder / "made")
    for path in list((layout.undistorted / "images").iterdir()):
        pixels = cv2.imread(str(path))
        path.unlink()
        cv2.imwrite(str(path.with_suffix(".jpg")), pixels)
    for path in list((layout.undistorted / "masks").iterdir()):
        path.rename(path.with_suffix(".png"))
    return layout.folder


def _colmap(folder: Path) -> None:
    formats.colmap_folder(_scene_in(folder), folder / "x")


def _colmap_text(folder: Path) -> None:
    formats.colmap_folder(_scene_in(folder), folder / "x")
    sparse = folder / "x" / "sparse"
    pycolmap.Reconstruction(sparse).write_text(sparse)
    for path in sparse.glob("*.bin"):
        path.unlink()


def _nerfstudio(folder: Path) -> None:
    formats.nerfstudio(_scene_in(folder), folder / "x")


def _original(folder: Path) -> None:
    formats.nerf_osr_original(_scene_in(folder), folder / "x")


def _read_by(reader: type, settings: object) -> Callable[[Path], object]:
    def read(folder: Path) -> object:
        made = reader(settings, folder / "x")
        made.missing()
        with tempfile.TemporaryDirectory(prefix="fuzz-") as work:
            return made.read(Effort(Path(work), 1))

    return read


def _read_original(folder: Path) -> object:
    """Cameras alone: without a sparse model, the reader would match all photos."""
    points = SourcePoints(np.zeros((1, 3)), np.zeros((1, 3), np.uint8))
    place = "r3gw.importing.readers.nerf_osr_original.triangulated_points"
    with patch(place, return_value=points):
        settings = NerfOsrOriginalScene(format="nerf-osr-original", path=".")
        return _read_by(NerfOsrOriginalReader, settings)(folder)


def _model(folder: Path) -> None:
    save_model(small_model(train_settings()), folder / "model.safetensors", {"seed": 0})


def _points(folder: Path) -> None:
    generator = np.random.default_rng(0)
    rgb = generator.integers(0, 255, (9, 3), dtype=np.uint8)
    save_points(Points(generator.random((9, 3), dtype=np.float32), rgb), folder)


def _initial(folder: Path) -> None:
    dome = SkyDome(torch.zeros(3), 9.0, (-1.0, 1.0))
    save_initial(InitialPoints(torch.rand(9, 3), dome, torch.rand(7, 2)), folder / "initial.npz")


def _copy(name: str) -> Callable[[Path], object]:
    def make(folder: Path) -> None:
        (folder / Path(name).name).write_bytes((REPOSITORY / name).read_bytes())

    return make


def _layout_a(folder: Path) -> None:
    nerf_osr_layout.build(folder / "x")


def _ground_truth(folder: Path) -> None:
    _layout_a(folder)
    view = {"session": "s", "exposure": 0.5, "white_balance": [1, 1, 1]}
    text = json.dumps({"views": dict.fromkeys(nerf_osr_layout.STEMS, view)})
    (folder / "x" / "ground_truth").mkdir()
    (folder / "x" / "ground_truth" / "ground_truth.json").write_text(text)


def _scene(folder: Path) -> None:
    view = View(
        name="a",
        image="images/a.png",
        width=8,
        height=6,
        intrinsics=(7.0, 7.5, 4.0, 3.0),
        cam_from_world=((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)),
        split="train",
        session=None,
    )
    gauge = Gauge.of(Similarity.identity())
    save_scene(
        Scene(name="x", source_format="photos", views=(view,), scene_from_source=gauge), folder
    )


def _checkpoint(folder: Path) -> None:
    settings = train_settings()
    checkpoints = Checkpoints(folder, {"part": "x"}, 0.0)
    checkpoints.save_if_due(first_state(small_model(settings), settings))


def _restore(folder: Path) -> object:
    """A damaged checkpoint is no error: training begins afresh, and says so."""
    settings = train_settings()
    return Checkpoints(folder, {"part": "x"}).restore(first_state(small_model(settings), settings))


def _network(folder: Path) -> None:
    weights = np.ones((3, 3, 1, 1), np.float32)
    shape = [1, 3, 16, 16]
    graph = helper.make_graph(
        [helper.make_node("Conv", ["x", "w"], ["scores"])],
        "tiny",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info("scores", TensorProto.FLOAT, shape)],
        [numpy_helper.from_array(weights, "w")],
    )
    opset = [helper.make_opsetid("", 13)]
    onnx.save(helper.make_model(graph, opset_imports=opset, ir_version=8), folder / "a.onnx")


def _segment(folder: Path) -> object:
    settings = NetworkSettings(model=str(folder / "a.onnx"), sky=(1,), width_px=16, height_px=16)
    return SegmentationNetwork(settings)(noise(16, 16))


COLMAP = _read_by(ColmapReader, ColmapScene(format="colmap", path="."))
NERFSTUDIO = _read_by(NerfstudioReader, NerfstudioScene(format="nerfstudio", path="."))
LAYOUT_A = _read_by(NerfOsrReader, NerfOsrScene(format="nerf-osr", path="."))
CITYSCAPES = "cityscapes-ids"

TARGETS = {
    "photo.png": picture("PNG", "a.png"),
    "photo.palette.png": picture("PNG", "a.png", 1),
    "photo.deep.png": Target(_deep_png, lambda folder: read_rgb(folder / "a.png")),
    "photo.jpg": picture("JPEG", "a.jpg", exif=b"Exif\0\0II*\0\x08\0\0\0\0\0"),
    "photo.progressive.jpg": picture("JPEG", "a.jpg", progressive=True),
    "photo.tif": picture("TIFF", "a.tif", compression="tiff_lzw"),
    "photo.webp": picture("WEBP", "a.webp", 4),
    "photo.avif": picture("AVIF", "a.avif"),
    "photo.bmp": picture("BMP", "a.bmp"),
    "photo.heic": Target(_heic, lambda folder: read_picture(folder / "a.heic"), "*", 0.1),
    "mask.png": Target(_mask, lambda folder: read_mask(folder / "a.png", 32, 16)),
    "labels.png": Target(
        picture("PNG", "a.png", 1).make,
        lambda folder: read_label_masks(folder / "a.png", CITYSCAPES, 32, 16),
    ),
    "map.exr": Target(_exr, lambda folder: read_env_map(folder / "a.exr")),
    "map.layers.exr": Target(_layered_exr, lambda folder: read_linear(folder / "a.exr")),
    "map.hdr": Target(_hdr, lambda folder: read_env_map(folder / "a.hdr")),
    "map.png": Target(
        picture("PNG", "a.png").make, lambda folder: read_env_map(folder / "a.png"), weight=0.5
    ),
    "colmap.bin": Target(_colmap, COLMAP, "x/sparse/*", 3.0),
    "colmap.txt": Target(_colmap_text, COLMAP, "x/sparse/*", 3.0),
    "colmap split and lists": Target(_colmap, COLMAP, "x/*_split.csv", 1.0),
    "transforms.json": Target(_nerfstudio, NERFSTUDIO, "x/transforms.json", 2.0),
    "sparse_pc.ply": Target(
        _nerfstudio, lambda folder: read_ply_points(folder / "x/sparse_pc.ply"), "x/sparse_pc.ply"
    ),
    "relightable.ply": Target(_relightable, lambda folder: read_ply(folder / "a.ply"), "*", 2.0),
    "split.csv": Target(
        _layout_a,
        lambda folder: read_split(folder / "x/undistorted/place_split.csv"),
        "x/undistorted/*.csv",
    ),
    "test_config.py": Target(
        _layout_a, lambda folder: read_evaluation(folder / "x/eval_files"), "x/eval_files/*.py", 2.0
    ),
    "ground_truth.json": Target(_ground_truth, LAYOUT_A, "x/ground_truth/*.json"),
    "matrices.txt": Target(_original, _read_original, "x/final/*/*/*.txt"),
    "scene.json": Target(_scene, load_scene, "*", 2.0),
    "points.npz": Target(_points, load_points),
    "initial.npz": Target(_initial, lambda folder: load_initial(folder / "initial.npz")),
    "model.safetensors": Target(
        _model, lambda folder: load_model(folder / "model.safetensors"), "*", 0.5
    ),
    "checkpoint": Target(_checkpoint, _restore, ".checkpoint*", 0.1),
    "settings (train.yaml)": Target(
        _copy("config/train.yaml"), lambda folder: load_train_settings(folder / "train.yaml")
    ),
    "config.yaml": Target(
        _copy("config/config.yaml"),
        lambda folder: load_config(read_yaml(folder / "config.yaml"), "config.yaml"),
        "*",
        2.0,
    ),
    "network.onnx": Target(_network, _segment, "*", 0.05),
}
