"""Motions that cannot be planned, each with the evidence."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rlbench_pin.errors.base import InvalidValue, RlbenchPinError


class PlanningError(RlbenchPinError):
    """A motion could not be planned; `reason` is one of a fixed set of words."""

    reason: str = "planning"

    @property
    def evidence(self) -> dict[str, object]:
        """What is known about the failure, by name."""
        return dict(vars(self))


class InvalidRequest(PlanningError, InvalidValue):
    """A planner was given something that is no configuration, no pose or no path: NaN, a wrong shape, text."""

    reason = "invalid request"


class OutsideJointLimits(PlanningError, ValueError):
    """A configuration that a motion should begin or end in, or pass, is outside the joint limits."""

    reason = "outside joint limits"

    def __init__(self, what: str, joint: str, value: float, limit: float, tolerance: float) -> None:
        self.what, self.joint, self.value, self.limit, self.tolerance = what, joint, value, limit, tolerance
        super().__init__(
            f"The {what} is outside the joint limits: {joint} is at {value:.6g} rad, {abs(value - limit):.3g} rad beyond its "
            f"limit of {limit:.6g} rad; {tolerance:g} rad are forgiven. Bring it inside; `model.limits` has all limits."
        )


class NoIkSolution(PlanningError):
    """No joint configuration reaches a pose."""

    reason = "unreachable"

    def __init__(
        self, pose: np.ndarray, position_error: float, rotation_error: float, starts: int, nearest: np.ndarray | None = None
    ) -> None:
        self.pose, self.starts = np.array(pose), starts
        self.nearest = None if nearest is None else np.array(nearest)
        """The most similar pose (7,) that was reached."""
        self.position_error, self.rotation_error = position_error, rotation_error
        super().__init__(
            f"The tip cannot reach {_pose_text(pose)}: after {starts} starts the best configuration is still "
            f"{1000 * position_error:.1f} mm and {np.degrees(rotation_error):.1f} deg away. "
            "Move the pose closer to the robot, or turn it."
        )


class StartInCollision(PlanningError):
    """The motion would begin in a forbidden contact."""

    reason = "start in collision"

    def __init__(self, pairs: Sequence[tuple[str, str]], depths: Sequence[float] = ()) -> None:
        self.pairs, self.depths = tuple(pairs), tuple(depths)
        """Names of what touches what, and how deep [m]."""
        super().__init__(f"The start configuration is in collision: {_pairs_text(pairs, self.depths)}. Move the arm clear first.")


class GoalInCollision(PlanningError):
    """Every configuration that reaches the goal touches something."""

    reason = "goal in collision"

    def __init__(self, pairs: Sequence[tuple[str, str]], configurations: int, depths: Sequence[float] = ()) -> None:
        self.pairs, self.configurations, self.depths = tuple(pairs), configurations, tuple(depths)
        """Names of what touches what in the nearest configuration, and how deep [m]."""
        super().__init__(
            f"All {configurations} configurations that reach the goal are in collision: {_pairs_text(pairs, self.depths)}. "
            "Choose another pose, or ignore collisions for this motion."
        )


class NoPath(PlanningError):
    """No path was found within the budget of state checks."""

    reason = "no path"

    def __init__(self, cause: str, checks: int) -> None:
        self.cause, self.checks = cause, checks
        super().__init__(f"No path was found after {checks} state checks: {cause}. Raise the budget or move the goal.")


class NotStraight(PlanningError):
    """The straight Cartesian line to a pose cannot be followed."""

    reason = "no straight line"

    def __init__(self, fraction: float, cause: str, pairs: Sequence[tuple[str, str]] = ()) -> None:
        self.fraction, self.cause, self.pairs = fraction, cause, tuple(pairs)
        cause = f"{cause} ({_pairs_text(pairs)})" if pairs else cause
        super().__init__(f"The straight line breaks off after {100 * fraction:.0f} % of its length: {cause}.")


class RetimingError(PlanningError):
    """A geometric path cannot be timed under the limits."""

    reason = "timing"

    def __init__(self, cause: str, joint: str = "") -> None:
        self.cause, self.joint = cause, joint
        at = f" (joint {joint})" if joint else ""
        super().__init__(f"The path cannot be timed under the joint limits{at}: {cause}.")


class ProblemFileError(RlbenchPinError):
    """A file that should hold a planning problem cannot be used."""

    def __init__(self, path: Path | str, problem: str) -> None:
        self.path, self.problem = Path(path), problem
        super().__init__(f"'{path}' holds no planning problem: {problem}. `rlbench-pin problems export TASK` writes such files.")


def _pairs_text(pairs: Sequence[tuple[str, str]], depths: Sequence[float] = ()) -> str:
    deep = [f" ({1000 * depth:.1f} mm deep)" for depth in depths] or [""] * len(pairs)
    return ", ".join(f"{a} with {b}{d}" for (a, b), d in zip(pairs[:4], deep)) or "unknown pair"


def _pose_text(pose: np.ndarray) -> str:
    x = ", ".join(f"{v:.3f}" for v in np.asarray(pose)[:3])
    q = ", ".join(f"{v:.3f}" for v in np.asarray(pose)[3:])
    return f"position ({x}) m with quaternion ({q})"
