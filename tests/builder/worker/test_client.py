"""The worker process: asked from the server, stopped, killed, and there again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.builder.contracts import ReachSpot, TaskText
from rlbench_pin.builder.worker import (
    NothingOpen,
    WorkerBusy,
    WorkerClient,
    WorkerClosed,
    WorkerFault,
    WorkerLimits,
    WorkerStopped,
)
from rlbench_pin.errors import InvalidValue, UnknownName
from rlbench_pin.viewer.recording import Frame
from tests.builder.worker.conftest import copy_of

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def client() -> Iterator[WorkerClient]:
    """A client for the tests of this file."""
    with WorkerClient(WorkerLimits(wait=0.2)) as made:
        yield made


@pytest.fixture
def saucepan(tmp_path: Path) -> TaskText:
    """A copy of take_lid_off_saucepan."""
    return copy_of("take_lid_off_saucepan", tmp_path)


def _is_there(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().split(") ")[1][0] != "Z"
    except FileNotFoundError:
        return False


def _comes(about: Callable[[], bool], seconds: float = 10.0) -> bool:
    end = time.monotonic() + seconds
    while not about() and time.monotonic() < end:
        time.sleep(0.02)
    return about()


def test_everything_can_be_asked(client: WorkerClient, saucepan: TaskText) -> None:
    """Records come back whole, and callbacks are called while it runs."""
    assert client.open(saucepan, run_task=False).conditions == ()
    assert client.open(saucepan, run_task=True).conditions == ("lid grasped", "lid inside above")
    verdicts = client.reach()
    assert [verdict.standing for verdict in verdicts] == ["free"] * 3
    assert client.reset(2).frames[0].poses.keys() == {"saucepan/saucepan", "lid/knob", "lid/cover"}
    seen: list[Frame] = []
    recording = client.demonstrate(2, on_frame=seen.append)
    assert recording.failure is None
    assert len(seen) == len(recording.frames) > 50
    paths: list[str] = []
    assert [path.waypoint for path in client.paths(lambda path: paths.append(path.waypoint))] == paths
    q, error = client.follow(verdicts[0].pose, recording.frames[0].arm)
    assert error < 1e-3
    assert q.shape == (7,)
    assert client.simulate(0.1).frames[-1].conditions_met == (True, True)
    assert client.images(32)["front"].shape == (32, 32, 3)
    begin = recording.frames[0]
    assert np.array_equal(client.images(32, begin)["front"], client.images(32, begin)["front"])
    moved = saucepan.scene.replace("[0.0, 0.0, -0.15]", "[0.0, 0.0, -0.1]")
    assert client.place(moved).problems == ()
    assert client.reach()[2].pose[2] == pytest.approx(verdicts[2].pose[2] - 0.05)


def test_what_makes_no_sense_is_refused(client: WorkerClient, saucepan: TaskText) -> None:
    """Before the process is asked."""
    client.open(saucepan, run_task=False)
    pose, q = [0.3, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0], [0.0] * 7
    for wrong in (
        lambda: client.follow([np.nan, *pose[1:]], q),
        lambda: client.simulate(-1.0),
        lambda: client.simulate(1e9),
        lambda: client.reset(-1),
        lambda: client.reset(0, -1),
        lambda: client.images(100_000),
        lambda: client.reach_map(0),
        lambda: client.validate(0),
        lambda: client.open(TaskText("../x", saucepan.folder, "", ""), run_task=False),
    ):
        with pytest.raises(InvalidValue):
            wrong()
    with pytest.raises(UnknownName):
        client.open(saucepan, run_task=False, robot="pandaa")
    with pytest.raises(WorkerFault, match=r"configuration"):
        client.follow(pose, q[:3])
    with pytest.raises(NothingOpen, match="its code may not run"):
        client.validate(1)
    assert len(client.reach()) == 3


def test_who_asks_meanwhile_is_refused(client: WorkerClient, saucepan: TaskText) -> None:
    """A callback at once, since it would wait for itself; another thread after a while. The error names the running operation."""
    client.open(saucepan, run_task=True)
    refused: list[str] = []

    def ask() -> None:
        with pytest.raises(WorkerBusy, match="demonstrate"):
            client.reach()
        refused.append(threading.current_thread().name)

    def seen(frame: Frame) -> None:
        if not refused:
            ask()
            other = threading.Thread(target=ask, name="other")
            other.start()
            other.join(10.0)

    assert client.demonstrate(0, on_frame=seen).failure is None
    assert refused == [threading.current_thread().name, "other"]


def test_a_callback_that_raises_ends_it(client: WorkerClient, saucepan: TaskText) -> None:
    """Its error is passed on, the process lives, and the next operation finds an open task."""
    client.open(saucepan, run_task=True)
    process = client._world.pid

    def stop(frame: Frame) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        client.demonstrate(0, on_frame=stop)
    assert client.reset(0).failure is None
    assert client._world.pid == process


def _interrupted(client: WorkerClient, by: Callable[[], object]) -> BaseException | None:
    """Demonstrate, do something from another thread after ten frames, and return what was raised."""
    begun, done = threading.Event(), threading.Event()

    def seen(frame: Frame) -> None:
        if frame.time > 0.5:
            begun.set()

    def interrupt() -> None:
        begun.wait(30.0)
        by()
        done.set()

    thread = threading.Thread(target=interrupt)
    thread.start()
    try:
        client.demonstrate(4, on_frame=seen)
    except (WorkerFault, WorkerStopped) as error:
        return error
    finally:
        thread.join(30.0)
    return None


def test_it_is_stopped_from_another_thread(client: WorkerClient, saucepan: TaskText) -> None:
    """What runs ends soon, and the process lives on."""
    client.open(saucepan, run_task=True)
    before = client._world.pid
    assert isinstance(_interrupted(client, client.cancel), WorkerStopped)
    assert not client.cancel()
    assert client.reset(4).failure is None
    assert client._world.pid == before


def test_it_is_killed_while_it_demonstrates(client: WorkerClient, saucepan: TaskText) -> None:
    """The error says how it ended; the next operation has a new process with the task and the episode as they were."""
    client.open(saucepan, run_task=True)
    start = client.reset(4).frames[0]
    before = client._world.pid
    assert before is not None
    fault = _interrupted(client, lambda: os.kill(before, signal.SIGKILL))
    assert isinstance(fault, WorkerFault)
    assert fault.kind == "crashed"
    assert "SIGKILL" in str(fault)
    verdicts = client.reach()
    assert client._world.pid != before
    lid = start.poses["lid/knob"]
    assert np.abs(verdicts[1].pose[:3] - lid[:3]).max() < 1e-3
    assert np.array_equal(client.reset(4).frames[0].poses["lid/knob"], lid)


def test_it_is_validated_while_it_is_edited(client: WorkerClient, saucepan: TaskText) -> None:
    """In a process of its own, which is stopped alone."""
    client.open(saucepan, run_task=True)
    lines: list[str] = []
    begun, raised = threading.Event(), []

    def progress(done: int, total: int) -> None:
        assert total > 100
        if done > 3:
            begun.set()

    def validate() -> None:
        try:
            client.validate(1, lambda line: lines.append(line.name), progress)
        except WorkerStopped as error:
            raised.append(error)

    thread = threading.Thread(target=validate)
    thread.start()
    assert begun.wait(60.0)
    assert len(client.reach()) == 3
    assert client.cancel("validate")
    thread.join(30.0)
    assert [type(error) for error in raised] == [WorkerStopped]
    assert {"instructions", "noop", "drift"} <= set(lines)
    spots: list[ReachSpot] = []
    found = client.reach_map(3, spots.append)
    assert [spot.place for spot in found] == [spot.place for spot in spots]
    assert len(spots) == 3


def test_nothing_stays_behind(saucepan: TaskText) -> None:
    """After `close` process and folder are gone, and further calls raise an error."""
    with WorkerClient() as client:
        with pytest.raises(NothingOpen):
            client.reach()
        client.open(saucepan, run_task=False)
        pid, folder = client._world.pid, client.folder
        assert pid is not None
        assert _is_there(pid)
    assert not folder.exists()
    assert _comes(lambda: not _is_there(pid))
    for asked in (client.reach, lambda: client.open(saucepan, run_task=False)):
        with pytest.raises(WorkerClosed):
            asked()


_OWNER = """
import sys
from pathlib import Path
from rlbench_pin.builder.contracts import TaskText
from rlbench_pin.builder.worker import WorkerClient
client = WorkerClient()
folder = Path(sys.argv[1])
client.open(TaskText("loops", folder, "format = 2\\n", ""), run_task=False)
print(client._world.pid, client.folder, flush=True)
python = f'''
import os, subprocess, time
sleeper = subprocess.Popen(["sleep", "600"], start_new_session=True)
forked = os.fork()
if forked == 0:
    os.setsid()
    time.sleep(600)
open({str(folder / "hidden")!r}, "w").write(f"{{sleeper.pid}} {{forked}}")
while True:
    pass
'''
client.open(TaskText("loops", folder, "format = 2\\n", python), run_task=True)
"""


def test_it_ends_with_its_server(tmp_path: Path) -> None:
    """Also when that is killed, while a module loops, and with what that has started in sessions of their own."""
    owner = subprocess.Popen([sys.executable, "-c", _OWNER, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert owner.stdout is not None
    with owner.stdout:
        pid, folder = owner.stdout.readline().split()
    hidden = tmp_path / "hidden"
    assert _comes(lambda: hidden.is_file() and " " in hidden.read_text(), 30.0)
    pids = [int(pid), *map(int, hidden.read_text().split())]
    assert all(_is_there(pid) for pid in pids)
    owner.kill()
    owner.wait()
    assert _comes(lambda: not any(map(_is_there, pids)))
    assert _comes(lambda: not Path(folder).exists())
