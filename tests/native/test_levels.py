"""Of several compiled extensions, a process takes the best that its processor can run."""

import os
import platform
import re
import subprocess
import sys
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest

from r3gw.files import InputError
from r3gw.native.extension import LEVEL, chosen_extension
from r3gw.native.levels import (
    NEEDS,
    best_extension,
    built_extensions,
    module_name,
    portable_levels,
    processor_features,
)

X86 = ("v4", "v3", "v2")


def package_with(folder, *levels):
    """A package of nothing but files where the extensions of some levels would be."""
    for level in levels:
        (folder / f"{module_name(level)}{EXTENSION_SUFFIXES[0]}").write_bytes(b"")
    return folder


def supported_by_the_dynamic_linker():
    """The levels that glibc finds on this machine, which asks the processor itself."""
    done = subprocess.run(
        ["/lib64/ld-linux-x86-64.so.2", "--help"], capture_output=True, text=True, check=True
    )
    return {f"v{number}" for number in re.findall(r"x86-64-v(\d) \(supported", done.stdout)}


@pytest.mark.skipif(
    platform.machine() != "x86_64" or platform.libc_ver() < ("glibc", "2.33"),
    reason="glibc tells the level from 2.33 on, and on x86-64 alone",
)
def test_the_levels_of_this_processor_are_those_that_glibc_finds():
    features = processor_features()
    assert {level for level in X86 if NEEDS[level] <= features} == supported_by_the_dynamic_linker()


@pytest.mark.parametrize(
    ("lacking", "expected"),
    [
        ((), "v4"), (("avx512vl",), "v3"), (("avx512f", "avx512dq"), "v3"), (("fma",), "v2"),
        (("avx2", "avx512f"), "v2"), (("ssse3",), None),
    ],
)  # fmt: skip
def test_the_best_level_that_the_processor_has_is_taken(tmp_path, lacking, expected):
    extensions = built_extensions(package_with(tmp_path, *X86))
    chosen = best_extension(extensions, NEEDS["v4"] - {*lacking})
    assert (chosen and chosen.level) == expected


def test_what_was_compiled_here_goes_first_and_any_processor_takes_the_generic_one(tmp_path):
    extensions = built_extensions(package_with(tmp_path, "generic", "v2", "native", "v4"))
    assert [each.level for each in extensions] == ["native", "v4", "v2", "generic"]
    assert best_extension(extensions, ()) == extensions[0]
    assert best_extension(extensions[1:], ()) == extensions[-1]


def test_features_are_those_of_the_first_processor(tmp_path):
    cpuinfo = tmp_path / "cpuinfo"
    cpuinfo.write_text("processor\t: 0\nflags\t\t: fpu avx2 fma\nbugs\t: none\nflags\t: other\n")
    assert processor_features(cpuinfo) == {"fpu", "avx2", "fma"}
    cpuinfo.write_text("processor\t: 0\nFeatures\t: fp asimd\n")  # as on aarch64
    assert processor_features(cpuinfo) == frozenset()
    assert processor_features(tmp_path / "none") == frozenset()


def test_the_environment_chooses_among_the_levels(tmp_path, monkeypatch):
    package = package_with(tmp_path, "generic", "native")
    monkeypatch.setenv("R3GW_KERNELS", "v2 generic")
    assert chosen_extension(package).level == "generic"
    monkeypatch.setenv("R3GW_KERNELS", "")
    assert chosen_extension(package).level == "native"
    monkeypatch.setenv("R3GW_KERNELS", "v2")
    with pytest.raises(InputError, match=r"native, generic, of which .* R3GW_KERNELS \(v2\)"):
        chosen_extension(package)


def test_a_package_without_an_extension_says_how_to_build_one(tmp_path):
    with pytest.raises(InputError, match=r"r3gw\._C is missing; build it again: `make`"):
        chosen_extension(tmp_path)


def test_this_process_runs_the_level_that_it_says():
    """The file of that level is the one that is mapped into this process, and no other."""
    maps = Path("/proc/self/maps").read_text()
    mapped = set(re.findall(r"/r3gw/(_C[^/]*)\.(?:cpython|abi3)", maps))
    assert mapped == {module_name(LEVEL)}


def test_a_wheel_runs_on_every_machine_of_its_architecture():
    assert NEEDS[portable_levels()[-1]] <= NEEDS["v2"]


@pytest.mark.slow
@pytest.mark.parametrize("asked", ["v9", "native v9"])
def test_levels_that_there_are_not_are_not_built(repository, asked):
    asking = os.environ | {"R3GW_KERNELS": asked, "CXX": "true"}  # needs no compiler
    done = subprocess.run(
        [sys.executable, "setup.py", "-q", "build_ext"], cwd=repository,
        env=asking, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert "no level 'v9'; there are native, v4, v3, v2, generic" in done.stderr
