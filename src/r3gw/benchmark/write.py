"""Write a generated scene in the NeRF-OSR layout with ground truth; every path is named here."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees, radians
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from r3gw.benchmark.devices import Device
from r3gw.benchmark.lights import CLIPPED, Session, phone_panorama, published_sun_angle
from r3gw.benchmark.render import Truth
from r3gw.files import write_json
from r3gw.geometry.cameras import Camera
from r3gw.imaging.colour import display_array_from_linear
from r3gw.imaging.files import write_exr, write_image
from r3gw.lighting.daylight import Map

ORIGINALS = "originals"  # Photos with lens distortion in a COLMAP folder of their own
# OpenCV's non-local means: strength for brightness and colour, window and search window in pixels.
DENOISING = (3, 6, 5, 15)


@dataclass(frozen=True)
class Shot:
    """One photo with everything known about it.

    Attributes:
        stem: File name without extension.
        session: Its light.
        camera: Its camera.
        radiance: ``[H, W, 3]`` linear light.
        exposure: Factor from radiance to the photo's linear values.
        white_balance: Factors per channel.
        is_kept: ``[H, W]``, False at occluders.
        is_evaluated: ``[H, W]``, True where metrics count.
        truth: Albedo, normals and depth.
        device: What took it; None where every photo has a pinhole camera of its own.
        is_denoised: Whether the photo's noise is smoothed away.
    """

    stem: str
    session: Session
    camera: Camera
    radiance: NDArray[np.float32]
    exposure: float
    white_balance: tuple[float, float, float]
    is_kept: NDArray[np.bool_]
    is_evaluated: NDArray[np.bool_]
    truth: Truth
    device: Device | None = None
    is_denoised: bool = False

    def photo(self) -> NDArray[np.uint8]:
        """The photo: ``display(radiance * exposure * white balance)``, 8 bit."""
        linear = self.radiance * self.exposure * np.asarray(self.white_balance, dtype=np.float32)
        pixels = np.round(display_array_from_linear(linear) * 255.0).astype(np.uint8)
        if not self.is_denoised:
            return pixels
        smooth = cv2.fastNlMeansDenoisingColored(pixels, None, *DENOISING)
        return np.asarray(smooth, dtype=np.uint8)


@dataclass(frozen=True)
class Taken:
    """What is still needed of a photo once its files are written."""

    stem: str
    session: Session
    camera: Camera
    exposure: float
    white_balance: tuple[float, float, float]
    is_kept: NDArray[np.bool_]
    depth: NDArray[np.float32]
    photo: NDArray[np.uint8]
    device: Device | None


@dataclass(frozen=True)
class Panorama:
    """What is known about a session's phone panorama.

    Attributes:
        yaw_rad: The phone's heading.
        scale: Factor on its clipped values (`r3gw.benchmark.lights.clipped_scale`).
    """

    yaw_rad: float
    scale: float


def write_shot(root: Path, shot: Shot) -> Taken:
    """Write photo, masks and ground truth of one view; return what later steps need."""
    base, stem = root / "undistorted", shot.stem
    is_sky = shot.truth.depth == 0
    photo = shot.photo()
    write_image(base / "images" / f"{stem}.jpg", photo)
    if shot.device is not None:
        original = shot.device.original(photo, shot.camera)
        write_image(root / ORIGINALS / "images" / f"{stem}.jpg", original)
    write_image(base / "masks" / f"{stem}.png", shot.is_kept)
    write_image(base / "sky_masks" / f"{stem}.png", ~is_sky)
    if shot.session.is_test:
        write_image(root / "eval_files" / "eval_mask" / f"{stem}.png", shot.is_evaluated)
    known = root / "ground_truth"
    write_exr(known / "albedo" / f"{stem}.exr", shot.truth.albedo)
    write_exr(known / "normal" / f"{stem}.exr", shot.truth.normal)
    depth = np.repeat(shot.truth.depth[..., None], 3, axis=2)
    write_exr(known / "depth" / f"{stem}.exr", depth)
    return Taken(
        stem,
        shot.session,
        shot.camera,
        shot.exposure,
        shot.white_balance,
        shot.is_kept,
        shot.truth.depth,
        photo,
        shot.device,
    )


def write_light(root: Path, session: Session, light: Map, yaw_rad: float) -> None:
    """The session's linear map, and the phone's panorama of it."""
    write_exr(root / "ground_truth" / "envmaps" / f"{session.name}.exr", light.astype(np.float32))
    if session.is_test:
        picture = np.round(phone_panorama(light, yaw_rad) * 255.0).astype(np.uint8)
        folder = root / "eval_files" / "ENV_MAP_CC" / session.name
        write_image(folder / "envmap.jpg", picture)


def write_split(root: Path, name: str, shots: Sequence[Taken]) -> None:
    """The CSV that says which photo is for training and which for testing."""
    rows = [f"{s.stem}.jpg;{'test' if s.session.is_test else 'train'}" for s in shots]
    text = "\n".join(["filename;split", *rows]) + "\n"
    (root / "undistorted" / f"{name}_split.csv").write_text(text)


def write_test_config(
    root: Path,
    shots: Sequence[Taken],
    panoramas: Mapping[str, Panorama],
    random: np.random.Generator,
) -> None:
    """The evaluation entries, a Python file as the published ones are.

    Args:
        root: Scene folder.
        shots: All photos; test photos get an entry.
        panoramas: The panorama of each session.
        random: Places the true angle inside the sweep, off its middle.
    """
    entries = []
    for shot in shots:
        if not shot.session.is_test:
            continue
        name = shot.session.name
        panorama = panoramas[name]
        angle = published_sun_angle(shot.session, panorama.yaw_rad)
        low = angle - 0.6 + float(random.uniform(-0.25, 0.25))
        entries.append(
            f'    "{shot.stem}.jpg": {{\n'
            f'        "mask_path": "eval_files/eval_mask/{shot.stem}.png",\n'
            f'        "env_map_path": "eval_files/ENV_MAP_CC/{name}/envmap.jpg",\n'
            '        "initial_env_map_rotation": {"x": -np.pi/2, "y": 0, "z": 0},\n'
            f'        "env_map_scaling": {{"threshold": {CLIPPED}, '
            f'"scale": {panorama.scale:.2f}}},\n'
            f'        "sun_angles": [{low:.6f}, {low + 1.2:.6f}],\n'
            "    },\n"
        )
    text = "import numpy as np\n\nconfig_test = {\n" + "".join(entries) + "}\n"
    (root / "eval_files" / "test_config.py").write_text(text)


def write_facts(
    root: Path,
    shots: Sequence[Taken],
    panoramas: Mapping[str, Panorama],
    made_with: dict[str, Any],
) -> None:
    """ground_truth.json: exposure of each view, light of each session, how it was made."""
    views = {
        shot.stem: {
            "session": shot.session.name,
            "exposure": shot.exposure,
            "white_balance": list(shot.white_balance),
        }
        for shot in shots
    }
    sessions = {shot.session.name: _session_facts(shot.session, panoramas) for shot in shots}
    facts = {"views": views, "sessions": sessions, "made_with": made_with}
    write_json(root / "ground_truth" / "ground_truth.json", facts)


def _session_facts(session: Session, panoramas: Mapping[str, Panorama]) -> dict[str, Any]:
    yaw = panoramas[session.name].yaw_rad
    angle = published_sun_angle(session, yaw)
    return {
        "split": "test" if session.is_test else "train",
        "sun_direction": [float(x) for x in session.sun_direction],
        "turbidity": session.turbidity,
        "overcast": session.overcast,
        "clouds": session.clouds,
        "ldr_yaw_deg": degrees(yaw),
        "published_sun_angle": angle,
        "sun_elevation": radians(session.sun_elevation_deg),
    }
