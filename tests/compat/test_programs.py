"""Programs as users of RLBench write them run under the known names, and show what their users want to see.

`programs/` imports nothing of rlbench_pin; each program checks its own results and ends with a line that reports them.
"""

from __future__ import annotations

import ast
import re
from importlib.metadata import requires
from pathlib import Path

import pytest

from tests.compat.support import compat

PROGRAMS = Path(__file__).parent / "programs"
SAYS = {
    "camera_moved": "moved cam_front to [0.9 0.6 1.4]",
    "custom_action_mode": "joints by",
    "domain_randomisation": "appearance changed on",
    "gym_user": "image (360, 640, 3)",
    "imitation": "cloned",
    "keyframe_agent": "success",
    "masks_by_handle": "shapes of stack_blocks matched",
    "multi_task": "of 15 tasks",
    "orbit_video": "recorded",
    "paper_loop": "acted 60 steps",
    "paper_task": "replay reward 1.0",
    "planning_mode": "walked paths of",
    "replay_buffer": "replay buffer:",
    "task_author": "from the middle of the zone",
}
"""What the last line of a program has in it."""


def test_every_program_is_run() -> None:
    """Each file has its line here."""
    assert {file.stem for file in PROGRAMS.glob("*.py")} == set(SAYS)


@pytest.mark.parametrize("name", SAYS)
def test_programs_know_nothing_of_this_package(name: str) -> None:
    """They import the known names and common libraries, and say who writes such a program."""
    tree = ast.parse((PROGRAMS / f"{name}.py").read_text(encoding="utf-8"))
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    imported |= {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert not {module for module in imported if module.startswith("rlbench_pin")}
    assert any(module.split(".")[0] == "rlbench" for module in imported)
    assert ast.get_docstring(tree)


@pytest.mark.simulation
@pytest.mark.parametrize("name", SAYS)
def test_program_runs(name: str, tmp_path: Path) -> None:
    """With exit code 0 and its closing line."""
    done = compat(PROGRAMS / f"{name}.py", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert SAYS[name] in done.stdout.splitlines()[-1], done.stdout


def test_packages_that_come_along_with_rlbench() -> None:
    """Ours asks for neither of those that programs often use beside it."""
    wanted = {re.split(r"[^\w-]", line)[0].lower() for line in requires("rlbench-pin") or ()}
    assert "numpy" in wanted
    assert not wanted & {"natsort", "pyquaternion"}
