"""`rlbench-pin conventions POLICY`: compare the conventions that a policy seems to use with the stated ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import tyro

from rlbench_pin.cli.options import RobotName, TaskName
from rlbench_pin.cli.serve import PolicyName
from rlbench_pin.errors import TaskEnvironmentError

if TYPE_CHECKING:
    from rlbench_pin.evaluation.conventions import ArmReading, ConventionReport


@dataclass(frozen=True)
class Conventions:
    """Compare the conventions that a policy seems to use with those that its mapping or action mode states.

    The policy returns one action at each of three known poses. These are the start pose with an open gripper, and two poses where
    the tip is moved and rotated, the first of them with a closed gripper. The first action of a trained policy is near the
    current pose. The table shows the distance of the actions from that pose [mm, degrees] in each convention with the right count
    of numbers, best first. The result is only a hint; docs/conventions.md explains why. Exit code 1: a convention seems to
    differ.
    """

    policy: tyro.conf.Positional[PolicyName] = ""
    """Policy, as for `rlbench-pin evaluate`: `file.py:NAME`, `openpi://HOST:PORT?mapping=NAME`, `noop`, ..."""

    task: TaskName = "reach_target"
    """Task name, as `rlbench-pin list` prints it, or a task file. Choose one that the policy was trained on."""
    robot: RobotName = "panda"
    """Name of the arm, or path of its TOML file."""

    def run(self) -> int:
        """Print the conventions and a verdict for arm and gripper; return 1 when one of them seems to differ."""
        from rlbench_pin.evaluation.conventions import compare_conventions

        if not self.policy:
            hint = "Use `rlbench-pin conventions POLICY`, for example `openpi://127.0.0.1:8000?mapping=libero`."
            raise TaskEnvironmentError(f"No policy was named. {hint}")
        report = compare_conventions(self.policy, self.task, self.robot)
        print(_text(report))
        return int(report.differs)


def _text(report: ConventionReport) -> str:
    """Return the table of all conventions, and the verdicts."""
    rows = [("arm", *_figures(reading), reading.name, report.is_stated(reading)) for reading in report.arm]
    rows += [("gripper", "", f"{reading.error:.2f}", reading.name, report.is_stated(reading)) for reading in report.gripper]
    mark = f"  <- {report.stated.source}"
    lines = [f"{'':<7}  {'distance':>9}  {'angle':>7}  convention, best first"]
    for part, distance, turn, name, is_stated in rows:
        if part == "gripper" and lines[-1].startswith("arm"):
            lines.append(f"{'':<7}  {'':>9}  {'error':>7}  1 is the range from closed to open")
        lines.append(f"{part:<7}  {distance:>9}  {turn:>7}  {name}{mark if is_stated else ''}")
    return "\n".join([*lines, "", f"arm: {report.arm_verdict.text}", f"gripper: {report.gripper_verdict.text}"])


def _figures(reading: ArmReading) -> tuple[str, str]:
    """Return the distance and the angle of a convention of the arm."""
    if not reading.targets:
        return "no", "pose"
    return f"{1e3 * reading.distance:.0f} mm", f"{np.degrees(reading.turn):.1f} deg"
