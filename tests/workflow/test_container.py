"""Stages run in a container if one is named, with its own r3gw, which must be this checkout's."""

import os
import shutil
import sys
from pathlib import Path

import pytest
import yaml
from support.tiny_workflow import CONFIG, snakemake

pytestmark = pytest.mark.slow

# Does what Apptainer does as far as a stage can tell: an environment with the image's own Python on
# the PATH. What follows the image is the command.
APPTAINER = """\
#!/bin/bash
if [ "$1" = --version ]; then echo apptainer version 1.3.6; exit; fi
echo "$@" >> {folder}/calls
while [ "$1" != image.sif ]; do shift; done
shift
export APPTAINER_CONTAINER=image.sif PATH={folder}/bin:/usr/bin:/bin
exec "$@"
"""
PYTHON = '#!/bin/bash\nexport PYTHONPATH={folder}/image/src\nexec {python} "$@"\n'


@pytest.fixture
def host(untouched, tmp_path, monkeypatch) -> Path:
    """A machine with a stand-in for Apptainer, whose image holds a copy of the package."""
    folder = tmp_path / "host"
    shutil.copytree(untouched / "src", folder / "image/src", symlinks=True)
    (folder / "bin").mkdir()
    programs = {"apptainer": APPTAINER, "python": PYTHON}
    for name, text in programs.items():
        (folder / "bin" / name).write_text(text.format(folder=folder, python=sys.executable))
        (folder / "bin" / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}/bin:{os.environ['PATH']}")
    monkeypatch.setenv("R3GW_CONTAINER", "image.sif")
    (untouched / "image.sif").touch()
    (untouched / "mine.yaml").write_text(yaml.safe_dump(CONFIG))
    return folder


def test_stages_run_in_the_container_and_other_code_is_refused(host, untouched):
    in_container = ("results/tiny/source", "--software-deployment-method", "apptainer")
    done = snakemake(untouched, *in_container)
    assert done.returncode == 0, done.stderr
    (call,) = (host / "calls").read_text().splitlines()
    assert "image.sif bash -c" in call
    assert "python -m r3gw generate" in call
    (host / "image/src/r3gw/scene/__init__.py").write_text("# another version\n")
    shutil.rmtree(untouched / "results")
    done = snakemake(untouched, *in_container)
    assert done.returncode != 0
    log = (untouched / "logs/generate/tiny.log").read_text()
    assert "is not the r3gw of the checkout whose workflow runs" in log
    assert "Traceback" not in log
