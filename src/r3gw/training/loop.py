"""The training loop of one run: a scene, resolved settings, a seed."""

import sys

import torch
from tqdm import tqdm

from r3gw.files import InputError
from r3gw.model.model import SceneModel
from r3gw.model.occlusion import update_occlusion
from r3gw.model.rows import OCCLUSION
from r3gw.training.checkpoint import Checkpoints
from r3gw.training.density import (
    UNCAPPED,
    GradientStatistics,
    densify,
    reset_opacity,
)
from r3gw.training.growth import growth_at
from r3gw.training.health import (
    Diverged,
    diverged_in_rendering,
    require_finite_loss,
    require_finite_parameters,
    watch_counts,
)
from r3gw.training.lights.kinds import renew_light
from r3gw.training.objective import objective
from r3gw.training.occluders import find_occluders
from r3gw.training.optimizer import adam_step, set_rates
from r3gw.training.photos import Photo, camera_extent
from r3gw.training.resolution import PhotoSizes
from r3gw.training.schedule import Schedule
from r3gw.training.settings import TrainSettings
from r3gw.training.snapshots import Snapshots
from r3gw.training.state import TrainingState, first_state
from r3gw.training.unseen import hold_back_unseen
from r3gw.training.visible_sky import without_gains
from r3gw.training.watched import Watched

BAR_INTERVAL_S = (10.0, 0.1)  # in a log file, on a terminal


def train(
    model: SceneModel,
    photos: list[Photo],
    settings: TrainSettings,
    checkpoints: Checkpoints | None = None,
    watched: Watched | None = None,
    snapshots: Snapshots | None = None,
) -> TrainingState:
    """Optimise ``model`` on ``photos`` for the iterations that the settings name.

    Args:
        model: The initial model; changed in place, unless a checkpoint takes its place.
        photos: The training photos, in the order of ``model.photos``.
        settings: The settings of the run.
        checkpoints: Where to continue from and save to; None does neither.
        watched: Where to show the run to those who watch it; None shows nothing.
        snapshots: Where to write the run on its way; None writes nothing.

    Raises:
        InputError: If the loss stops being finite or the foreground vanishes.
    """
    state = first_state(model, settings)
    if checkpoints is not None:
        state = checkpoints.restore(state)
    schedule = Schedule.of(settings)
    state.model.appearance.train()
    try:
        _run(state, photos, schedule, checkpoints, watched, snapshots)
    except Diverged as error:
        kept = "" if checkpoints is None else checkpoints.kept()
        raise InputError(f"{error}{kept}") from None
    state.model.appearance.eval()
    return state


def _run(
    state: TrainingState,
    photos: list[Photo],
    schedule: Schedule,
    checkpoints: Checkpoints | None,
    watched: Watched | None,
    snapshots: Snapshots | None,
) -> None:
    """Do the iterations that are left."""
    iterations = state.settings.iterations
    extent = camera_extent([photo.camera for photo in photos])
    sizes = PhotoSizes(photos, schedule)
    if state.occluders:
        sizes.leave_out(state.occluders)
    interval_s = BAR_INTERVAL_S[sys.stderr.isatty()]
    with tqdm(
        total=iterations, initial=state.iteration, desc="train", mininterval=interval_s
    ) as bar:
        while state.iteration < iterations:
            row = step(state, sizes, schedule, extent, watched)
            if row is not None:
                bar.set_postfix_str(_postfix(row), refresh=False)
            bar.update()
            if checkpoints is not None:
                checkpoints.save_if_due(state)
            if snapshots is not None:
                snapshots.save_if_due(state)
    require_finite_parameters(state)


