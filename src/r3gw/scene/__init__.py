"""A scene: cameras, photos, points, split and evaluation entries, on disk and in memory."""

from r3gw.scene.scene import (
    EvaluationEntry,
    Gauge,
    GroundTruth,
    Points,
    Scene,
    View,
    load_points,
    load_scene,
    save_points,
    save_scene,
)

__all__ = [
    "EvaluationEntry",
    "Gauge",
    "GroundTruth",
    "Points",
    "Scene",
    "View",
    "load_points",
    "load_scene",
    "save_points",
    "save_scene",
]
