"""A whole evaluation: the same results file to the byte, whoever plays, and whatever was killed on the way."""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.cli.options import make_engine
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.errors import InvalidValue, RlbenchPinError, UnknownName
from rlbench_pin.evaluation.results.records import read_results
from rlbench_pin.evaluation.results.statistics import summarise
from rlbench_pin.evaluation.run import (
    EpisodeItem,
    EpisodeOutcome,
    EpisodeRunner,
    EvaluationConfig,
    EvaluationConflict,
    EvaluationProgress,
    EvaluationStopped,
    evaluate,
    evaluation_seed,
)
from rlbench_pin.evaluation.run.evaluate import journal_path
from rlbench_pin.evaluation.run.provenance import checkout_commit, times_path
from rlbench_pin.processes import Engine, ProcessEngine, SerialEngine
from tests.evaluation.run import policies

pytestmark = pytest.mark.simulation

TASKS = ("reach_target", "push_button")
CONFIG = EvaluationConfig(policy="random", tasks=TASKS, episodes=4, max_seconds=1.5, policy_seed_key="key")
WORDS = ("--tasks", *TASKS, "--episodes", "4", "--max-seconds", "1.5", "--policy-seed-key", "key")
COMMAND = (sys.executable, "-m", "rlbench_pin.cli.main", "evaluate", "random", *WORDS)
needs_ray = pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="the extra 'ray' is not installed")


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What this process finds."""
    out = tmp_path_factory.mktemp("serial") / "results.json"
    evaluate(CONFIG, out, engine=SerialEngine())
    return out


def test_the_file_holds_every_episode_in_order(serial: Path) -> None:
    """Tasks as they were asked for, episodes by their seeds; no time, no date, no worker in it; times lie beside it."""
    results = read_results(serial)
    assert [(e.task, e.seed) for e in results.episodes] == [(t, evaluation_seed(0, i)) for t in TASKS for i in range(4)]
    assert all(e.end == "seconds" and e.steps > 0 for e in results.episodes)
    assert results.policy == "random"
    assert results.limits["max_seconds"] == 1.5
    assert results.commit == checkout_commit()
    assert sorted(p.name for p in serial.parent.iterdir()) == ["results.json", "results.times.json"]
    times = json.loads(times_path(serial).read_text())
    assert times["all"]["actions"] == sum(e.steps for e in results.episodes)
    assert 0.0 < times["all"]["median_s"] <= times["all"]["p95_s"] <= times["all"]["max_s"]
    assert set(times["tasks"]) == set(TASKS)


@pytest.mark.parametrize("workers", [1, 2])
def test_the_number_of_workers_changes_nothing(serial: Path, tmp_path: Path, workers: int) -> None:
    """One process and two write the same bytes as this one."""
    seen: list[EvaluationProgress] = []
    evaluate(CONFIG, tmp_path / "x.json", engine=ProcessEngine(workers), on_progress=seen.append)
    assert (tmp_path / "x.json").read_bytes() == serial.read_bytes()
    assert [(p.wanted, p.found, p.done) for p in seen] == [(8, 0, n) for n in range(9)]
    assert seen[0].latest is None


@pytest.mark.slow
@needs_ray
def test_ray_finds_the_same(serial: Path, tmp_path: Path) -> None:
    """Two actors of a Ray cluster, started here, write the same bytes."""
    engine: Engine = make_engine("ray", 2)
    evaluate(CONFIG, tmp_path / "x.json", engine=engine)
    assert (tmp_path / "x.json").read_bytes() == serial.read_bytes()


def test_a_key_is_drawn_and_published(tmp_path: Path) -> None:
    """Each run has its own; going on keeps it, and the run can be repeated with what the file says."""
    config = replace(CONFIG, tasks=("reach_target",), policy_seed_key=None, max_seconds=0.5)
    stop, out, again = threading.Event(), tmp_path / "x.json", tmp_path / "again.json"
    with pytest.raises(EvaluationStopped):
        evaluate(config, out, engine=SerialEngine(), on_progress=lambda p: stop.set() if p.done else None, stop=stop)
    drawn = json.loads(journal_path(out).read_text().splitlines()[0])["policy_seed_key"]
    results = evaluate(config, out, engine=SerialEngine(), resume=True)
    assert results.policy_seed_key == drawn
    assert evaluate(config, out, engine=SerialEngine(), resume=True) == results
    evaluate(replace(config, policy_seed_key=drawn), again, engine=SerialEngine())
    assert again.read_bytes() == out.read_bytes()
    assert evaluate(config, tmp_path / "other.json", engine=SerialEngine()).policy_seed_key not in ("", drawn)


UNGUARDED = """
from rlbench_pin.evaluation import EvaluationConfig, evaluate
evaluate(EvaluationConfig(policy="noop", tasks=("reach_target",), episodes=1, max_seconds=0.5), "x.json")
"""


def test_a_script_without_a_guard_fails(tmp_path: Path) -> None:
    """Also with a single episode: no results of episodes that nobody has played, and the message names the guard."""
    (tmp_path / "script.py").write_text(UNGUARDED)
    run = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode != 0
    assert "if __name__ == '__main__':" in run.stderr.splitlines()[-1]
    assert not (tmp_path / "x.json").exists()
    (tmp_path / "script.py").write_text("if __name__ == '__main__':" + UNGUARDED.replace("\n", "\n    "))
    subprocess.run([sys.executable, "script.py"], cwd=tmp_path, check=True)
    assert read_results(tmp_path / "x.json").episodes[0].end == "seconds"


def test_a_policy_that_ends_its_worker_loses_the_episode(tmp_path: Path) -> None:
    """There is no second try, and the file says what happened."""
    config = replace(CONFIG, policy=f"{policies.__file__}:EndsWorker", tasks=("reach_target",), episodes=2, max_seconds=0.5)
    results = evaluate(config, tmp_path / "x.json")
    assert [(e.fault, e.worker_deaths) for e in results.episodes] == [("worker died", 1), ("worker died", 1)]
    assert "SIGKILL" in results.episodes[0].fault_detail
    (task,) = summarise(results, np.random.default_rng(0)).tasks
    assert (task.worker_deaths, task.retried) == (2, 0)
    assert read_results(tmp_path / "x.json") == results


def test_a_worker_that_dies_is_in_the_results(serial: Path, tmp_path: Path) -> None:
    """The policies of this package have further tries, which are counted."""
    runner = partial(DiesOnce, folder=str(tmp_path))
    results = evaluate(CONFIG, tmp_path / "x.json", make_runner=runner)
    assert [e.worker_deaths for e in results.episodes] == [1] * 8
    calm = read_results(serial)
    assert replace(results, episodes=tuple(replace(e, worker_deaths=0) for e in results.episodes)) == calm
    assert sum(task.retried for task in summarise(results, np.random.default_rng(0)).tasks) == 8


class DiesOnce(EpisodeRunner):
    """Ends its process at the first try of each episode."""

    def __init__(self, config: EvaluationConfig, folder: str) -> None:
        super().__init__(config)
        self.folder = Path(folder)

    def make(self, item: EpisodeItem) -> EpisodeOutcome:
        """Play it, the second time."""
        mark = self.folder / f"{item.name}.{item.index}"
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return super().make(item)


def wait_for_episodes(path: Path, count: int, process: subprocess.Popen[str]) -> None:
    """Wait until a journal holds so many episodes."""
    for _ in range(1200):
        if path.exists() and path.read_bytes().count(b"\n") > count:
            return
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)
    raise AssertionError(f"{path} does not grow")


def test_a_killed_evaluation_goes_on(serial: Path, tmp_path: Path) -> None:
    """Killed with SIGKILL after two episodes and resumed, it writes the same bytes; what was played is not played again."""
    out = tmp_path / "x.json"
    process = subprocess.Popen([*COMMAND, "--out", str(out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for_episodes(journal_path(out), 2, process)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert not out.exists()
    with pytest.raises(EvaluationConflict, match="--resume"):
        evaluate(CONFIG, out, engine=SerialEngine())
    seen: list[EvaluationProgress] = []
    evaluate(CONFIG, out, engine=SerialEngine(), resume=True, on_progress=seen.append)
    assert out.read_bytes() == serial.read_bytes()
    assert seen[0].found >= 2
    assert seen[-1].found + seen[-1].done == 8
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.json", "x.times.json"]


def test_ctrl_c_stops_gently_and_says_how_to_go_on(serial: Path, tmp_path: Path) -> None:
    """The command ends with 130 and prints the words that go on; they write the same bytes."""
    out = tmp_path / "with blank.json"
    words = [*COMMAND, "--out", str(out)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    wait_for_episodes(journal_path(out), 1, process)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "Continue with:  rlbench-pin evaluate random --tasks reach_target push_button" in err
    assert "'" in err.split("Continue with:")[1]
    assert "--resume" in err
    again = subprocess.run([*words, "--resume"], capture_output=True, text=True, check=True)
    assert "reach_target" in again.stdout
    assert out.read_bytes() == serial.read_bytes()


def test_an_evaluation_that_ended_is_read(serial: Path) -> None:
    """With `resume` nothing is played; with other settings, or without `resume`, it is refused."""
    before = serial.read_bytes()
    assert evaluate(CONFIG, serial, engine=SerialEngine(), resume=True) == read_results(serial)
    with pytest.raises(EvaluationConflict, match="exists already"):
        evaluate(CONFIG, serial, engine=SerialEngine())
    with pytest.raises(EvaluationConflict, match="another evaluation"):
        evaluate(replace(CONFIG, episodes=5), serial, engine=SerialEngine(), resume=True)
    assert serial.read_bytes() == before


def test_what_was_stopped_is_kept(tmp_path: Path) -> None:
    """The error says how much there is; settings may not change until it goes on."""
    stop, out = threading.Event(), tmp_path / "x.json"

    def after_two(progress: EvaluationProgress) -> None:
        if progress.done == 2:
            stop.set()

    with pytest.raises(EvaluationStopped, match="2 of 8 episodes"):
        evaluate(CONFIG, out, engine=SerialEngine(), on_progress=after_two, stop=stop)
    with pytest.raises(EvaluationConflict, match="max_seconds"):
        evaluate(replace(CONFIG, max_seconds=2.0), out, engine=SerialEngine(), resume=True)
    assert not out.exists()


def test_nothing_runs_for_what_cannot_be_evaluated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Unknown policies and tasks, and files that cannot be, are refused before an episode begins."""
    monkeypatch.setattr(TaskEnvironment, "reset", lambda *_, **__: pytest.fail("an episode began"))
    with pytest.raises(UnknownName, match="Did you mean 'random'"):
        evaluate(replace(CONFIG, policy="rndom"), tmp_path / "x.json")
    with pytest.raises(UnknownName, match="Did you mean 'reach_target'"):
        evaluate(replace(CONFIG, tasks=("reach_targt",)), tmp_path / "x.json", engine=SerialEngine())
    with pytest.raises(RlbenchPinError, match="is a folder"):
        evaluate(CONFIG, tmp_path)
    with pytest.raises(InvalidValue, match="engine"):
        evaluate(CONFIG, tmp_path / "x.json", engine=2)  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="make_runner"):
        evaluate(CONFIG, tmp_path / "x.json", make_runner=None)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