def step(
    state: TrainingState,
    sizes: PhotoSizes,
    schedule: Schedule,
    extent: float,
    watched: Watched | None,
) -> dict[str, float | int] | None:
    """Do one iteration; return its row of the history if it gets one."""
    state.iteration += 1
    iteration, model, settings = state.iteration, state.model, state.settings
    set_rates(state.optimizer, settings.rates, schedule, iteration)
    index = state.order.next(state.generator)
    photo = sizes.photo(index, iteration)
    if schedule.renews_light(iteration):
        seen_skies = [photo.seen_sky for photo in sizes.photos]
        gains = model.appearance.gains().detach()
        renew_light(model.appearance, without_gains(seen_skies, gains))
    try:
        rendering, loss, parts = objective(
            model, settings, photo, index, iteration, schedule, state.generator, state.sun_shadows
        )
    except ValueError as error:
        raise diverged_in_rendering(state, photo, error) from error
    require_finite_loss(state, photo, float(loss.detach()), parts)
    torch.autograd.backward(loss)
    moving = rendering.means2d if rendering.pulls2d is None else rendering.pulls2d
    gradient = moving.grad
    if iteration <= schedule.densify_last and gradient is not None:
        camera = photo.camera
        state.statistics.add(gradient, rendering.radii_px, camera.width, camera.height)
    adam_step(state.optimizer)
    if settings.daylight.suns == "known":
        suns = [photo.known_sun for photo in sizes.photos]
        state.tied_suns.keep(model.appearance, suns, iteration, schedule.suns_tied_from)
    model.sky.clamp_to_dome()
    model.sky.keep_opaque(settings.sky.least_opacity)
    _change_density(state, schedule, extent)
    _look_around(state, sizes, schedule)
    is_due = state.history.is_due(iteration)
    row = state.history.add(iteration, model, photo, rendering, parts) if is_due else None
    if watched is not None:
        watched.show_if_asked(state, photo, rendering)
    return row


def _change_density(state: TrainingState, schedule: Schedule, extent: float) -> None:
    """Densify and reset opacities if due."""
    iteration, model, settings = state.iteration, state.model, state.settings
    density = settings.density
    if schedule.densifies(iteration):
        gradients = state.statistics.mean()
        grown = densify(
            model,
            state.optimizer,
            gradients,
            density,
            growth=growth_at(iteration, gradients, density, schedule),
            extent=extent,
            prune_huge=schedule.prunes_huge(iteration),
            sky_stays=settings.sky.is_closed,
            generator=state.generator,
        )
        _gaussians_changed(state)
        # Small photos ask for few Gaussians, and even growth always ends at the largest number:
        # neither is a reason to warn.
        is_free = schedule.gaussians_share(iteration) >= 1.0 and density.growth == "threshold"
        watch_counts(state, grown if is_free else UNCAPPED)
    if schedule.resets_opacity(iteration):
        reset_opacity(model, state.optimizer, density.reset_opacity)


def _gaussians_changed(state: TrainingState) -> None:
    """Begin anew what is counted or kept per Gaussian."""
    state.statistics = GradientStatistics.of(state.model)
    state.sun_shadows.forget_reached()


def _look_around(state: TrainingState, sizes: PhotoSizes, schedule: Schedule) -> None:
    """Do what is due at times and looks at the whole scene or at all photos."""
    iteration, model, settings = state.iteration, state.model, state.settings
    if settings.unseen.enabled and schedule.holds_back_unseen(iteration):
        centres = [photo.camera.centre for photo in sizes.given]
        if hold_back_unseen(model, state.optimizer, centres, settings.unseen):
            _gaussians_changed(state)
    if OCCLUSION in model.foreground and schedule.casts_shadows(iteration):
        centres = [photo.camera.centre for photo in sizes.given]
        update_occlusion(model.foreground, centres, settings.occlusion)
    if settings.occluders.enabled and schedule.finds_occluders(iteration):
        state.occluders = find_occluders(model, sizes.given, settings.occluders)
        sizes.leave_out(state.occluders)


def _postfix(row: dict[str, float | int]) -> str:
    return (
        f"loss {row['loss']:.4f}  psnr {row['psnr']:.2f} dB  "
        f"{row['num_foreground']:.0f} foreground + {row['num_sky']:.0f} sky"
    )
