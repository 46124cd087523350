"""Names of files that stand inside files, which may come from strangers: none may lead elsewhere.

A name from a file is a path below that file's own folder. Absolute paths, ``..`` and drive letters
are refused, so that nobody's scene reads or overwrites what lies outside of it. Links that lie in a
folder are followed: whoever put them there meant it. Only transforms.json may state absolute paths,
since instant-ngp and nerfstudio write them: of its author's own files (`stated`).
"""

from pathlib import Path, PurePosixPath, PureWindowsPath

from r3gw.files.errors import InputError

_LONGEST_PART, _LONGEST_PATH = 255, 3000  # bytes


def leads_outside(name: str) -> bool:
    """Whether a name is none, absolute, or climbs above the folder that it is relative to."""
    path = PurePosixPath(name.replace("\\", "/"))
    depth = 0
    for part in path.parts:
        depth += -1 if part == ".." else 1
        if depth < 0:
            return True
    is_rooted = path.is_absolute() or bool(PureWindowsPath(name).drive)
    return is_rooted or depth == 0 or _is_impossible(name)


def inside(folder: Path, name: str, source: str) -> Path:
    """The file that ``name`` means in ``folder``.

    Args:
        folder: What the name is relative to.
        name: As a file says it.
        source: That file, for the error.

    Raises:
        InputError: If the name leads out of the folder.
    """
    if leads_outside(name):
        raise InputError(
            f"{source}: names the file {name[:200]!r}, which is not below {folder}; put the file "
            "there, or a link to it, and correct the name"
        )
    return folder / name


def stated(folder: Path, name: str, source: str) -> Path:
    """As `inside`, but absolute paths are allowed; the file need not exist.

    Of an absolute path, the longest tail that exists in ``folder`` is taken first: the folder may
    have been moved here from another machine.

    Raises:
        InputError: If a relative name leads out of the folder.
    """
    path = PurePosixPath(name.replace("\\", "/"))
    windows = PureWindowsPath(name)
    if not (path.is_absolute() or windows.drive) or _is_impossible(name):
        return inside(folder, str(path), source)
    parts = (windows if windows.drive else path).parts[1:]
    tails = (folder.joinpath(*parts[start:]) for start in range(len(parts)) if ".." not in parts)
    return next((tail for tail in tails if tail.is_file()), Path(path))


def _is_impossible(name: str) -> bool:
    """Whether no file system could hold a file of this name."""
    try:
        sizes = [len(part.encode()) for part in name.split("/")]
    except UnicodeEncodeError:
        return True
    return "\0" in name or max(sizes) > _LONGEST_PART or sum(sizes) > _LONGEST_PATH
