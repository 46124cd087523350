"""Which stages run again after which edit, and what an extension that is out of date stops."""

import re
import subprocess
import sys

import pytest
from support.package_copy import copy_package, edited, pretend_build

from r3gw.files import InputError
from r3gw.native.code import extension_digest, require_current_extension
from r3gw.pipeline.code import StageCode

pytestmark = pytest.mark.slow

USING = {"evaluate", "study", "figures", "report", "doctor"}
DRAWN = USING | {"page"}
STAGES = {"generate", "import", "masks", "initialise", "train", "mask-sheet", "tables"} | DRAWN

# By what is edited: the stages that run again. No other does.
EDITS = {
    "benchmark/buildings/chapel.py": {"generate", "doctor"},
    "benchmark/render.py": {"generate", "doctor"},
    "benchmark/settings.py": {"generate", "import", "doctor"},
    "importing/settings.py": {"import", "doctor"},
    "importing/reconstruction/video.py": {"import", "doctor"},
    "importing/write.py": {"import"},
    "masks/settings.py": {"masks", "doctor"},
    "masks/network.py": {"masks", "doctor"},
    "masks/classical.py": {"masks"},
    "masks/folder.py": {"masks", "initialise", "train", "mask-sheet"} | USING,
    "stereo/sweep.py": {"initialise"},
    "model/stage.py": {"initialise"},
    "model/occlusion.py": {"train", "doctor"},
    "training/loop.py": {"train"},
    "training/losses/ssim.py": {"train"},
    "rendering/compose.py": {"train"} | USING,
    "rendering/cook_torrance.py": {"train"} | DRAWN,
    "raster/reference.py": {"train"} | DRAWN,
    "evaluation/protocols/swept.py": {"evaluate"},
    "evaluation/protocols/facts.py": {"evaluate", "tables", "study", "figures", "report"},
    "evaluation/scoring.py": set(),
    "relight/cameras.py": {"page"},
    "relight/film.py": set(),
    "relight/files/gltf.py": set(),
    "view/payload.py": {"page"},
    "view/bundle/page.js": {"page"},
    "view/server.py": set(),
    "reporting/tables/study.py": {"study", "figures", "report"},
    "reporting/figures/grids.py": {"study", "figures"},
    "reporting/figures/mask_sheet.py": {"mask-sheet", "figures", "study"},
    "reporting/page/templates/report.css": {"report"},
    "reporting/page/scene_page.py": {"report"},
    "pipeline/config.py": {"doctor"},
    "pipeline/study.py": {"doctor"},
    "pipeline/doctor/cost.py": {"doctor"},
    "pipeline/code.py": set(),
    "lighting/daylight.py": {"generate", "tables"} | DRAWN,
    "files/atomic.py": STAGES,
    "cli/use.py": set(),
    "cli/sections.py": set(),
    "layers.py": set(),
}


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    return copy_package(tmp_path_factory.mktemp("package"))


def digests(package):
    code = StageCode(package)
    return {stage: code.digest(stage) for stage in STAGES}


@pytest.fixture(scope="module")
def before(package):
    return digests(package)


def changed(package, before):
    after = digests(package)
    return {stage for stage in STAGES if after[stage] != before[stage]}


def test_these_are_the_stages_of_the_workflow(repository):
    rules = "".join(path.read_text() for path in (repository / "workflow/rules").glob("*.smk"))
    assert set(re.findall(r'code_of\("([^"]+)"\)', rules)) == STAGES


def test_nothing_changes_without_an_edit(package, before):
    assert changed(package, before) == set()


@pytest.mark.parametrize("path", EDITS)
def test_an_edit_concerns_these_stages_alone(package, before, path):
    with edited(package / path):
        assert changed(package, before) == EDITS[path]


def test_kernels_count_once_they_are_built(package, before):
    kernel = package / "raster/csrc/projection.cpp"
    with edited(kernel):
        with pytest.raises(InputError, match=r"_C.*other sources than those beside it.*`make`"):
            StageCode(package).digest("train")
        pretend_build(package)
        assert changed(package, before) == {"train"} | DRAWN
    pretend_build(package)
    assert changed(package, before) == set()


def test_a_command_counts_its_own_function_and_no_other(package, before):
    path = package / "cli/runs.py"
    text = path.read_text()
    path.write_text(text.replace("evaluate_run(scene,", "evaluate_run( scene,"))
    try:
        assert changed(package, before) == {"evaluate"}
    finally:
        path.write_text(text)


def test_every_command_names_its_modules(package):
    code = StageCode(package)
    assert "r3gw.training.run" in code.modules("train")
    assert "r3gw.native.extension" in code.modules("train")
    assert "r3gw.native.extension" not in code.modules("import")
    assert "r3gw.pipeline.doctor.source" in code.modules("doctor-sources")


@pytest.mark.parametrize(
    ("stage", "module"),
    [
        ("generate", "r3gw.benchmark.generate"),
        ("import", "r3gw.importing.stage"),
        ("masks", "r3gw.masks.stage"),
        ("initialise", "r3gw.model.stage"),
        ("train", "r3gw.training.run"),
        ("evaluate", "r3gw.evaluation.stage"),
        ("tables", "r3gw.reporting.tables.table1"),
        ("page", "r3gw.view.page"),
        ("report", "r3gw.reporting.page.stage"),
    ],
)
def test_what_python_loads_is_in_the_closure(package, stage, module):
    """Python's own list of loaded modules, against the list read from the sources."""
    program = f"import sys, {module}; print(*(n for n in sys.modules if n.split('.')[0] == 'r3gw'))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    loaded = set(done.stdout.split())
    assert module in loaded
    assert loaded - StageCode(package).modules(stage) == set()


@pytest.mark.parametrize(
    "module", ["r3gw.masks.stage", "r3gw.reporting.tables.stage", "r3gw.pipeline.doctor.training"]
)
def test_stages_without_tensors_start_without_torch(module):
    """It takes a second to load, more than these stages work."""
    program = f"import sys, {module}; print('torch' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"


def test_an_extension_of_unknown_sources_is_refused(tmp_path):
    copy = copy_package(tmp_path)
    (extension,) = copy.glob("_C*")
    extension.write_bytes(b"\x7fELF nothing said")
    with pytest.raises(InputError, match="does not say which sources"):
        extension_digest(copy)
    extension.unlink()
    with pytest.raises(InputError, match=r"extension r3gw\._C is missing"):
        extension_digest(copy)
    require_current_extension(copy)  # what needs no kernel goes on


def test_installed_kernels_need_no_sources_beside_them(tmp_path):
    copy = copy_package(tmp_path)
    expected = extension_digest(copy)
    for path in copy.rglob("csrc/*"):
        path.unlink()
    assert extension_digest(copy) == expected


def test_the_command_line_refuses_old_kernels(tmp_path):
    copy = copy_package(tmp_path)
    with edited(copy / "native/csrc/rows.h"):
        done = subprocess.run(
            [sys.executable, "-m", "r3gw", "train", "--help"],
            capture_output=True, text=True, check=False, cwd=tmp_path,
            env={"PYTHONPATH": str(tmp_path), "PATH": ""},
        )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.startswith("r3gw: ")
    assert "was built from other sources than those beside it" in done.stderr
    assert "Traceback" not in done.stderr
