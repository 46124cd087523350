"""A Slurm of two nodes on this machine, from Debian's packages; for tests, as root.

    apt-get install slurmctld slurmd slurm-client munge
    python tests/cluster/slurm.py start FOLDER   # then: export SLURM_CONF=FOLDER/slurm.conf
    python tests/cluster/slurm.py stop FOLDER

Everything that belongs to it lies in the folder, and nothing of an installed Slurm is touched. Its
nodes claim more cores than there may be, since tests ask whether jobs run, not how fast. Where the
memory cgroup (version 1) can be written, Slurm ends a job beyond its memory by it, as most clusters
do; elsewhere Slurm looks at the memory of its jobs once a second.
"""

import os
import secrets
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType

NODES = ("n1", "n2")
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "srun")
_PATH = f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"
_NODE = "R3GW_TEST_NODE"  # environment of a node's daemon: its name
_CGROUP = Path("/sys/fs/cgroup/memory")
_CGROUP_CONF = """\
CgroupAutomount=no
CgroupPlugin=cgroup/v1
ConstrainRAMSpace=yes
"""
_SLURM_CONF = """\
ClusterName=r3gw
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=16817
AuthType=auth/munge
AuthInfo=socket={folder}/munge.sock
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool.%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.%n.log
SlurmdParameters=config_overrides
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
KillWait=2
{memory}
NodeName=n[1-2] NodeHostname={host} NodeAddr=127.0.0.1 Port=[16818-16819] CPUs=4 RealMemory=6000
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class Cluster:
    """A Slurm whose files lie in one folder."""

    def __init__(self, folder: Path) -> None:
        """Name the folder, which need not exist yet."""
        self.folder = folder.resolve()
        self.environment = os.environ | {
            "SLURM_CONF": str(self.folder / "slurm.conf"),
            "PATH": f"{self.folder}/bin:{_PATH}",
        }

    def start(self) -> None:
        """Write the configuration, start all daemons, wait until both nodes are idle."""
        self.folder.mkdir(parents=True)
        (self.folder / "state").mkdir()
        memory = "ProctrackType=proctrack/linuxproc\nJobAcctGatherParams=OverMemoryKill"
        if _cgroup_is_writable():
            memory = "ProctrackType=proctrack/cgroup\nTaskPlugin=task/cgroup"
            (self.folder / "cgroup.conf").write_text(_CGROUP_CONF)
        text = _SLURM_CONF.format(folder=self.folder, host=os.uname().nodename, memory=memory)
        (self.folder / "slurm.conf").write_text(text)
        self._wrap_srun()
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(1024))
        key.chmod(0o400)
        files = ("socket=munge.sock", "pid-file=munged.pid", "log-file=munged.log")
        names = [f"--{name.replace('=', f'={self.folder}/')}" for name in files]
        self.call("munged", "--force", f"--key-file={key}", *names, f"--seed-file={key}.seed")
        self.call("slurmctld", "-c")
        for node in NODES:
            self.start_node(node)
        self.wait_for_nodes()

    def start_node(self, node: str) -> None:
        """Start the daemon of a node."""
        (self.folder / f"spool.{node}").mkdir(exist_ok=True)
        self.call("slurmd", "-N", node, more={_NODE: node})

    def wait_for_nodes(self, seconds: float = 60.0) -> None:
        """Wait until no node is down."""
        deadline = time.monotonic() + seconds
        while (states := set(self.call("sinfo", "-hN", "-o", "%T").split())) - {"idle", "mixed"}:
            if time.monotonic() > deadline:
                raise TimeoutError(f"{self.folder}: nodes are {states} after {seconds:.0f} s")
            time.sleep(0.5)

    def kill_node(self, node: str) -> None:
        """What a power cut does: SIGKILL to the daemon of a node and to all that it started."""
        for pid in self._processes_of(node):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)

    def stop(self) -> None:
        """End all jobs and daemons."""
        subprocess.run(["scancel", "--user=root"], env=self.environment, check=False)
        for name in (*(f"slurmd.{node}.pid" for node in NODES), "slurmctld.pid", "munged.pid"):
            path = self.folder / name
            if path.is_file():
                with suppress(ProcessLookupError):
                    os.kill(int(path.read_text()), signal.SIGTERM)

    def call(
        self, program: str, *arguments: str, more: Mapping[str, str] = MappingProxyType({})
    ) -> str:
        """Run a program of Slurm's, ``more`` in its environment; returns what it prints."""
        line = (program, *arguments)
        environment = self.environment | dict(more)
        done = subprocess.run(line, env=environment, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(line)} failed: {done.stderr or done.stdout}")
        return done.stdout

    def _wrap_srun(self) -> None:
        """Snakemake's job steps take SLURM_CONF out of the environment of srun."""
        wrapper = self.folder / "bin/srun"
        wrapper.parent.mkdir()
        srun = shutil.which("srun", path=_PATH)
        conf = self.environment["SLURM_CONF"]
        wrapper.write_text(f"#!/bin/sh\nSLURM_CONF='{conf}' exec {srun} \"$@\"\n")
        wrapper.chmod(0o755)

    def _processes_of(self, node: str) -> list[int]:
        """The daemon of a node, which was started with its name, and the steps that carry it."""
        marks = {f"{_NODE}={node}".encode(), f"SLURMD_NODENAME={node}".encode()}
        mine = f"SLURM_CONF={self.environment['SLURM_CONF']}".encode()
        found = []
        for path in Path("/proc").glob("[0-9]*/environ"):
            with suppress(OSError):
                variables = set(path.read_bytes().split(b"\0"))
                if mine in variables and variables & marks:
                    found.append(int(path.parent.name))
        return found


def missing() -> list[str]:
    """Programs that this machine lacks."""
    return [name for name in PROGRAMS if shutil.which(name, path=_PATH) is None]


def _cgroup_is_writable() -> bool:
    probe = _CGROUP / "r3gw-probe"
    try:
        probe.mkdir()
    except OSError:
        return False
    probe.rmdir()
    return True


def main() -> None:
    """Start or stop a cluster by hand."""
    match sys.argv[1:]:
        case ["start", folder]:
            Cluster(Path(folder)).start()
            print(f"export SLURM_CONF={Cluster(Path(folder)).environment['SLURM_CONF']}")
        case ["stop", folder]:
            Cluster(Path(folder)).stop()
        case _:
            sys.exit("usage: slurm.py start|stop FOLDER")


if __name__ == "__main__":
    main()
