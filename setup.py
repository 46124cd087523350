"""Builds r3gw._C, the C++ extension: every csrc/*.cpp below src/r3gw in one module.

Environment: ``R3GW_PORTABLE=1`` leaves out ``-march=native``, for a build that runs on other
machines (slower); ``R3GW_SANITIZE=1`` adds the address and undefined-behaviour sanitizers.
"""

import os
import runpy
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

from setuptools import setup
from torch.utils.cpp_extension import BuildExtension, CppExtension

compiler = os.environ.get("CXX", "c++").split()[0]
if shutil.which(compiler) is None:
    sys.exit(
        f"r3gw needs a C++20 compiler, and '{compiler}' is not on the PATH: install one "
        "(Debian, Ubuntu: apt-get install g++; conda: conda install gxx) or set CXX."
    )

# Without the debug information that Python's own flags ask for: with it, compiling takes twice as
# long and the extension is fifteen times as large.
flags = ["-O3", "-g0", "-std=c++20", "-fopenmp", "-fno-math-errno", "-fno-trapping-math"]
# Products and sums fuse only where the source says fma, so that results do not depend on which
# expressions a compiler joins. -Wno-psabi: 64-byte vectors are never passed across the library.
flags += ["-ffp-contract=off", "-Wall", "-Wno-psabi"]
link_flags = ["-fopenmp"]
if os.environ.get("R3GW_PORTABLE") != "1":
    flags.append("-march=native")
if os.environ.get("R3GW_SANITIZE") == "1":
    sanitizers = ["-fsanitize=address,undefined", "-fno-omit-frame-pointer", "-g"]
    flags += sanitizers
    link_flags += sanitizers

# A source of its own says what the extension was built from, so that an edit compiles that file and
# the edited ones alone. It is written again only if it changes.
package = Path("src/r3gw")
build = SimpleNamespace(**runpy.run_path(str(package / "native/build.py")))
built = build.BuiltFrom(build.sources_digest(package), build.flags_digest([*flags, *link_flags]))
mark = Path("build/built_from.cpp")
if not mark.is_file() or mark.read_text() != build.mark(built):
    mark.parent.mkdir(exist_ok=True)
    mark.write_text(build.mark(built))

setup(
    ext_modules=[
        CppExtension(
            "r3gw._C",
            [*sorted(str(path) for path in package.glob("**/csrc/*.cpp")), str(mark)],
            include_dirs=[str(Path("src/r3gw").resolve())],
            extra_compile_args=flags,
            extra_link_args=link_flags,
        )
    ],
    cmdclass={"build_ext": BuildExtension},
)
