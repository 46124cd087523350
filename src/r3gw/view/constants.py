"""Numbers that the page's shaders and scripts share with the Python renderer, from their owners."""

from math import factorial, pi, sqrt
from typing import Any

import numpy as np
import torch

from r3gw.geometry.rotations import rotation_about_axis
from r3gw.imaging.colour import DARKEST, GAMMA
from r3gw.lighting import sh
from r3gw.lighting.irradiance import COSINE_BANDS, DARKEST_IRRADIANCE
from r3gw.lighting.sh_rotation import rotate
from r3gw.raster.reference import FRUSTUM_MARGIN, LOW_PASS_PX2, MAX_ALPHA, MIN_ALPHA, NEAR_PLANE
from r3gw.relight import seen, uncovered, witnesses
from r3gw.relight.tone import REINHARD_WHITE
from r3gw.rendering.brdf_table import SMALLEST_COSINE, brdf_table
from r3gw.rendering.cook_torrance import DARKEST_SPECULAR, DIELECTRIC_F0

DEGREE = 4  # of the page's lights; lights of lower degree are filled up with zeros
TABLE_STEP = 3  # every third row and column of the split-sum table; 85 = 255 / 3 steps


def constants() -> dict[str, Any]:
    """Everything by the name that web/src/payload.ts gives it."""
    return {
        "gamma": GAMMA,
        "darkest": DARKEST,
        "darkestIrradiance": DARKEST_IRRADIANCE,
        "darkestSpecular": DARKEST_SPECULAR,
        "dielectricF0": DIELECTRIC_F0,
        "smallestCosine": SMALLEST_COSINE,
        "cosineBands": list(COSINE_BANDS),
        "reinhardWhite": REINHARD_WHITE,
        "nearPlane": NEAR_PLANE,
        "lowPassPx2": LOW_PASS_PX2,
        "maxAlpha": MAX_ALPHA,
        "minAlpha": MIN_ALPHA,
        "frustumMargin": FRUSTUM_MARGIN,
        "faint": uncovered.FAINT,
        "gapsFrom": uncovered.GAPS_FROM,
        "skyFrom": uncovered.SKY_FROM,
        "smallestShare": uncovered.SMALLEST_SHARE,
        "mostNear": witnesses.MOST_NEAR,
        "smallestWeight": witnesses.SMALLEST_WEIGHT,
        "nearDeg": seen.NEAR_DEG,
        "enoughPhotos": seen.ENOUGH_PHOTOS,
        "mostAsked": seen.MOST_ASKED,
        "guessedBrightness": seen.GUESSED_BRIGHTNESS,
        "guessedColour": seen.GUESSED_COLOUR,
        "poorShare": seen.POOR_SHARE,
        "shNorms": sh_norms(),
        "yawCosines": [m.tolist() for m in yaw_harmonics()[0]],
        "yawSines": [m.tolist() for m in yaw_harmonics()[1]],
    }


def sh_norms() -> list[float]:
    """Factor of each real basis function (r3gw.lighting.sh), in its order."""
    norms = []
    for l in range(DEGREE + 1):
        for m in range(-l, l + 1):
            k = abs(m)
            norm = sqrt((2 * l + 1) / (4 * pi) * factorial(l - k) / factorial(l + k))
            norms.append(norm if m == 0 else sqrt(2) * norm)
    return norms


def yaw_harmonics() -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Turns of SH light about the vertical, as a Fourier series over the angle.

    Coefficients turned by ``a`` are ``sum_k (cos(k a) C_k + sin(k a) S_k) @ coefficients`` with k
    from 0 to 4: exact, because band l holds frequencies up to l. Sampled from
    `r3gw.lighting.sh_rotation`.

    Returns:
        C_0..C_4 and S_0..S_4, each ``[25, 25]``, rounded to 1e-9.
    """
    count, samples = sh.num_coefficients(DEGREE), 2 * DEGREE + 1
    angles = [2 * pi * i / samples for i in range(samples)]
    identity = torch.eye(count, dtype=torch.float64)
    turns = np.stack([rotate(identity, rotation_about_axis(1, a)).numpy() for a in angles])
    series = np.fft.rfft(turns, axis=0) / samples
    series[1:] *= 2
    cosines, sines = np.round(series.real, 9) + 0.0, np.round(-series.imag, 9) + 0.0
    return list(cosines), list(sines)


def split_sum_table() -> np.ndarray:
    """F1 and F2, ``[86, 86, 2]`` half floats; row sqrt(n.v), column roughness, both 0 to 1."""
    table = brdf_table()[::TABLE_STEP, ::TABLE_STEP]
    return table.numpy().astype("<f2")
