"""Which photos are held out of training, where a source does not say so itself.

Structure from motion and triangulation see all photos, as in the protocols of phototourism: what is
held out is the photos' pixels, from training.
"""

from dataclasses import replace
from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.folders import LEAST_TRAINING_VIEWS
from r3gw.importing.named_files import listed
from r3gw.importing.settings import SceneSettings, UnsplitScene
from r3gw.importing.source import SourceScene
from r3gw.scene.names import ByPhoto


def with_held_out(found: SourceScene, settings: SceneSettings, source: Path) -> SourceScene:
    """The scene with the photos held out that its entry asks for (``hold_out``), and a note of it.

    Args:
        found: What a reader found, its views in the order in which photos are counted.
        settings: The scene's entry.
        source: The dataset, for errors.

    Raises:
        InputError: If the source has a split of its own, a name is none of its photos, or fewer
            than two photos would be left to train on.
    """
    if not isinstance(settings, UnsplitScene) or settings.hold_out is None:
        return found
    if any(view.split == "test" for view in found.views):
        raise InputError(
            f"{source}: has a split of its own, so 'hold_out' cannot choose another; take one of "
            "the two away"
        )
    paths = [view.path for view in found.views]
    if isinstance(settings.hold_out, int):
        chosen = set(every(settings.hold_out, paths))
        if not chosen:
            note = (
                f"no photo is held out to be scored: 'hold_out: {settings.hold_out}' takes one of "
                f"every {settings.hold_out}, and there are {len(paths)}"
            )
            return replace(found, notes=(*found.notes, note))
    else:
        chosen = _named(settings.hold_out, paths, source)
    if len(paths) - len(chosen) < LEAST_TRAINING_VIEWS:
        raise InputError(
            f"{source}: 'hold_out' leaves {len(paths) - len(chosen)} of {len(paths)} photos to "
            f"train on, but a scene needs {LEAST_TRAINING_VIEWS} or more; hold fewer out"
        )
    views = tuple(
        replace(view, split="test") if view.path in chosen else view for view in found.views
    )
    count = f"{len(chosen)} of {len(paths)} photos"
    note = f"{count} held out of training, to be scored: {listed(chosen)}"
    return replace(found, views=views, notes=(*found.notes, note))


def every(step: int, paths: list[str]) -> list[str]:
    """One of every ``step`` photos, from the middle of each stretch; none of fewer than ``step``.

    The first and the last photo of a walk see what no other photo sees, so they are not taken.
    """
    return paths[step // 2 :: step] if len(paths) >= step else []


def _named(names: list[str], paths: list[str], source: Path) -> set[str]:
    """The photos that names mean, with or without folder and suffix."""
    wanted = ByPhoto({name: name for name in names}, paths, f"{source}: hold_out")
    if wanted.unused:
        raise InputError(
            f"{source}: 'hold_out' names {listed(wanted.unused)}, which is no photo of the scene; "
            "correct the name, or take it out if the photo could not be registered"
        )
    return {path for path in paths if path in wanted}
