"""The imported scene: ``scene.json`` and the files beside it, whatever format it came from.

All paths inside are relative to the folder of ``scene.json``, so a scene folder can be moved.

torch, which poses need, is imported by what makes one: stages that read names alone (masks, tables)
start a second sooner without it.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from r3gw.files import InputError, write_json
from r3gw.files.names import inside, leads_outside
from r3gw.files.npz import Array, read_npz, write_npz
from r3gw.files.strict import Strict, read_yaml, validated
from r3gw.imaging.formats import MOST_PIXELS
from r3gw.scene.sun_position import SunPosition

if TYPE_CHECKING:
    import r3gw.geometry.cameras
    import r3gw.geometry.similarity

_ARRAYS = {"xyz": Array(np.float32, (None, 3)), "rgb": Array(np.uint8, (None, 3))}

Row3 = tuple[float, float, float]
Row4 = tuple[float, float, float, float]


class EvaluationEntry(Strict):
    """How the published protocol lights one test view.

    Attributes:
        mask: Picture, white = evaluate; None evaluates the whole photo.
        env_map: LDR environment map of the view's session.
        rotation_rad: The map's initial rotation about x, y, z.
        threshold: Map values (0..1) above it are multiplied by ``scale``.
        scale: See ``threshold``.
        sun_angles_rad: First and last angle of the sweep.
    """

    mask: str | None
    env_map: str
    rotation_rad: Row3
    threshold: float
    scale: float
    sun_angles_rad: tuple[float, float]


class GroundTruth(Strict):
    """What is known exactly of a synthetic view.

    Attributes:
        exposure, white_balance: photo = display(radiance * exposure * white_balance).
        env_map: Linear HDR map in the world frame, in the units of ``radiance``.
        albedo, normal, depth: EXR pictures; normals in world axes, depth is camera z; 0 at sky.
    """

    exposure: float
    white_balance: Row3
    env_map: str
    albedo: str
    normal: str
    depth: str


class View(Strict):
    """One photo with its camera.

    Attributes:
        name: Unique among the views and safe as a file name (r3gw.scene.names.view_names): the
            photo's stem, or its path where stems are equal in several folders.
        path: The photo's path below the folder of photos, which masks and lists mean; None in
            scenes that were imported before paths were kept.
        image: The imported picture, relative to the scene's folder.
        width: Its width in px.
        height: Its height in px.
        source_size_px: The photo's width and height before the import, if it was larger.
        intrinsics: ``(fx, fy, cx, cy)`` in px.
        cam_from_world: Rigid transform ``[4, 4]``.
        split: Whether the photo is trained on or held out.
        session: When it was taken, for photos that share a light.
        sun: Where the sun stood over the place, if date, time and place are known.
        normals: Normal map that came with the photo, EXR, world axes, 0 where there is none.
        evaluation: How the published protocol lights it.
        truth: What is known exactly of it.
    """

    name: str
    path: str | None = None
    image: str
    width: int = Field(ge=1)
    height: int = Field(ge=1)
    source_size_px: tuple[int, int] | None = None
    intrinsics: Row4
    cam_from_world: tuple[Row4, Row4, Row4, Row4]
    split: Literal["train", "test"]
    session: str | None
    sun: SunPosition | None = None
    normals: str | None = None
    evaluation: EvaluationEntry | None = None
    truth: GroundTruth | None = None

    @property
    def camera(self) -> "r3gw.geometry.cameras.Camera":
        """The view's camera."""
        import torch

        from r3gw.geometry.cameras import Camera

        cam_from_world = torch.tensor(self.cam_from_world, dtype=torch.float64)
        return Camera(cam_from_world, self.intrinsics, self.width, self.height)


