"""The export: a trained scene in, files for other programs out."""

from dataclasses import replace
from pathlib import Path

from r3gw.files import InputError
from r3gw.geometry.similarity import Similarity
from r3gw.relight.bake import bake
from r3gw.relight.cameras import view_named
from r3gw.relight.files.gltf import write_glb
from r3gw.relight.files.lights_file import write_lights
from r3gw.relight.files.ply import Baked, Coordinates, Placement, write_ply
from r3gw.relight.lights import LightOptions, light_over_time
from r3gw.relight.load import load_relightable
from r3gw.relight.move import moved
from r3gw.relight.tone import CURVES
from r3gw.scene import load_scene


def export(
    model_path: Path,
    scene_folder: Path,
    target: Path,
    light: LightOptions,
    *,
    view: str | None = None,
    tone: str = "standard",
    coordinates: Coordinates = "scene",
) -> None:
    """Write ``baked.ply``, ``relightable.ply``, ``baked.glb`` and ``lights.json``.

    Args:
        model_path: model.safetensors of a training, or relightable.ply of an export.
        scene_folder: Folder of scene.json.
        target: Folder to write.
        light: What the colours are baked under; it stands still.
        view: Photo from whose camera the colours are right; None means over the training views.
        tone: Name of the tone curve.
        coordinates: ``scene`` is r3gw's world (up = -y); ``source`` is that of the dataset or
            reconstruction, by the inverse of the similarity that the import applied. The glTF
            file follows its own format: up is +y.

    Raises:
        InputError: If a file is unreadable, a name unknown, or the light moves.
    """
    if light.moves:
        raise InputError("an export has one light: give plain numbers, not FROM:TO")
    gaussians, scene = load_relightable(model_path), load_scene(scene_folder)
    views = scene.split("train") if view is None else (view_named(scene, view),)
    shown = light_over_time(gaussians, light)(0.0)
    baked = bake(gaussians, [each.camera for each in views], shown, CURVES[tone])
    placement = Placement(coordinates, scene.scene_from_source.similarity)
    if coordinates == "source":
        source_from_scene = placement.scene_from_source.inverse()
        gaussians = moved(gaussians, source_from_scene)
        baked = _turned(baked, source_from_scene)
    write_ply(target / "baked.ply", gaussians, baked, placement, relightable=False)
    write_ply(target / "relightable.ply", gaussians, baked, placement, relightable=True)
    write_lights(gaussians.lights, coordinates, target)
    write_glb(target / "baked.glb", gaussians, baked)


def _turned(baked: Baked, target_from_source: Similarity) -> Baked:
    rotation = target_from_source.rotation.to(baked.normals)
    return replace(baked, normals=baked.normals @ rotation.T)
