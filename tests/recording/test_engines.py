"""Processes that die, are too many or too few: the episodes are the same. Real demonstrations, without images."""

from __future__ import annotations

import importlib.util
import multiprocessing
import os
import signal
import threading
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.cli.options import make_engine
from rlbench_pin.datasets import task_faults
from rlbench_pin.processes import Engine, ProcessEngine, SerialEngine
from rlbench_pin.recording.config import ImageConfig, RecordConfig
from rlbench_pin.recording.record import RecordReport, record

TASKS = ("reach_target", "push_button")
CONFIG = RecordConfig(tasks=TASKS, episodes=5, images=ImageConfig(products=()))


def manifests(root: Path) -> list[bytes]:
    """The bytes of all manifests."""
    return [(root / task / "manifest.json").read_bytes() for task in TASKS]


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What this process records."""
    root = tmp_path_factory.mktemp("serial")
    assert record(CONFIG, root, engine=SerialEngine()).missing == 0
    return root


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_the_number_of_workers_changes_nothing(tmp_path: Path, serial: Path, workers: int) -> None:
    """One process, two processes and this one make equal manifests, SHA-256 and all."""
    report = record(CONFIG, tmp_path, engine=ProcessEngine(workers))
    assert (report.recorded, report.deaths) == (10, ())
    assert manifests(tmp_path) == manifests(serial)
    assert [task_faults(tmp_path, task) for task in TASKS] == [[], []]


@pytest.mark.slow
def test_a_worker_that_dies_is_replaced(tmp_path: Path, serial: Path) -> None:
    """Its item is done again by another, the report says what happened, and the dataset is the same."""

    def kill_one(report: RecordReport) -> None:
        if report.recorded == 2 and not report.deaths:
            os.kill(multiprocessing.active_children()[0].pid or 0, signal.SIGKILL)

    report = record(CONFIG, tmp_path, engine=ProcessEngine(1), on_progress=kill_one)
    assert [death.cause for death in report.deaths] == ["SIGKILL"]
    assert report.deaths[0].item.name in TASKS
    assert (report.recorded, report.missing) == (10, 0)
    assert manifests(tmp_path) == manifests(serial)
    assert multiprocessing.active_children() == []


@pytest.mark.slow
def test_a_fault_in_a_task_is_reported_and_survived(tmp_path: Path, serial: Path) -> None:
    """A task file whose code raises costs its own episodes only; what it raised is in the report."""
    folder = tmp_path / "tasks"
    folder.mkdir()
    scene = Path(__file__).parents[2] / "rlbench_pin" / "tasks" / "library" / "reach_target.toml"
    (folder / "broken_reach.toml").write_text(scene.read_text())
    (folder / "broken_reach.py").write_text(
        "from rlbench_pin.tasks.library.reach_target import ReachTarget\n\n\n"
        "class BrokenReach(ReachTarget):\n"
        "    def init_episode(self, variation, rng):\n"
        "        raise ZeroDivisionError('one by nothing')\n"
    )
    config = replace(CONFIG, tasks=(str(folder / "broken_reach.py"), *TASKS), max_attempts=2)
    report = record(config, tmp_path / "data", engine=SerialEngine())
    assert report.causes == {"fault": 10}
    assert {result.item.name for result in report.failed} == {"broken_reach"}
    assert "ZeroDivisionError: one by nothing" in report.failed[0].failures[0]
    assert manifests(tmp_path / "data") == manifests(serial)


needs_ray = pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="the extra 'ray' is not installed")


def actors_below(ancestor: int) -> list[tuple[int, bool]]:
    """The Ray actors among all that a process has started: process id, and whether it is making an episode."""
    parents, titles = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # it has ended
            parents[int(folder.name)] = int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1])
            titles[int(folder.name)] = (folder / "cmdline").read_bytes()

    def is_below(pid: int) -> bool:
        return pid == ancestor or (pid in parents and is_below(parents[pid]))

    actors = [pid for pid, title in titles.items() if title.startswith(b"ray::RayWorker") and is_below(pid)]
    return [(pid, titles[pid].startswith(b"ray::RayWorker.make")) for pid in actors]


@pytest.mark.slow
@needs_ray
def test_ray_makes_the_same(tmp_path: Path, serial: Path) -> None:
    """Two actors of a Ray cluster, started here, make the same manifests."""
    engine: Engine = make_engine("ray", 2)
    report = record(CONFIG, tmp_path, engine=engine)
    assert (report.recorded, report.deaths) == (10, ())
    assert manifests(tmp_path) == manifests(serial)


@pytest.mark.slow
@needs_ray
@pytest.mark.parametrize("working", [True, False], ids=["while it works", "while it waits"])
def test_a_ray_actor_that_dies_is_replaced(tmp_path: Path, serial: Path, working: bool) -> None:
    """An actor that is killed costs nothing: its episode is made by another, the report says so, the manifests are the same."""
    killed: list[int] = []
    done = threading.Event()

    def kill_one() -> None:
        while not killed and not done.wait(0.005):
            for pid, works in actors_below(os.getpid()):
                if works == working and not killed:
                    os.kill(pid, signal.SIGKILL)
                    killed.append(pid)

    def watch(report: RecordReport) -> None:
        if report.recorded == 2 and not report.deaths:
            if working:
                threading.Thread(target=kill_one, daemon=True).start()
            else:  # the engine waits for this to return before it gives the actor more to do
                kill_one()

    report = record(CONFIG, tmp_path, engine=make_engine("ray", 1), on_progress=watch)
    done.set()
    assert len(killed) == 1
    assert [death.cause for death in report.deaths] == ["ActorDiedError"]
    assert report.deaths[0].item.name in TASKS
    assert (report.recorded, report.missing, report.failed) == (10, 0, ())
    assert manifests(tmp_path) == manifests(serial)
    assert [task_faults(tmp_path, task) for task in TASKS] == [[], []]


@pytest.mark.slow
@needs_ray
def test_more_ray_actors_than_cores_do_not_wait_forever(tmp_path: Path, serial: Path) -> None:
    """Actors for which the cluster has no core yet get one when the others have nothing left to do."""
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=1, log_to_driver=False, logging_level="ERROR", include_dashboard=False)
    try:
        report = record(CONFIG, tmp_path, engine=make_engine("ray", 3))
    finally:
        ray.shutdown()
    assert (report.recorded, report.deaths) == (10, ())
    assert manifests(tmp_path) == manifests(serial)