class Gauge(Strict):
    """The similarity ``scene_from_source`` that the import applied (identity if none)."""

    scale: float = Field(gt=0)
    rotation: tuple[Row3, Row3, Row3]
    translation: Row3

    @field_validator("rotation")
    @classmethod
    def _is_rotation(cls, rows: tuple[Row3, Row3, Row3]) -> tuple[Row3, Row3, Row3]:
        turn = np.array(rows)
        if not np.allclose(turn @ turn.T, np.eye(3), rtol=0, atol=1e-4) or np.linalg.det(turn) < 0:
            raise ValueError("is no rotation")
        return rows

    @staticmethod
    def of(similarity: "r3gw.geometry.similarity.Similarity") -> "Gauge":
        """Record a similarity transform."""
        values = {
            "scale": similarity.scale,
            "rotation": similarity.rotation.tolist(),
            "translation": similarity.translation.tolist(),
        }
        return Gauge.model_validate(values)

    @property
    def similarity(self) -> "r3gw.geometry.similarity.Similarity":
        """The recorded transform."""
        import torch

        from r3gw.geometry.similarity import Similarity

        rotation = torch.tensor(self.rotation, dtype=torch.float64)
        return Similarity(self.scale, rotation, torch.tensor(self.translation, dtype=torch.float64))


class Scene(Strict):
    """All views of a place, in one world frame (up = -y).

    ``resampling`` names the filter that made larger photos fit: area averages whole pixels.
    """

    name: str
    source_format: str
    resampling: Literal["area"] = "area"
    views: tuple[View, ...]
    scene_from_source: Gauge

    @property
    def source_from_scene(self) -> "r3gw.geometry.similarity.Similarity":
        """Back to the frame and scale in which the photos were given, for exports.

        Its `points` and `camera` map positions and cameras; lengths grow by its ``scale``, and
        directions and orientations turn by its ``rotation``.
        """
        return self.scene_from_source.similarity.inverse()

    def split(self, which: Literal["train", "test"]) -> tuple[View, ...]:
        """The views of one split, in order of their names."""
        return tuple(view for view in self.views if view.split == which)


@dataclass(frozen=True)
class Points:
    """The sparse points of the SfM model.

    Attributes:
        xyz: ``[N, 3]`` float32, world.
        rgb: ``[N, 3]`` uint8, display values.
    """

    xyz: NDArray[np.float32]
    rgb: NDArray[np.uint8]


def save_scene(scene: Scene, folder: Path) -> None:
    """Write ``folder/scene.json``, views in order of their names."""
    ordered = scene.model_copy(update={"views": tuple(sorted(scene.views, key=_name))})
    write_json(folder / "scene.json", ordered.model_dump(mode="json"))


def load_scene(folder: Path) -> Scene:
    """Read ``folder/scene.json``.

    Raises:
        InputError: If it is missing or malformed, or names files outside of ``folder``.
    """
    path = folder / "scene.json"
    scene = validated(Scene, read_yaml(path), str(path))
    for view in scene.views:
        _require_safe(view, folder, str(path))
    if len({view.name for view in scene.views}) < len(scene.views):
        raise InputError(f"{path}: two views have the same name; import the scene again")
    return scene


def _require_safe(view: View, folder: Path, source: str) -> None:
    """Refuse names that lead out of the scene's folder, and sizes that no picture has.

    Raises:
        InputError: On the first.
    """
    if leads_outside(view.name) or {"/", "\\"} & set(view.name):
        raise InputError(f"{source}: {view.name!r} is no name of a view; import the scene again")
    names = [view.image, *filter(None, [view.normals])]
    if view.evaluation is not None:
        names += [view.evaluation.env_map, *filter(None, [view.evaluation.mask])]
    if view.truth is not None:
        names += [getattr(view.truth, kind) for kind in ("env_map", "albedo", "normal", "depth")]
    for name in names:
        inside(folder, name, source)
    if view.width * view.height > MOST_PIXELS or min(view.intrinsics[:2]) <= 0:
        raise InputError(
            f"{source}: the camera of {view.name} ({view.width}x{view.height} px, focal length "
            f"{view.intrinsics[0]:g} px) is none; import the scene again"
        )


def save_points(points: Points, folder: Path) -> None:
    """Write ``folder/points.npz``."""
    write_npz(folder / "points.npz", {"xyz": points.xyz, "rgb": points.rgb})


def load_points(folder: Path) -> Points:
    """Read ``folder/points.npz``.

    Raises:
        InputError: If it is missing, damaged, or holds something else.
    """
    path = folder / "points.npz"
    arrays = read_npz(path, _ARRAYS, "import the scene again")
    if len(arrays["xyz"]) != len(arrays["rgb"]):
        raise InputError(f"{path}: has more colours or more points; import the scene again")
    return Points(arrays["xyz"], arrays["rgb"])


def _name(view: View) -> str:
    return view.name
