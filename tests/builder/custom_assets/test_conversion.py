"""Files are converted to assets in a subprocess with a time limit; the page goes on meanwhile, and reports the result."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.builder.custom_assets.conversion import Conversion, Job
from rlbench_pin.builder.custom_assets.mesh_asset import CustomAsset
from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.worker import WorkerClient
from rlbench_pin.cli.main import main
from rlbench_pin.errors import RlbenchPinError
from tests.builder.custom_assets.files import angle, cabinet, make, obj, put

Found = CustomAsset | RlbenchPinError


def _make(name: str, data: bytes, act: Callable[[Conversion], object] = id, time_limit: float = 60.0) -> tuple[Found, list[str]]:
    """Return what comes of an order in a process, and what was told on the way."""
    found, notes, ended = list[Found](), list[str](), threading.Event()

    def end(result: Found) -> None:
        found.append(result)
        ended.set()

    order = Job(name, "/nowhere", 1.0, 1.0, (1.0, 0.0, 0.0))
    act(Conversion(order, data, notes.append, end, time_limit))
    assert ended.wait(90.0)
    return found[0], notes


@pytest.mark.simulation
def test_a_mesh_is_made_in_a_process() -> None:
    """With notes on the way."""
    asset, notes = _make("angle.obj", obj(angle()))
    assert isinstance(asset, CustomAsset)
    assert {"angle.urdf", "angle.obj", "angle_part0.obj"} <= set(asset.files)
    assert "Decomposing" in notes[-1]


def test_what_takes_too_long_is_ended() -> None:
    """By the clock, or by somebody; the message names the file and the next step."""
    slow, _ = _make("slow.obj", obj(angle()), time_limit=0.05)
    assert "'slow.obj' is refused: it takes longer than 0.05 s. Reduce it" in str(slow)
    stopped, _ = _make("stopped.obj", obj(angle()), act=Conversion.stop)
    assert "it was stopped" in str(stopped)


def test_what_kills_the_process_is_told() -> None:
    """As a parser may do on hostile bytes."""
    killed, _ = _make("deadly.obj", obj(angle()), act=lambda made: os.kill(made._child.pid, 11))
    assert isinstance(killed, RlbenchPinError)
    assert "SIGSEGV" in str(killed)


@pytest.mark.simulation
def test_what_is_refused_is_told() -> None:
    """The reason comes from the process."""
    refused, _ = _make("a.stl", b"solid nothing")
    assert "'a.stl' is refused" in str(refused)


_OWNER = """
import sys, time
import numpy as np, trimesh
from rlbench_pin.builder.custom_assets.conversion import Conversion, Job
from rlbench_pin.builder.custom_assets.mesh_asset import obj_text
rng = np.random.default_rng(0)
soup = trimesh.Trimesh(rng.random((3000, 3)) * 0.2, rng.integers(0, 3000, (2000, 3)), process=False)
order = Job("soup.obj", "/nowhere", 1.0, 1.0, (1.0, 0.0, 0.0))
made = Conversion(order, obj_text(soup).encode(), lambda note: print(made._child.pid, note, flush=True), print)
time.sleep(600)
"""


@pytest.mark.simulation
def test_no_process_outlives_a_killed_builder() -> None:
    """A mesh that keeps the library busy for minutes ends with whoever asked."""
    owner = subprocess.Popen([sys.executable, "-c", _OWNER], stdout=subprocess.PIPE, text=True)
    assert owner.stdout is not None
    pid = next(line.split()[0] for line in owner.stdout if "Decomposing" in line)
    owner.kill()
    owner.communicate()
    wait_for_end(int(pid))


def wait_for_end(pid: int) -> None:
    """Wait until a process has ended."""
    end = time.monotonic() + 20.0
    while Path(f"/proc/{pid}").exists() and time.monotonic() < end:
        time.sleep(0.1)
    assert not Path(f"/proc/{pid}").exists()


# In the simulation ----------------------------------------------------------------------------------------------------


@pytest.mark.simulation
def test_a_custom_urdf_is_simulated_and_validated(tmp_path: Path) -> None:
    """Its door falls shut or open with the joint, and a fresh process reads the pair."""
    main(["new", "shelf", "--out", str(tmp_path)])
    put(make("cabinet.zip", cabinet(), tmp_path), tmp_path / "cabinet")
    document = TaskDocument.open(tmp_path / "shelf.toml")
    keys = {"asset": "./cabinet/cabinet.urdf", "name": "cabinet", "pose": (-0.1, 0.25, 0.02, 0.0, 0.0, 0.0, 1.0), "fixed": True}
    document.add("body", keys)
    document.set("cabinet/hinge", "position", 1.0)
    document.save()
    with WorkerClient() as worker:
        opened = worker.open(document.text, run_task=True)
        assert opened.problems == ()
        worker.reset(1)
        frame = worker.simulate(0.3).frames[-1]
    assert {"cabinet/case", "cabinet/door_1", "cabinet/drawer"} <= set(frame.poses)
    turn = 2.0 * np.arctan2(frame.poses["cabinet/door_1"][5], frame.poses["cabinet/door_1"][6])
    turn -= 2.0 * np.arctan2(frame.poses["cabinet/case"][5], frame.poses["cabinet/case"][6])
    assert (turn + np.pi) % (2 * np.pi) - np.pi == pytest.approx(1.0, abs=0.1)
    words = [
        "check",
        "--task-file",
        str(document.folder / "shelf.py"),
        "--episodes",
        "1",
        "--contract-seeds",
        "1",
        "--placements",
        "2",
    ]
    program = f"import sys; from rlbench_pin.cli.main import main; sys.exit(main({words!r}))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300)
    assert "shelf" in done.stdout
    assert "Traceback" not in done.stderr
