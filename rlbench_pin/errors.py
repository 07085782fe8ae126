"""Every error of the package, on one page.

Each message names the thing, the value, what was possible, and the next step. The evidence is attached as attributes.
"""

from __future__ import annotations

import difflib
import errno
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np


class RlbenchPinError(Exception):
    """Base class of every error that this package raises on purpose."""


def nearest_name(name: str, known: Collection[str]) -> str | None:
    """Return the known name most like `name`, or None when nothing is close."""
    near = difflib.get_close_matches(name, known, n=1)
    return near[0] if near else None


class UnknownName(RlbenchPinError):
    """A name is not in the catalogue it was looked up in."""

    def __init__(self, kind: str, name: str, known: Collection[str], command: str = "") -> None:
        self.kind, self.name, self.known = kind, name, tuple(known)
        near = nearest_name(name, self.known)
        guess = f" Did you mean '{near}'?" if near else ""
        where = f" `{command}` lists all {len(self.known)}." if command else f" Known: {_listing(self.known)}."
        super().__init__(f"No {kind} is called '{name}'.{guess}{where}")


def _listing(names: Sequence[str], limit: int = 12) -> str:
    shown = ", ".join(sorted(names)[:limit])
    more = len(names) - limit
    return f"{shown or 'none'}, and {more} more" if more > 0 else shown or "none"


# Scenes and assets ------------------------------------------------------------------------------------------------


class SceneFileError(RlbenchPinError):
    """A scene file cannot be used; says which file, which table and which key."""

    def __init__(self, file: Path | str, where: str, problem: str, hint: str = "") -> None:
        self.file, self.where, self.problem, self.hint = Path(file), where, problem, hint
        super().__init__(f"{self.file.name}: {where}: {problem}" + (f" {hint}" if hint else ""))


class AssetNotFound(RlbenchPinError):
    """A URDF or mesh that a scene refers to does not exist."""

    def __init__(self, path: Path | str, needed_by: str) -> None:
        self.path, self.needed_by = Path(path), needed_by
        super().__init__(
            f"Asset '{path}' needed by {needed_by} does not exist. "
            "Check the spelling, or rebuild the assets with `python scripts/build_assets.py`."
        )


class AssetInvalid(RlbenchPinError):
    """A URDF was found but a simulator or Pinocchio could not load it."""

    def __init__(self, path: Path | str, problem: str) -> None:
        self.path, self.problem = Path(path), problem
        super().__init__(f"Asset '{path}' cannot be loaded: {problem}")


# Robot ------------------------------------------------------------------------------------------------------------


class RobotModelError(RlbenchPinError):
    """A robot description and its URDF disagree, or a configuration has the wrong shape."""


# Planning ---------------------------------------------------------------------------------------------------------


class PlanningError(RlbenchPinError):
    """A motion could not be planned; `reason` is one of a fixed set of words."""

    reason: str = "planning"

    @property
    def evidence(self) -> dict[str, object]:
        """What is known about the failure, by name."""
        return dict(vars(self))


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


# Tasks ------------------------------------------------------------------------------------------------------------


class TaskError(RlbenchPinError):
    """A task definition is wrong: a missing registration, a bad return value, an empty success list."""


class BoundaryError(RlbenchPinError):
    """An object could not be placed inside its region."""


class WaypointError(RlbenchPinError):
    """A waypoint is missing, out of reach, or cannot be travelled to."""

    def __init__(self, message: str, task: object = None) -> None:
        self.task = task
        super().__init__(message)


class NoWaypointsError(WaypointError):
    """A demonstration was asked of a task without waypoints."""


class DemoError(RlbenchPinError):
    """A demonstration ended without success."""

    def __init__(self, message: str, task: object = None) -> None:
        self.task = task
        super().__init__(message)


# Environment ------------------------------------------------------------------------------------------------------


class InvalidActionError(RlbenchPinError):
    """An action was refused; the world is as it was before."""


class TaskEnvironmentError(RlbenchPinError):
    """The environment was used in a way that it cannot serve."""


class NotReset(TaskEnvironmentError, RuntimeError):
    """An episode was used before it was started."""

    def __init__(self, call: str) -> None:
        super().__init__(f"`{call}` was called before the first reset. Call `reset()` first.")


