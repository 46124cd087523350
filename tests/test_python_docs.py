"""docs/python.md: its examples run, in order, on a small trained scene, and their types hold."""

import re
import subprocess
import sys
from pathlib import Path
from shutil import copytree

import pytest

from r3gw.imaging.files import write_exr


@pytest.fixture(scope="module")
def examples(repository) -> str:
    """All Python blocks of the page as one program."""
    page = (repository / "docs" / "python.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    assert len(blocks) > 8
    return "\n".join(blocks)


CHECKS = """
from pathlib import Path
for picture_ in (picture, relit, exposed, white, half_way, mixed, grey, day, same, radiance):
    assert picture_.shape == (32, 48, 3), picture_.shape
    assert picture_.std() > 0.01
assert large.shape == (64, 96, 3) and elsewhere.shape == (480, 640, 3)
assert (same == picture).all()
assert sorted(path.name for path in Path("exported").iterdir()) == [
    "baked.glb", "baked.ply", "lights.json", "relightable.ply"
]
assert cv2.imread("photo.png").shape == (32, 48, 3)
assert colour.shape == (48, 64, 3) and alpha.max() > 0.8
"""


@pytest.mark.slow
def test_examples_run(tiny, tmp_path, examples):
    copytree(tiny.folder, tmp_path / "results/chapel/scene", ignore=lambda *_: {"run"})
    copytree(tiny.model_path.parent, tmp_path / "results/chapel/full/seed0")
    write_exr(tmp_path / "sunset.exr", tiny.env_map.numpy())
    done = run_python(examples + CHECKS, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "scene 'tiny' has no view 'no_such_photo'; it has: a_0" in done.stdout
    assert re.search(r"^\d+\.\d\d dB, SSIM 0\.\d{3}$", done.stdout, re.MULTILINE)


@pytest.mark.slow
def test_examples_are_typed(tmp_path, repository, examples):
    (tmp_path / "examples.py").write_text(examples)
    command = [sys.executable, "-m", "mypy", "--config-file", str(repository / "pyproject.toml")]
    command += ["--strict", str(tmp_path / "examples.py")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=repository)
    assert done.returncode == 0, done.stdout + done.stderr


def run_python(program: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a program in a fresh interpreter, as a user would."""
    command = [sys.executable, "-c", program]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)


FORBIDDEN = (
    *("snakemake", "mitsuba", "pycolmap", "pandas", "matplotlib", "jinja2", "pygments"),
    *("tabulate", "imageio_ffmpeg", "onnx"),
)


@pytest.mark.slow
def test_one_picture_needs_the_base_installation_alone(tiny, tmp_path):
    """Load, render and export with an import system that knows no library of an extra."""
    program = f"""
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {FORBIDDEN!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Absent())
import r3gw
scene = r3gw.load({str(tiny.model_path)!r}, {str(tiny.folder)!r})
assert scene.render("b_exact", "a_0").shape == (32, 48, 3)
r3gw.export(scene, "exported", scene.lights["a_0"])
assert r3gw.load("exported/relightable.ply").lights
options = ["--model", {str(tiny.model_path)!r}, "--scene", {str(tiny.folder)!r}]
options += ["--view", "a_0", "--light-of", "a_1", "--output"]
from r3gw.cli.use import relight
relight([*options, "relit.png"], standalone_mode=False)
try:
    relight([*options, "film.mp4"], standalone_mode=False)
except r3gw.InputError as error:
    print(error)
try:
    r3gw.Light.sun(45, 150)
except r3gw.InputError as error:
    print(error)
"""
    done = run_python(program, tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "".join(
        f"this needs the Python library {name}, which is not installed: pip install 'r3gw[view]'\n"
        for name in ("imageio_ffmpeg", "mitsuba")
    )
    assert (tmp_path / "relit.png").is_file()
    assert not (tmp_path / "film.mp4").exists()


def test_importing_r3gw_imports_no_library():
    program = (
        "import sys, r3gw; print(sorted({'torch', 'numpy', 'scipy', 'click'} & {*sys.modules}))"
    )
    done = run_python(program, Path.cwd())
    assert done.stdout.strip() == "[]"
