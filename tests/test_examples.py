"""The examples run as they stand, are numbered without a gap, and the README names them all."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SAYS = {
    "04_safe_policy": "with the filter: touched nothing",
    "06_train_ppo": "the mean reward has risen",
    "07_plan_and_follow": "solved 3 of 3",
    "08_policy_by_ik": "solved 3 of 3",
    "09_pick_from_point_cloud": "solved 3 of 3",
    "10_frame_dataset": "the error has fallen\n",
}
"""What an example says when it shows what it promises; the others reach the goal of their task."""
NEEDS = {"06_train_ppo": "stable_baselines3", "10_frame_dataset": "torch"}
"""What an example needs beyond the package; without it the example is skipped."""
EXAMPLES = sorted((ROOT / "examples").glob("[0-9]*.py"))
BY_IK = ("reach_target", "push_button", "pick_and_lift")
WORKED = [("07_plan_and_follow",), ("09_pick_from_point_cloud",), *(("08_policy_by_ik", "--task", task) for task in BY_IK)]
"""The worked programs, with what they play."""


def run(example: str, *arguments: str, folder: Path) -> str:
    """Run an example in a folder and return what it prints."""
    command = [sys.executable, str(ROOT / "examples" / f"{example}.py"), *arguments]
    paths = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))
    environment = {**os.environ, "PYTHONPATH": paths}
    result = subprocess.run(command, capture_output=True, text=True, timeout=1800, cwd=folder, env=environment)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_numbers_have_no_gap() -> None:
    """01, 02, 03 and so on."""
    assert [path.stem[:3] for path in EXAMPLES] == [f"{number:02d}_" for number in range(1, len(EXAMPLES) + 1)]


def test_the_readme_links_every_example() -> None:
    """The numbered ones, and the folders."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    folders = [path for path in (ROOT / "examples").iterdir() if path.is_dir() and path.name != "__pycache__"]
    assert [path.name for path in [*EXAMPLES, *folders] if f"(examples/{path.name})" not in readme] == []


@pytest.mark.slow
@pytest.mark.parametrize("example", [path.stem for path in EXAMPLES])
def test_example_runs(example: str, tmp_path: Path) -> None:
    """Each ends well, says something, and reaches the goal that it shows."""
    if example in NEEDS:
        pytest.importorskip(NEEDS[example])
    assert SAYS.get(example, "reward 1.0") in run(example, folder=tmp_path)


@pytest.mark.simulation
@pytest.mark.parametrize("words", WORKED, ids=" ".join)
def test_worked_programs_solve_their_tasks(words: tuple[str, ...], tmp_path: Path) -> None:
    """Two episodes each."""
    assert "solved 2 of 2" in run(*words, "--seeds", "40", "42", folder=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 1000])
@pytest.mark.parametrize("words", WORKED, ids=" ".join)
def test_worked_programs_solve_twenty_of_twenty(words: tuple[str, ...], first: int, tmp_path: Path) -> None:
    """Whatever the seeds."""
    assert "solved 20 of 20" in run(*words, "--seeds", str(first), str(first + 20), folder=tmp_path)