class ResetError(TaskEnvironmentError):
    """No start state was found; carries why each attempt failed."""

    def __init__(self, task: str, causes: Sequence[str]) -> None:
        self.causes = tuple(causes)
        counts = {c: self.causes.count(c) for c in dict.fromkeys(self.causes)}
        text = "; ".join(f"{n} x {c}" for c, n in counts.items())
        super().__init__(f"Task '{task}' could not be placed in {len(self.causes)} attempts: {text}.")


class EnvironmentClosed(TaskEnvironmentError, RuntimeError):
    """A world was used after it was shut down."""


# Pictures and data ------------------------------------------------------------------------------------------------


class CameraError(RlbenchPinError):
    """A camera was asked for something it cannot deliver."""


class DatasetError(RlbenchPinError, RuntimeError):
    """A stored demonstration is missing, truncated, of another version, or more were asked for than exist."""


class EpisodeFileError(DatasetError):
    """One file of a dataset is missing, truncated, altered or of another format; `path` says which."""

    def __init__(self, path: Path | str, message: str) -> None:
        self.path = Path(path)
        super().__init__(message)


class StorageError(DatasetError):
    """The disk refused: full, read-only, forbidden; what was stored before is still whole."""

    def __init__(self, path: Path | str, cause: OSError) -> None:
        self.path, self.errno = Path(path), cause.errno
        advice = _STORAGE_ADVICE.get(cause.errno or 0, "See whether the folder can be written to.")
        reason = cause.strerror or str(cause)
        super().__init__(f"'{path}' cannot be written: {reason}. {advice} Everything stored before is whole.")


_STORAGE_ADVICE = {
    errno.ENOSPC: "Free some space and run it again; `rlbench-pin record` goes on with `--resume`.",
    errno.EDQUOT: "Free some of your quota and run it again; `rlbench-pin record` goes on with `--resume`.",
    errno.EROFS: "The disk is read-only: choose another folder.",
    errno.EACCES: "You may not write there: choose another folder or change its rights.",
    errno.EPERM: "You may not write there: choose another folder or change its rights.",
    errno.ENOTDIR: "A part of the path is a file: choose another folder.",
}


class DatasetConflict(DatasetError):
    """Two sets of demonstrations, or a recording and what is stored, do not go together."""


class MissingExtra(RlbenchPinError, ImportError):
    """An optional library is not installed; `extra` is the extra that brings it."""

    def __init__(self, what: str, library: str, extra: str) -> None:
        self.library, self.extra = library, extra
        super().__init__(f"{what} needs '{library}', which is not installed. `pip install 'rlbench-pin[{extra}]'` brings it.")


def _pairs_text(pairs: Sequence[tuple[str, str]], depths: Sequence[float] = ()) -> str:
    deep = [f" ({1000 * depth:.1f} mm deep)" for depth in depths] or [""] * len(pairs)
    return ", ".join(f"{a} with {b}{d}" for (a, b), d in zip(pairs[:4], deep)) or "unknown pair"


def _pose_text(pose: np.ndarray) -> str:
    x = ", ".join(f"{v:.3f}" for v in np.asarray(pose)[:3])
    q = ", ".join(f"{v:.3f}" for v in np.asarray(pose)[3:])
    return f"position ({x}) m with quaternion ({q})"


# Control ----------------------------------------------------------------------------------------------------------


class ControlError(RlbenchPinError):
    """A controller cannot do what it was asked."""


class InvalidTarget(ControlError, ValueError):
    """A controller was given a target or a state that is no such thing: NaN, a wrong shape, a quaternion of norm zero."""

    def __init__(self, what: str, value: object, problem: str) -> None:
        self.what, self.value = what, value
        super().__init__(f"{what} {problem}. Got {value!r}.")


class InfeasibleControl(ControlError):
    """No command satisfies the constraints of a controller; carries the problem that has no solution."""

    def __init__(self, controller: str, cause: str, problem: object = None) -> None:
        self.controller, self.cause, self.problem = controller, cause, problem
        super().__init__(f"{controller} found no command: {cause}. Stop the arm, or relax the constraint.")
