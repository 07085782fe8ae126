"""Demonstrations converted to every action space and played again: the share that still succeeds.

Usage: python benchmarks/bench_actions.py [--tasks NAME ...] [--demos 4] [--out docs/results]
Writes actions.json and actions.md, anew after every demonstration.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness import state_only

from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    Environment,
    JointPosition,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    TaskEnvironment,
)
from rlbench_pin.environment.actions.modes import ArmActionMode
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.observation import Demo
from rlbench_pin.recording import convert_by_playing, convert_demo, verify
from rlbench_pin.spatial import FloatArray

TASKS = (
    "reach_target", "push_button", "pick_and_lift", "take_lid_off_saucepan", "open_drawer",
    "close_microwave", "slide_block_to_target", "stack_blocks", "put_rubbish_in_bin", "meat_off_grill",
)  # fmt: skip
SPACES: dict[str, Callable[[], ArmActionMode]] = {
    "joint position": JointPosition,
    "joint position, delta": lambda: JointPosition(absolute_mode=False),
    "joint velocity": JointVelocity,
    "joint velocity, delta": lambda: JointVelocity(absolute_mode=False),
    "joint torque": JointTorque,
    "joint torque, delta": lambda: JointTorque(absolute_mode=False),
    "tip velocity": EndEffectorVelocity,
    "tip velocity, tip axes": lambda: EndEffectorVelocity(frame="end effector"),
    "tip velocity, delta": lambda: EndEffectorVelocity(absolute_mode=False),
    "tip pose, IK": EndEffectorPoseViaIK,
    "tip pose, IK, delta": lambda: EndEffectorPoseViaIK(absolute_mode=False),
    "tip pose, IK, tip frame": lambda: EndEffectorPoseViaIK(frame="end effector"),
    "tip pose, planning": EndEffectorPoseViaPlanning,
    "tip pose, planning, delta": lambda: EndEffectorPoseViaPlanning(absolute_mode=False),
}
GOALS = {"joint position": 0.95, "joint velocity": 0.90, "tip velocity": 0.90, "tip pose": 0.95}
"""Share of demonstrations that has to succeed, by the first words of a space; none for torques."""
UNPLAYED = ("tip pose, planning",)
"""Spaces that are converted from the demonstration alone; every action of theirs is a motion of its own."""

INTRODUCTION = """# Demonstrations in every action space

Written by `python benchmarks/bench_actions.py`. Up to {demos} demonstrations of each task are converted to every action space
and played again from their start; a cell says how many still succeed, `alone / played`.

* `alone`: by `convert_demo`, from the demonstration and the arm model, without the simulator.
* `played`: by `convert_by_playing`, which plays the demonstration once more in the new space and computes every action from
  what is measured; then the actions alone are played again, without feedback.

"""


@dataclass
class Cell:
    """Successes of one space in one task."""

    demos: int = 0
    alone: int = 0
    played: int = 0


def main() -> None:
    """Convert, play, write both files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--demos", type=int, default=4)
    parser.add_argument("--spaces", nargs="+", default=tuple(SPACES))
    parser.add_argument("--out", type=Path, default=Path("docs/results"), help="folder for actions.json and actions.md")
    options = parser.parse_args()
    cells = {space: {task: Cell() for task in options.tasks} for space in options.spaces}
    for k in range(options.demos):
        for name in options.tasks:
            demo = record(name, k)
            for space in options.spaces:
                _count(space, name, demo, cells[space][name])
            print(k, name, *(f"{c[name].alone}/{c[name].played}" for c in cells.values()), flush=True)
            _write(cells, options.out)


def record(name: str, seed: int) -> Demo:
    """Return a live demonstration of a task."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=state_only(), seed=0) as env:
        return env.get_task(name).get_demos(1, live_demos=True, seed=seed)[0]


def _count(space: str, name: str, demo: Demo, cell: Cell) -> None:
    mode = MoveArmThenGripper(SPACES[space](), Discrete())
    with Environment(mode, obs_config=state_only(), seed=0) as env:
        task = env.get_task(name)
        cell.demos += 1
        if not space.endswith("torque, delta"):
            cell.alone += _succeeds(task, demo, lambda: convert_demo(demo, mode, task.runtime.model))
        if not space.startswith(UNPLAYED):
            cell.played += _succeeds(task, demo, lambda: convert_by_playing(task, demo))


def _succeeds(task: TaskEnvironment, demo: Demo, convert: Callable[[], Sequence[FloatArray]]) -> bool:
    try:
        return verify(task, demo, convert())
    except RlbenchPinError:
        return False


def _write(cells: dict[str, dict[str, Cell]], out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    content = {space: {name: vars(cell) for name, cell in row.items() if cell.demos} for space, row in cells.items()}
    (out / "actions.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    demos = max(cell.demos for row in cells.values() for cell in row.values())
    (out / "actions.md").write_text(INTRODUCTION.format(demos=demos) + _table(cells), encoding="utf-8")


def _table(cells: dict[str, dict[str, Cell]]) -> str:
    tasks = [name for name, cell in next(iter(cells.values())).items() if cell.demos]
    rows = [["action space", *tasks, "all", "goal"]]
    for space, row in cells.items():
        done = [row[name] for name in tasks]
        total = Cell(*(sum(getattr(c, key) for c in done) for key in ("demos", "alone", "played")))
        goal = next((f"{share:.0%}" for words, share in GOALS.items() if space.startswith(words)), "")
        rows.append([space, *(_counts(space, c) for c in done), _shares(space, total), goal])
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    rows.insert(1, ["-" * width for width in widths])
    return "".join("| " + " | ".join(x.ljust(w) for x, w in zip(row, widths, strict=True)) + " |\n" for row in rows)


def _counts(space: str, cell: Cell) -> str:
    return _pair(space, str(cell.alone), str(cell.played))


def _shares(space: str, cell: Cell) -> str:
    return _pair(space, f"{cell.alone / cell.demos:.0%}", f"{cell.played / cell.demos:.0%}")


def _pair(space: str, alone: str, played: str) -> str:
    return f"{'-' if space.endswith('torque, delta') else alone} / {'-' if space.startswith(UNPLAYED) else played}"


if __name__ == "__main__":
    main()
