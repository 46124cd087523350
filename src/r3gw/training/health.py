"""What ends a training, and what it says of Gaussians that ran out or into their bounds."""

import logging
from collections.abc import Mapping
from math import isfinite

from r3gw.files import InputError
from r3gw.model.model_file import model_tensors
from r3gw.training.density import Grown
from r3gw.training.photos import Photo
from r3gw.training.state import TrainingState

log = logging.getLogger(__name__)

REMEDY = "lower the learning rates or rates.short_run_boost"


class Diverged(InputError):
    """Training cannot go on; checkpoints of before are good."""


def require_finite_loss(
    state: TrainingState, photo: Photo, loss: float, parts: Mapping[str, float]
) -> None:
    """Stop if the loss is not finite.

    Raises:
        Diverged: With iteration, photo, the parts that are to blame and the number of Gaussians.
    """
    if isfinite(loss):
        return
    bad = [name for name, part in parts.items() if not isfinite(part)] or ["sum"]
    raise Diverged(
        f"training diverged at iteration {state.iteration} on photo {photo.name} with "
        f"{state.model.num_gaussians:,} Gaussians: the loss part(s) {', '.join(bad)} are not "
        f"finite; {REMEDY}"
    )


def diverged_in_rendering(state: TrainingState, photo: Photo, error: ValueError) -> Diverged:
    """What to raise when the renderer refuses a photo's Gaussians or their colours.

    Raises:
        Diverged: Instead, if a parameter is to blame.
    """
    require_finite_parameters(state)
    return Diverged(
        f"training diverged at iteration {state.iteration} on photo {photo.name} with "
        f"{state.model.num_gaussians:,} Gaussians: nothing can be drawn ({error}); {REMEDY}"
    )


def require_finite_parameters(state: TrainingState) -> None:
    """Stop if any parameter is not finite; a rasterizer that skips such Gaussians would hide it.

    Raises:
        Diverged: With iteration, parameter and the number of Gaussians.
    """
    for name, value in model_tensors(state.model).items():
        if not bool(value.isfinite().all()):
            count = int((~value.isfinite()).sum())
            raise Diverged(
                f"training diverged by iteration {state.iteration} with "
                f"{state.model.num_gaussians:,} Gaussians: {count:,} of {value.numel():,} values "
                f"of '{name}' are not finite; {REMEDY}"
            )


def watch_counts(state: TrainingState, grown: Grown) -> None:
    """Note and log once when a set is empty or kept from growing; ``state.notes`` go to run.json.

    Raises:
        InputError: If the foreground is empty.
    """
    model, iteration = state.model, state.iteration
    if len(model.foreground) == 0:
        raise Diverged(
            f"training lost all foreground Gaussians at iteration {iteration}; check the "
            "masks (polarity, coverage) and the learning rates"
        )
    most = f"density.max_gaussians ({state.settings.density.max_gaussians:,})"
    seen = {
        "sky_empty_at": (
            model.description.separate_sky and len(model.sky.rows) == 0,
            "the sky has no Gaussians left; check the masks (polarity, coverage)",
        ),
        "foreground_capped_at": (grown.foreground_capped, f"{most} keeps the foreground small"),
        "sky_capped_at": (grown.sky_capped, f"{most} and density.sky_share keep the sky small"),
    }
    for note, (is_so, sentence) in seen.items():
        if is_so and note not in state.notes:
            state.notes[note] = iteration
            log.warning("iteration %d: %s", iteration, sentence)
