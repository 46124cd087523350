"""A trained scene under one light as files for other programs."""

from dataclasses import replace
from pathlib import Path
from typing import Literal

from r3gw.files import InputError
from r3gw.geometry.similarity import Similarity
from r3gw.lighting.light import Light
from r3gw.relight.bake import bake
from r3gw.relight.cameras import view_named
from r3gw.relight.files.gltf import write_glb
from r3gw.relight.files.lights_file import write_lights
from r3gw.relight.files.ply import Baked, Coordinates, Placement, write_ply
from r3gw.relight.move import moved
from r3gw.relight.tone import CURVES
from r3gw.relight.trained import TrainedScene


def export(
    trained: TrainedScene,
    target: str | Path,
    light: Light,
    *,
    view: str | None = None,
    tone: Literal["standard", "reinhard", "filmic"] = "standard",
    coordinates: Coordinates = "scene",
) -> None:
    """Write ``baked.ply``, ``relightable.ply``, ``baked.glb`` and ``lights.json``.

    Args:
        trained: What to write.
        target: Folder to write.
        light: What the colours are baked under.
        view: Photo from whose camera the colours are right; None means over the training views.
        tone: Name of the tone curve.
        coordinates: ``scene`` is r3gw's world (up = -y); ``source`` is that of the dataset or
            reconstruction, by the inverse of the similarity that the import applied. The glTF
            file follows its own format: up is +y.

    Raises:
        InputError: If the view is unknown, or the scene has no cameras.
    """
    scene, gaussians, folder = trained.scene, trained.gaussians, Path(target)
    if scene is None:
        raise InputError(
            f"{gaussians.origin}: an export needs the photos' cameras; load the model with the "
            "folder of its scene.json"
        )
    views = scene.split("train") if view is None else (view_named(scene, view),)
    baked = bake(gaussians, [each.camera for each in views], light, CURVES[tone])
    placement = Placement(coordinates, scene.scene_from_source.similarity)
    if coordinates == "source":
        source_from_scene = placement.scene_from_source.inverse()
        gaussians = moved(gaussians, source_from_scene)
        baked = _turned(baked, source_from_scene)
    write_ply(folder / "baked.ply", gaussians, baked, placement, relightable=False)
    write_ply(folder / "relightable.ply", gaussians, baked, placement, relightable=True)
    write_lights(gaussians.lights, coordinates, folder)
    write_glb(folder / "baked.glb", gaussians, baked)


def _turned(baked: Baked, target_from_source: Similarity) -> Baked:
    rotation = target_from_source.rotation.to(baked.normals)
    return replace(baked, normals=baked.normals @ rotation.T)
