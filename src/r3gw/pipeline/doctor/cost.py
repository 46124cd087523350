"""How long a training takes and how much memory it needs: predicted from measured runs.

All constants are in `MEASURED`. After a change of speed, measure again: a training of the chapel at
the settings of config.yaml gives time and memory (timing.json).
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Measured:
    """One measured training and how its cost is shared out.

    Attributes:
        ms_per_iteration: Time of an iteration on one core, at ``gaussians`` and ``pixels``.
        gaussians: Number of Gaussians, foreground and sky.
        pixels: Pixels of a photo.
        fixed_share, pixel_share: Shares of the time that are always needed, and that grow with
            pixels; the rest grows with Gaussians.
        base_mb: Memory that every training needs (10^6 bytes).
        kb_per_gaussian, kb_per_pixel: Memory while training (10^3 bytes).
        bytes_per_photo_pixel: Colour and two masks.
    """

    ms_per_iteration: float
    gaussians: int
    pixels: int
    fixed_share: float
    pixel_share: float
    base_mb: float
    kb_per_gaussian: float
    kb_per_pixel: float
    bytes_per_photo_pixel: int = 5


# Fitted to the processor's time of three trainings (tests/pipeline/doctor/test_cost.py): 2 ms an
# iteration, 80 ms a million pixels, 0.42 ms a thousand Gaussians. Memory: training_memory.py.
MEASURED = Measured(
    ms_per_iteration=11.8,
    gaussians=15_000,
    pixels=240 * 180,
    fixed_share=0.17,
    pixel_share=0.29,
    base_mb=440.0,
    kb_per_gaussian=1.0,
    kb_per_pixel=0.15,
)


@dataclass(frozen=True)
class MeasuredShadows:
    """What a training takes more if the foreground casts shadows on itself.

    Attributes:
        us_per_ray: Time of one direction of one Gaussian, each time that shadows are cast.
        kb_per_gaussian: Memory per Gaussian beyond what training needs (10^3 bytes).
    """

    us_per_ray: float
    kb_per_gaussian: float


# Chapel, 25,000 Gaussians: 30 s against 13.5 s of `full` (docs/performance.md), shadows cast 7
# times in 64 directions. Memory: training_memory.py.
SHADOWS = MeasuredShadows(us_per_ray=2.0, kb_per_gaussian=0.6)


@dataclass(frozen=True)
class Cost:
    """Of one training: seconds on one core, and megabytes (10^6 bytes)."""

    seconds: float
    memory_mb: float


def shadows_cost(casts: float, directions: int, gaussians: float, last_gaussians: int) -> Cost:
    """Predict what shadows add to one training.

    Args:
        casts: How often they are cast.
        directions: Of each Gaussian, every time.
        gaussians: Mean number over the training.
        last_gaussians: Number at its end.
    """
    seconds = 1e-6 * SHADOWS.us_per_ray * casts * directions * gaussians
    return Cost(seconds, 1e-3 * SHADOWS.kb_per_gaussian * last_gaussians)


def predicted_cost(
    iterations: int, first_gaussians: int, last_gaussians: int, pixels: float, photo_pixels: int
) -> Cost:
    """Predict one training without shadows.

    Args:
        iterations: How many iterations the run has.
        first_gaussians, last_gaussians: The number grows from one to the other, about linearly.
        pixels: Mean over the training photos.
        photo_pixels: Sum over the training photos.
    """
    mean = 0.5 * (first_gaussians + last_gaussians) / MEASURED.gaussians
    factor = MEASURED.fixed_share + MEASURED.pixel_share * pixels / MEASURED.pixels
    factor += (1.0 - MEASURED.fixed_share - MEASURED.pixel_share) * mean
    memory_mb = MEASURED.base_mb + 1e-6 * MEASURED.bytes_per_photo_pixel * photo_pixels
    memory_mb += 1e-3 * (MEASURED.kb_per_gaussian * last_gaussians + MEASURED.kb_per_pixel * pixels)
    return Cost(1e-3 * MEASURED.ms_per_iteration * iterations * factor, memory_mb)


def spoken_time(seconds: float) -> str:
    """A duration for people."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 90 * 60:
        return f"{seconds / 60:.0f} min"
    if seconds < 48 * 3600:
        return f"{seconds / 3600:.1f} h"
    return f"{seconds / 86400:.1f} days"
