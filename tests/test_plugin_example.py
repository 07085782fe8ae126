"""The package in `examples/plugin` installs, and its tasks work wherever those of the library do."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TASKS = ("join_blocks", "sort_two_cubes")
Run = Callable[..., str]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Install the package into a folder of its own, and return what runs Python with it, elsewhere, and gives its output."""
    pytest.importorskip("hatchling")
    site, work = tmp_path_factory.mktemp("site"), tmp_path_factory.mktemp("work")
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation", "--disable-pip-version-check"]
    subprocess.run([*pip, "--target", str(site), str(ROOT / "examples" / "plugin")], check=True, timeout=120)
    environment = {**os.environ, "PYTHONPATH": f"{site}{os.pathsep}{ROOT}"}

    def run(*arguments: str, timeout: float = 240.0) -> str:
        command = [sys.executable, *arguments]
        result = subprocess.run(command, capture_output=True, text=True, timeout=timeout, env=environment, cwd=work)
        assert result.returncode == 0, result.stdout + result.stderr
        return result.stdout

    return run


def _command(run: Run, *arguments: str, **settings: float) -> str:
    return run("-c", "import sys; from rlbench_pin.cli.main import main; sys.exit(main())", *arguments, **settings)


@pytest.mark.simulation
def test_the_tasks_are_listed_and_found(run: Run) -> None:
    """After those of the library, with the package that brings them; by name and by class."""
    lines = _command(run, "list").splitlines()
    assert [line.split()[0] for line in lines[-2:]] == list(TASKS)
    assert all(line.endswith("[rlbench-pin-example-tasks 0.1.0]") for line in lines[-2:])
    assert set(TASKS) <= set(json.loads(_command(run, "list", "--json")))
    code = "from rlbench_pin.tasks import JoinBlocks, task_names; print(task_names()[-2:], JoinBlocks.get_name())"
    assert run("-c", code) == f"{TASKS} join_blocks\n"


@pytest.mark.simulation
def test_the_tasks_are_checked(run: Run, tmp_path: Path) -> None:
    """A short form of the contract."""
    _command(
        run,
        "check",
        *TASKS,
        "--episodes",
        "2",
        "--contract-seeds",
        "1",
        "--placements",
        "4",
        "--json",
        str(tmp_path / "report.json"),
    )
    report = json.loads((tmp_path / "report.json").read_text())["tasks"]
    assert {name: task["faults"] for name, task in report.items()} == dict.fromkeys(TASKS, [])


@pytest.mark.simulation
def test_the_tasks_are_recorded_replayed_rerendered_and_evaluated(run: Run, tmp_path: Path) -> None:
    """By two workers; installed code needs no trust, and the dataset keeps it for those who have not installed it."""
    data = str(tmp_path / "data")
    _command(run, "record", *TASKS, "--episodes", "1", "--products", "--workers", "2", "--out", data)
    assert _command(run, "replay", data).count("reached") == 2
    pictures = ("--image-size", "16", "16", "--cameras", "front", "--products", "rgb")
    _command(run, "dataset", "rerender", data, "--out", str(tmp_path / "small"), *pictures)
    assert "no faults in 2 tasks" in _command(run, "dataset", "verify", str(tmp_path / "small"))
    kept = tmp_path / "data" / TASKS[1] / "task_file"
    assert sorted(p.name for p in kept.iterdir()) == ["files.json", f"{TASKS[1]}.py", f"{TASKS[1]}.toml"]


@pytest.mark.simulation
def test_the_tasks_are_gymnasium_environments(run: Run) -> None:
    """By the id for every task, and by ids of their own."""
    code = (
        "import gymnasium, rlbench_pin.gym as g\n"
        "ids = g.register_plugin_tasks(); print(len(ids))\n"
        "for env in (gymnasium.make(g.ANY_TASK, task='join_blocks'), gymnasium.make('rlbench_pin/sort_two_cubes-state-v0')):\n"
        "    print(env.reset(seed=1)[1]['success']); env.step(env.action_space.sample()); env.close()\n"
    )
    assert run("-c", code) == "4\nFalse\nFalse\n"


@pytest.mark.slow
def test_the_tasks_keep_the_whole_contract(run: Run) -> None:
    """At least 95 % of demonstrations succeed at the first try: `check` says so by its exit code."""
    _command(run, "check", *TASKS, "--episodes", "20", "--contract-seeds", "5", timeout=1800.0)
