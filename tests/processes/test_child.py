"""Child processes: the socket, what they print, how they end, and that nothing of them is left."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from rlbench_pin.processes.child import ChildProcess

MODULE = "tests.processes.child_module"
OWNER = f"""
import sys
from rlbench_pin.processes.child import ChildProcess
from tests.processes.test_child import started_by
child = ChildProcess({MODULE!r}, ["daemons"])
print(child.pid, *started_by(child), flush=True)
sys.stdin.read()
"""


def runs(pid: int) -> bool:
    """Whether a process exists and is no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def gone(pid: int) -> bool:
    """Whether a process ends within 10 s."""
    end = time.monotonic() + 10.0
    while runs(pid) and time.monotonic() < end:
        time.sleep(0.01)
    return not runs(pid)


@pytest.mark.parametrize(("fault", "ending", "printed"), [
    ("exit", "Its process ended with exit code 3.", "started sweet"),
    ("memory", "Its process ended with exit code 1.", "MemoryError"),
    ("wait", "", "started sweet"),
])  # fmt: skip
def test_a_child_answers_and_ends(fault: str, ending: str, printed: str) -> None:
    """The socket carries bytes both ways; the sentence says how it ended by itself, and stays the same."""
    child = ChildProcess(MODULE, [fault], {"FLAVOUR": "sweet"})
    with closing(child.connection):
        child.connection.settimeout(60.0)
        child.connection.sendall(b"hello")
        assert child.connection.recv(100) == b"HELLO"
        assert child.end(patience=0.0 if fault == "wait" else 60.0) == ending
    assert child.end() == ending
    assert printed in child.printed()
    assert not runs(child.pid)


@pytest.mark.parametrize("fault", ["daemons", "daemons crash"])
def test_descendants_in_sessions_of_their_own_end_too(fault: str) -> None:
    """Twenty of twenty, without their parent and without the environment; also where the module ends by itself."""
    child = ChildProcess(MODULE, [fault])
    with closing(child.connection):
        daemons = started_by(child)
        assert fault == "daemons crash" or all(map(runs, daemons))
        ending = child.end(patience=60.0 if fault == "daemons crash" else 0.0)
    assert ending == ("Its process was ended by SIGABRT." if fault == "daemons crash" else "")
    assert [pid for pid in daemons if runs(pid)] == []


def started_by(child: ChildProcess) -> list[int]:
    """Return the process ids that a child sends."""
    child.connection.settimeout(60.0)
    child.connection.sendall(b"x")
    said = b""
    while said.count(b"\n") < 20:
        said += child.connection.recv(1000)
    return [int(word) for word in said.removeprefix(b"X").split()]


@pytest.mark.simulation
def test_a_child_ends_with_its_owner() -> None:
    """However that ends: here it is killed; what the child has started ends too."""
    owner = subprocess.Popen(
        [sys.executable, "-c", OWNER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": ":".join(sys.path)},
    )
    assert owner.stdout is not None and owner.stdin is not None
    with owner.stdout, owner.stdin:
        pids = [int(word) for word in owner.stdout.readline().split()]
        assert len(pids) == 21
        owner.kill()
        owner.wait()
        assert all(map(gone, pids))
