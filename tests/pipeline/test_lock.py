"""A lock whose owner is gone is taken away; one whose owner lives stays."""

import os
import signal
import subprocess
import sys
import time

import pytest

from r3gw.files.processes import OWNER, RECORD, identity, is_alive
from r3gw.pipeline.lock import claim

CLAIM = "import sys; from pathlib import Path; from r3gw.pipeline.lock import claim; "
CLAIM += "claim(Path(sys.argv[1])); print('claimed', flush=True); import time; time.sleep(300)"


@pytest.fixture
def locked(tmp_path):
    """A folder with a lock, and the living process that claimed it."""
    owner = subprocess.Popen(
        [sys.executable, "-c", CLAIM, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    assert owner.stdout is not None
    assert owner.stdout.readline() == "claimed\n"
    (tmp_path / ".snakemake/locks").mkdir()
    (tmp_path / ".snakemake/locks/0.output.lock").write_text("results/table1.csv\n")
    yield tmp_path, owner
    owner.kill()
    owner.wait()
    owner.stdout.close()


def locks(folder):
    return list(folder.glob(".snakemake/locks/*"))


def test_a_lock_of_the_living_is_respected(locked):
    folder, _ = locked
    claim(folder)
    assert len(locks(folder)) == 1


@pytest.mark.parametrize("is_reaped", [True, False])
def test_a_lock_of_the_dead_is_taken_away(locked, is_reaped):
    folder, owner = locked
    owner.send_signal(signal.SIGKILL)
    if is_reaped:
        owner.wait()
    else:
        os.waitid(os.P_PID, owner.pid, os.WEXITED | os.WNOWAIT)
    claim(folder)
    assert locks(folder) == []


def test_one_that_got_the_number_of_the_dead_does_not_count(locked):
    folder, _ = locked
    (record,) = (folder / ".snakemake/owners").iterdir()
    name = record.read_text()
    record.write_text(name.rpartition("|")[0] + "|12")
    claim(folder)
    assert locks(folder) == []


def test_a_lock_of_another_host_or_of_nobody_is_respected(locked):
    folder, owner = locked
    (record,) = (folder / ".snakemake/owners").iterdir()
    record.write_text("elsewhere|" + record.read_text().partition("|")[2])
    owner.kill()
    owner.wait()
    claim(folder)
    assert len(locks(folder)) == 1
    for path in (folder / ".snakemake/owners").iterdir():
        path.unlink()
    claim(folder)
    assert len(locks(folder)) == 1


def test_a_process_is_named_for_good():
    own = identity(os.getpid())
    assert own is not None
    assert is_alive(own)
    assert not is_alive(own + "0")
    host, _, rest = own.split("|", 2)
    assert not is_alive(f"{host}|another boot|{rest}")
    assert identity(2**22 + 1) is None


WATCH = "from r3gw.files.processes import {0}; {0}(); import time; print('up', flush=True); "
WATCH += "time.sleep(300)"


@pytest.mark.slow
def test_a_stage_on_another_host_ends_when_the_record_of_its_owner_goes(tmp_path):
    elsewhere, record = "login|its boot|12|345", tmp_path / "login.12"
    record.write_text(elsewhere)
    known = os.environ | {OWNER: elsewhere, RECORD: str(record)}
    unseen = known | {RECORD: str(tmp_path / "not/here")}
    line = [sys.executable, "-c", WATCH.format("end_with_owner")]
    stages = [
        subprocess.Popen(line, stdout=subprocess.PIPE, text=True, env=environment)
        for environment in (known, unseen)
    ]
    for stage in stages:
        assert stage.stdout is not None
        assert stage.stdout.readline() == "up\n"
    with pytest.raises(subprocess.TimeoutExpired):
        stages[0].wait(2.5)
    record.write_text("login|its boot|12|678")  # another process of that number
    assert stages[0].wait(30) == 143
    assert stages[1].poll() is None
    stages[1].kill()
    stages[1].wait()
    for stage in stages:
        assert stage.stdout is not None
        stage.stdout.close()


@pytest.mark.slow
@pytest.mark.parametrize("which", ["end_with_owner", "end_with_parent"])
def test_a_stage_ends_with_its_parent(which):
    """The parent is a shell that is killed, as by kill -9 of a run."""
    program = WATCH.format(which)
    shell = f'{sys.executable} -c "{program}" & echo $!; wait'
    own = identity(os.getpid())
    parent = subprocess.Popen(
        ["bash", "-c", shell], stdout=subprocess.PIPE, text=True, env=os.environ | {OWNER: own}
    )
    assert parent.stdout is not None
    stage = identity(int(parent.stdout.readline()))
    assert parent.stdout.readline() == "up\n"
    assert stage is not None
    parent.kill()
    parent.wait()
    deadline = time.monotonic() + 30
    while is_alive(stage) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_alive(stage)
    parent.stdout.close()
