"""Processes that die, are too many or too few: the episodes are the same. Real demonstrations, without pictures."""

from __future__ import annotations

import importlib.util
import multiprocessing
import os
import signal
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.cli.record import make_engine
from rlbench_pin.datasets import task_faults
from rlbench_pin.environment.record_config import PictureConfig, RecordConfig, WorkItem
from rlbench_pin.environment.record_engines import MAX_DEATHS, Engine, Mourning, ProcessEngine, SerialEngine, WorkersDie
from rlbench_pin.environment.recording import RecordReport, record

TASKS = ("reach_target", "push_button")
CONFIG = RecordConfig(tasks=TASKS, episodes=5, pictures=PictureConfig(products=()))


def manifests(root: Path) -> list[bytes]:
    """The bytes of all manifests."""
    return [(root / task / "manifest.json").read_bytes() for task in TASKS]


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What this process records."""
    root = tmp_path_factory.mktemp("serial")
    assert record(CONFIG, root, engine=SerialEngine()).missing == 0
    return root


def item(index: int = 0) -> WorkItem:
    """Some piece of work."""
    return WorkItem("reach_target", "reach_target", 0, index, 1, (0,))


def test_an_item_that_kills_is_given_up() -> None:
    """The third worker that dies of one item is the last; the others go on."""
    mourning = Mourning()
    for _ in range(MAX_DEATHS - 1):
        assert mourning.death(item(), "SIGSEGV")[1] is None
        assert mourning.death(item(1), "SIGSEGV")[1] is None
        mourning.success()
    death, result = mourning.death(item(), "SIGSEGV")
    assert death.cause == "SIGSEGV"
    assert result is not None
    assert result.entry is None
    assert "worker died" in result.failures[0]


def test_workers_that_only_die_end_the_recording() -> None:
    """When one after the other dies without finishing anything, the error counts the causes."""
    mourning = Mourning()
    with pytest.raises(WorkersDie, match="10 x SIGKILL.*--workers 0"):
        for index in range(20):
            mourning.death(item(index), "SIGKILL")


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
def test_a_fault_in_a_task_is_told_and_survived(tmp_path: Path, serial: Path) -> None:
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


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="the extra 'ray' is not installed")
def test_ray_makes_the_same(tmp_path: Path, serial: Path) -> None:
    """Two actors of a Ray cluster, started here, make the same manifests; one that is killed is replaced."""
    engine: Engine = make_engine("ray", 2)
    report = record(CONFIG, tmp_path, engine=engine)
    assert (report.recorded, report.deaths) == (10, ())
    assert manifests(tmp_path) == manifests(serial)


def test_stopping_begins_nothing(tmp_path: Path) -> None:
    """An engine that is stopped before it starts makes nothing and starts no process."""
    stop = threading.Event()
    stop.set()
    assert list(SerialEngine().map(CONFIG.pictures, [item()], stop)) == []
    assert multiprocessing.active_children() == []
