"""Gaussians in glTF 2.0 binary files, by the extension KHR_gaussian_splatting.

Written as ratified by Khronos: unlike its review draft of 2025, scales are linear, not logs.
Rotations are unit quaternions xyzw, opacities lie in [0, 1], ``SH_DEGREE_0_COEF_0`` is
(display colour - 0.5) / Y_00, and ``COLOR_0`` lets other viewers show points. glTF's up is +y,
so the scene is turned half around its x axis.
"""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from r3gw.files import atomic_path
from r3gw.geometry.similarity import Similarity
from r3gw.relight.files.ply import Y_00, Baked
from r3gw.relight.gaussians import Relightable
from r3gw.relight.move import moved

EXTENSION = "KHR_gaussian_splatting"
FLOAT, POINTS, ARRAY_BUFFER = 5126, 0, 34962  # constants of glTF 2.0
KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


def write_glb(path: Path, gaussians: Relightable, baked: Baked) -> None:
    """Write a scene with baked colours as one .glb file."""
    attributes = _attributes(gaussians, baked)
    views, accessors, offset = [], [], 0
    for index, values in enumerate(attributes.values()):
        views.append(
            {
                "buffer": 0,
                "byteOffset": offset,
                "byteLength": values.nbytes,
                "target": ARRAY_BUFFER,
            }
        )
        kind = KINDS[values.shape[1]]
        accessor = {"bufferView": index, "componentType": FLOAT, "count": len(values), "type": kind}
        accessors.append(accessor)
        offset += values.nbytes
    position = attributes["POSITION"]
    accessors[0] |= {"min": position.min(axis=0).tolist(), "max": position.max(axis=0).tolist()}
    primitive = {
        "mode": POINTS,
        "attributes": {name: index for index, name in enumerate(attributes)},
        "extensions": {EXTENSION: {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}},
    }
    document = {
        "asset": {"version": "2.0", "generator": "r3gw"},
        "extensionsUsed": [EXTENSION],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "buffers": [{"byteLength": offset}],
        "bufferViews": views,
        "accessors": accessors,
    }
    binary = b"".join(values.tobytes() for values in attributes.values())
    with atomic_path(path) as temporary:
        temporary.write_bytes(_container(document, binary))


def _attributes(gaussians: Relightable, baked: Baked) -> dict[str, NDArray[np.float32]]:
    """Vertex attributes, float32 ``[N, c]``, POSITION first."""
    half_turn = torch.diag(torch.tensor([1.0, -1.0, -1.0], dtype=torch.float64))
    upright = moved(gaussians, Similarity(1.0, half_turn, torch.zeros(3, dtype=torch.float64)))
    opacity = upright.opacities[:, None]
    values = {
        "POSITION": upright.means,
        "COLOR_0": torch.cat([baked.colours, opacity], dim=1),
        f"{EXTENSION}:ROTATION": upright.quaternions[:, [1, 2, 3, 0]],
        f"{EXTENSION}:SCALE": upright.scales,
        f"{EXTENSION}:OPACITY": opacity,
        f"{EXTENSION}:SH_DEGREE_0_COEF_0": (baked.colours - 0.5) / Y_00,
    }
    return {
        name: np.ascontiguousarray(value.numpy(), dtype="<f4") for name, value in values.items()
    }


def _container(document: dict[str, Any], binary: bytes) -> bytes:
    """The GLB container (glTF 2.0, 4.4): header, JSON chunk, binary chunk, 4-byte aligned."""
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
