"""The digest of the code that a stage can reach: modules, their data files, compiled kernels."""

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

import r3gw
from r3gw.files import InputError
from r3gw.files.imports import Imports
from r3gw.native.build import built_from, kernel_sources, sources_digest
from r3gw.native.levels import BUILD, MISSING, built_extensions

# The module whose import loads the kernels.
EXTENSION = "r3gw.native.extension"
CODE = "R3GW_CODE"  # environment: `whole_digest` of the r3gw that runs the workflow
PACKAGE = Path(r3gw.__file__).parent
_NO_DATA = {".py", ".pyc", ".pyi", ".typed", ".so", ".cpp", ".h"}


def code_digest(modules: Iterable[str], imports: Imports) -> str:
    """Digest of everything that ``modules`` can reach by import.

    Counts each module's source, the data files in its folder and, if the extension is reached,
    what that was built from: its sources count only once they are compiled.

    Args:
        modules: Full names, such as ``r3gw.training.run``.
        imports: Who imports what in the package r3gw.

    Raises:
        InputError: If the extension is reached, but is missing or built from other sources than
            those beside it.
    """
    package = imports.package
    reached = imports.reached(modules)
    digest = hashlib.sha256()
    files = {path for name in reached if (path := imports.path(name)) is not None}
    files |= {data for folder in {path.parent for path in files} for data in _data_files(folder)}
    for path in sorted(files):
        digest.update(f"{path.relative_to(package).as_posix()}\n".encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    if EXTENSION in reached:
        digest.update(f"{EXTENSION} {extension_digest(package)}\n".encode())
    return digest.hexdigest()[:16]


def extension_digest(package: Path = PACKAGE) -> str:
    """Digest of the sources and flags that the compiled extension was built from.

    The extensions of a wheel have one digest, so a results folder that moves to a machine of
    another level is not made again.

    Raises:
        InputError: If it is missing, or was built from other sources than those beside it.
    """
    extensions = built_extensions(package)
    if not extensions:
        raise InputError(f"{package}: {MISSING}")
    extension = extensions[0].path
    built = built_from(extension)
    if built is None:
        raise InputError(f"{extension}: does not say which sources it was built from; {BUILD}")
    if kernel_sources(package) and built.sources != sources_digest(package):
        raise InputError(
            f"{extension}: was built from other sources than those beside it, so results would be "
            f"those of old kernels; {BUILD}"
        )
    return f"{built.sources}-{built.flags}"


def whole_digest(package: Path = PACKAGE) -> str:
    """Digest of all modules and data files, and of the sources that the kernels were built from.

    The flags of that build do not count: a package in a container is built for other machines.
    """
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*")):
        inner = path.relative_to(package)
        if path.is_file() and (path.suffix == ".py" or path.suffix not in _NO_DATA):
            if {"csrc", "__pycache__"} & {*inner.parts}:
                continue
            digest.update(f"{inner.as_posix()}\n".encode())
            digest.update(hashlib.sha256(path.read_bytes()).digest())
    for extension in built_extensions(package)[:1]:
        built = built_from(extension.path)
        digest.update((built.sources if built else "").encode())
    return digest.hexdigest()[:16]


def require_same_code(package: Path = PACKAGE) -> None:
    """Refuse to work for a workflow of other code; where none says of which it is, nothing is.

    Raises:
        InputError: If the environment names another digest than this package has.
    """
    expected = os.environ.get(CODE)
    if expected is not None and expected != whole_digest(package):
        raise InputError(
            f"{package}: is not the r3gw of the checkout whose workflow runs, so results would not "
            "be those of its code; build the container again from that checkout"
        )


def require_current_extension(package: Path = PACKAGE) -> None:
    """Refuse to go on with an extension that is out of date; without one, nothing is refused.

    Raises:
        InputError: If the extension was built from other sources than those beside it.
    """
    if built_extensions(package):
        extension_digest(package)


def _data_files(folder: Path) -> Iterable[Path]:
    """Files that the code in a package's folder reads: templates and the like, not sources."""
    for path in folder.iterdir():
        if path.is_dir() and not (path / "__init__.py").is_file():
            if path.name not in {"csrc", "__pycache__"}:
                yield from (each for each in path.rglob("*") if each.is_file())
        elif path.is_file() and path.suffix not in _NO_DATA:
            yield path
