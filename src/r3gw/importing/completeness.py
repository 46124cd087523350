"""Is a dataset complete? Its reader looks at names only, so this runs before anything else does."""

from collections.abc import Collection
from pathlib import Path

from r3gw.files import InputError
from r3gw.importing.formats import reader_of
from r3gw.importing.named_files import listed
from r3gw.importing.settings import SceneSettings

_MOST = 20  # names in one sentence


def missing_files(settings: SceneSettings, source: Path, given: Collection[str] = ()) -> list[str]:
    """Names of the files that a scene needs and ``source`` does not hold, in a fixed order.

    Args:
        settings: What the scene's entry in the configuration says about its source.
        source: Folder (or video) of the scene.
        given: Kinds of masks that every photo of the NeRF-OSR layout must come with; the mask
            stage makes the others if they are missing.

    Raises:
        InputError: If a list that names the files is itself unreadable.
    """
    return reader_of(settings, source).missing(given) if source.exists() else [str(source)]


def require_complete(
    name: str, settings: SceneSettings, source: Path, given: Collection[str] = ()
) -> None:
    """Refuse a scene that lacks files (`missing_files`).

    Raises:
        InputError: Naming the missing files.
    """
    if missing := missing_files(settings, source, given):
        if missing == [str(source)]:
            raise InputError(f"{source}: no such file or folder; correct 'path' of scene '{name}'")
        files = f"{len(missing)} files are" if len(missing) > 1 else "one file is"
        raise InputError(
            f"{source}: {files} missing for scene '{name}' ({listed(missing, _MOST)}); put them "
            "in place (docs/scenes.md tells where data comes from)"
        )
