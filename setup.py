"""Builds the C++ extensions: every csrc/*.cpp below src/r3gw in one module, or in one per level.

In a checkout (``build_ext --inplace``, ``pip install --editable``) there is one module, for the
machine that compiles it. A wheel gets the levels that together run on every machine of this
architecture (`r3gw.native.levels`); r3gw takes the best one that its processor can run.

Environment: ``R3GW_KERNELS`` names the levels to build instead, such as ``native`` or ``v2 v3``;
``R3GW_SANITIZE=1`` adds the address and undefined-behaviour sanitizers.
"""

import os
import runpy
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

from setuptools import Extension, setup
from torch.utils.cpp_extension import BuildExtension, CppExtension

compiler = os.environ.get("CXX", "c++").split()[0]
if shutil.which(compiler) is None:
    sys.exit(
        f"r3gw needs a C++20 compiler, and '{compiler}' is not on the PATH: install one "
        "(Debian, Ubuntu: apt-get install g++; conda: conda install gxx) or set CXX."
    )

# Without the debug information that Python's own flags ask for: with it, compiling takes twice as
# long and the extension is fifteen times as large.
FLAGS = ["-O3", "-g0", "-std=c++20", "-fopenmp", "-fno-math-errno", "-fno-trapping-math"]
# Products and sums fuse only where the source says fma, so that results do not depend on which
# expressions a compiler joins. -Wno-psabi: 64-byte vectors are never passed across the library.
FLAGS += ["-ffp-contract=off", "-Wall", "-Wno-psabi"]
LINK_FLAGS = ["-fopenmp"]
SANITIZERS: list[str] = []
if os.environ.get("R3GW_SANITIZE") == "1":
    SANITIZERS = ["-fsanitize=address,undefined", "-fno-omit-frame-pointer", "-g"]

PACKAGE = Path("src/r3gw")
MARK = Path("build/built_from.cpp")
build = SimpleNamespace(**runpy.run_path(str(PACKAGE / "native/build.py")))
levels = SimpleNamespace(**runpy.run_path(str(PACKAGE / "native/levels.py")))


def write_mark(chosen: tuple[str, ...]) -> None:
    """Write a source that says what the extensions are built from, the same for all of a build.

    It is a file of its own, and written again only if it changes, so that an edit compiles it and
    the edited ones alone.
    """
    machines = [flag for level in chosen for flag in levels.machine_flag(level)]
    flags = build.flags_digest([*FLAGS, *machines, *SANITIZERS, *LINK_FLAGS, *SANITIZERS])
    built = build.BuiltFrom(build.sources_digest(PACKAGE), flags)
    if not MARK.is_file() or MARK.read_text() != build.mark(built):
        MARK.parent.mkdir(exist_ok=True)
        MARK.write_text(build.mark(built))


def extension(level: str) -> Extension:
    """The extension of one level; any Python loads it, because it uses nothing of Python's."""
    return CppExtension(
        f"r3gw.{levels.module_name(level)}",
        sorted(str(path) for path in PACKAGE.glob("**/csrc/*.cpp")),
        include_dirs=[str(PACKAGE.resolve())],
        extra_compile_args=[*FLAGS, *levels.machine_flag(level), *SANITIZERS],
        extra_link_args=[*LINK_FLAGS, *SANITIZERS],
        py_limited_api=True,
    )


class BuildLevels(BuildExtension):
    """Builds the levels that are asked for, each with object files of its own."""

    def finalize_options(self) -> None:
        """Decide what to build: an installation in place is used where it is compiled."""
        in_place = self.inplace or getattr(self, "editable_mode", False)
        asked = tuple(os.environ.get("R3GW_KERNELS", "").split())
        chosen = asked or (("native",) if in_place else levels.portable_levels())
        if unknown := [level for level in chosen if level not in levels.NEEDS]:
            sys.exit(f"R3GW_KERNELS: no level '{unknown[0]}'; there are {', '.join(levels.NEEDS)}")
        self.chosen = chosen
        self.distribution.ext_modules = [extension(level) for level in chosen]
        super().finalize_options()

    def run(self) -> None:
        """Build all of them."""
        write_mark(self.chosen)
        super().run()

    def build_extension(self, ext: Extension) -> None:
        """Compile one extension in a folder of its own."""
        folder, sources = self.build_temp, ext.sources
        self.build_temp, ext.sources = str(Path(folder) / ext.name), [*sources, str(MARK)]
        super().build_extension(ext)
        # A source distribution lists the sources, of which the mark is none.
        self.build_temp, ext.sources = folder, sources

    def copy_extensions_to_source(self) -> None:
        """Put the extensions beside their sources, and take away what an earlier build left."""
        for old in PACKAGE.glob("_C*.so"):
            old.unlink()
        super().copy_extensions_to_source()


setup(
    # Which ones there are is decided when they are built.
    ext_modules=[Extension("r3gw._C", [])],
    cmdclass={"build_ext": BuildLevels},
    options={"bdist_wheel": {"py_limited_api": "cp311"}},
)
