"""The errors that callers catch, by area. `RlbenchPinError` is their base class.

Each message names the object, the value, the valid values, and the next step. The evidence is in attributes.
An error that only one module raises is defined in that module and derived from one of these.
"""

from __future__ import annotations

import difflib
import errno
import pickle
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

__all__ = [
    "AssetInvalid",
    "AssetNotFound",
    "BoundaryError",
    "CameraError",
    "ControlError",
    "DatasetConflict",
    "DatasetError",
    "DemoError",
    "EnvironmentClosed",
    "EpisodeFileError",
    "EvaluationError",
    "GoalInCollision",
    "IncompatibleResults",
    "InfeasibleControl",
    "InvalidActionError",
    "InvalidArgument",
    "InvalidCamera",
    "InvalidRecord",
    "InvalidRequest",
    "InvalidTarget",
    "InvalidValue",
    "MissingExtra",
    "NoIkSolution",
    "NoPath",
    "NoShapedReward",
    "NoWaypointsError",
    "NotReset",
    "NotStraight",
    "OutsideJointLimits",
    "PlanningError",
    "ProblemFileError",
    "ResetError",
    "ResultsFileError",
    "RetimingError",
    "RlbenchPinError",
    "RobotModelError",
    "SceneFileError",
    "StartInCollision",
    "StorageError",
    "TaskEnvironmentError",
    "TaskError",
    "UnknownArgument",
    "UnknownName",
    "UnknownSetting",
    "UntrustedTaskFile",
    "UsedByTwoThreads",
    "WaypointError",
    "install_hint",
    "nearest_name",
    "shown",
    "storing",
]


class RlbenchPinError(Exception):
    """Base class of every error that this package raises on purpose.

    All of them can be pickled with text and evidence and sent to another process. Evidence that belongs to one process, such as a
    running task, is replaced by a text that describes it.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        """Return how to recreate the error: without its `__init__`, whose arguments are not its text."""
        parts = super().__reduce__()
        evidence = parts[2] if len(parts) > 2 and isinstance(parts[2], dict) else {}
        return _made_again, (type(self), self.args), {name: _portable(value) for name, value in evidence.items()}


def _made_again(kind: type[RlbenchPinError], args: tuple[Any, ...]) -> RlbenchPinError:
    error = kind.__new__(kind, *args)
    error.args = args
    return error


def _portable(value: object) -> object:
    """Return a value that can be pickled; other values, also within containers, are replaced by texts."""
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:  # whatever the classes of others raise
        if type(value) in (list, tuple):
            return type(value)(_portable(item) for item in value)  # type: ignore[call-arg, attr-defined]
        if isinstance(value, Mapping):
            return {str(key): _portable(item) for key, item in value.items()}
        return f"{type(value).__name__}: {value}"
    return value


def nearest_name(name: str, known: Collection[str]) -> str | None:
    """Return the known name that is most similar to `name`, or None if none is similar."""
    near = difflib.get_close_matches(name, known, n=1)
    return near[0] if near else None


class UnknownName(RlbenchPinError):
    """A name is unknown."""

    def __init__(self, kind: str, name: str, known: Collection[str], command: str = "") -> None:
        if not isinstance(name, str):
            name = shown(name)
        self.kind, self.name, self.known = kind, name, tuple(known)
        near = nearest_name(name, self.known)
        guess = f" Did you mean '{near}'?" if near else ""
        where = f" `{command}` lists all {len(self.known)}." if command else f" Known: {_listing(self.known)}."
        super().__init__(f"No {kind} is called '{name}'.{guess}{where}")


_LISTED = 12
"""Maximum number of names in a message."""


def _listing(names: Sequence[str]) -> str:
    shown = ", ".join(sorted(names)[:_LISTED])
    more = len(names) - _LISTED
    return f"{shown or 'none'}, and {more} more" if more > 0 else shown or "none"


class UnknownSetting(UnknownName, AttributeError):  # type: ignore[misc]  # both have a `name`
    """Settings have no attribute of that name."""

    def __init__(self, record: str, name: str, known: Collection[str]) -> None:
        self.record = record
        super().__init__(f"setting of {record}", name, known)
        self.name = name  # AttributeError forgets it

    def __reduce__(self) -> tuple[Any, ...]:
        """Return how to recreate the error: AttributeError stores `name` apart from the other attributes."""
        return type(self), (self.record, self.name, self.known)


class UnknownArgument(RlbenchPinError, TypeError):
    """A function has no argument of that name. It is made of a text alone, because gymnasium raises TypeErrors again."""


class InvalidValue(RlbenchPinError, ValueError):
    """A value is invalid: a wrong type, shape or size, NaN, or out of range.

    Args:
        what: Name of the argument or setting.
        value: The value.
        problem: The requirement, or the fault.
        hint: The next step.
    """

    def __init__(self, what: str, value: object, problem: str, hint: str = "") -> None:
        self.what, self.value, self.problem, self.hint = what, value, problem, hint
        super().__init__(f"{what} {problem}. Got {shown(value)}.{f' {hint}' if hint else ''}")


def shown(value: object, most: int = 120) -> str:
    """Return any value as text of about `most` characters on one line."""
    try:
        begins = _beginning(value, most)
        text = " ".join((str(begins) if isinstance(begins, _Words) else repr(begins)).split())
    except Exception:  # objects of users may refuse to be shown
        text = f"a {type(value).__name__}"
    return text if len(text) <= most else f"{text[:most]}..."


def _beginning(value: object, most: int) -> object:
    """Return only the part of a long value that its text needs, because the text of millions of numbers takes seconds."""
    if isinstance(value, str | bytes | list | tuple) and len(value) > most:
        return value[: most + 1]
    shape = getattr(value, "shape", ())
    if isinstance(shape, tuple) and len(shape) > 2 and hasattr(value, "ravel"):
        return _Words(f"an array of shape {shape}")
    return value


class _Words(str):
    """Text that replaces a value."""


class MissingExtra(RlbenchPinError, ImportError):
    """An optional library is not installed; `extra` is the extra that installs it."""

    def __init__(self, what: str, library: str, extra: str) -> None:
        self.library, self.extra = library, extra
        super().__init__(f"{what} needs '{library}', which is not installed. Install it with {install_hint(extra)}.")


def install_hint(extra: str) -> str:
    """Return the command that installs an extra. rlbench_pin is not on a package index, so its name alone does not suffice."""
    return f"`pip install -e '.[{extra}]'` in a clone of rlbench_pin"


class SceneFileError(RlbenchPinError):
    """A scene file is invalid; the message names file, table and key."""

    def __init__(self, file: Path | str, where: str, problem: str, hint: str = "") -> None:
        self.file, self.where, self.problem, self.hint = Path(file), where, problem, hint
        super().__init__(f"{self.file.name}: {where}: {problem}" + (f" {hint}" if hint else ""))


class InvalidRecord(InvalidValue):
    """A record of a scene, such as `FrameSpec`, was created with an invalid value; the message names the key."""

    def __init__(self, record: str, key: str, value: object, problem: str, hint: str = "") -> None:
        super().__init__(record, value, problem, hint)
        self.record, self.key = record, key
        self.args = (f"{record}{f', key {key!r}' if key else ''}: {problem}{f' {hint}' if hint else ''}",)


class AssetNotFound(RlbenchPinError):
    """A URDF, mesh or texture of a scene does not exist."""

    def __init__(self, path: Path | str, needed_by: str) -> None:
        self.path, self.needed_by = Path(path), needed_by
        super().__init__(
            f"Asset '{path}' needed by {needed_by} does not exist. "
            "Check the spelling, or rebuild the assets with `python scripts/build_assets.py`."
        )


class AssetInvalid(RlbenchPinError):
    """A URDF exists, but cannot be loaded."""

    def __init__(self, path: Path | str, problem: str) -> None:
        self.path, self.problem = Path(path), problem
        super().__init__(f"Asset '{path}' cannot be loaded: {problem.removesuffix('.')}. Correct the file.")


class RobotModelError(RlbenchPinError):
    """A robot description and its URDF disagree, or a configuration has the wrong shape."""


class ControlError(RlbenchPinError):
    """A controller cannot follow a command."""


class InvalidTarget(ControlError, InvalidValue):
    """A controller got an invalid target or state: NaN, a wrong shape, a quaternion of norm zero."""


class InfeasibleControl(ControlError):
    """No command satisfies the constraints of a controller; the attributes are the problem without a solution."""

    def __init__(self, controller: str, cause: str, problem: object = None) -> None:
        self.controller, self.cause, self.problem = controller, cause, problem
        super().__init__(f"{controller} found no command: {cause}. Stop the arm, or relax the constraint.")


class PlanningError(RlbenchPinError):
    """A motion could not be planned; `reason` is one of a fixed set of texts."""

    reason: str = "planning"

    @property
    def evidence(self) -> dict[str, object]:
        """Details of the failure, by name."""
        return dict(vars(self))


class InvalidRequest(PlanningError, InvalidValue):
    """An argument of a planner is not a configuration, pose or path: NaN, a wrong shape, text."""

    reason = "invalid request"


class OutsideJointLimits(PlanningError, ValueError):
    """A configuration at the start, at the end or on the way of a motion is outside the joint limits."""

    reason = "outside joint limits"

    def __init__(self, what: str, joint: str, value: float, limit: float, tolerance: float) -> None:
        self.what, self.joint, self.value, self.limit, self.tolerance = what, joint, value, limit, tolerance
        super().__init__(
            f"The {what} is outside the joint limits: {joint} is at {value:.6g} rad, {abs(value - limit):.3g} rad beyond its "
            f"limit of {limit:.6g} rad; {tolerance:g} rad are tolerated. Bring it inside; `model.limits` has all limits."
        )


class NoIkSolution(PlanningError):
    """No joint configuration reaches a pose."""

    reason = "unreachable"

    def __init__(
        self, pose: np.ndarray, position_error: float, rotation_error: float, starts: int, nearest: np.ndarray | None = None
    ) -> None:
        self.pose, self.starts = np.array(pose), starts
        self.nearest = None if nearest is None else np.array(nearest)
        """The nearest pose (7,) that was reached."""
        self.position_error, self.rotation_error = position_error, rotation_error
        super().__init__(
            f"The tip cannot reach {_pose_text(pose)}: after {starts} starts the best configuration is still "
            f"{1000 * position_error:.1f} mm and {np.degrees(rotation_error):.1f} deg away. "
            "Move the pose closer to the robot, or turn it."
        )


class StartInCollision(PlanningError):
    """The start configuration of a motion is in a forbidden contact."""

    reason = "start in collision"

    def __init__(self, pairs: Sequence[tuple[str, str]], depths: Sequence[float] = ()) -> None:
        self.pairs, self.depths = tuple(pairs), tuple(depths)
        """Names of the links in contact, and the penetration depths [m]."""
        super().__init__(f"The start configuration is in collision: {_pairs_text(pairs, self.depths)}. Move the arm clear first.")


class GoalInCollision(PlanningError):
    """All configurations that reach the goal are in contact."""

    reason = "goal in collision"

    def __init__(self, pairs: Sequence[tuple[str, str]], configurations: int, depths: Sequence[float] = ()) -> None:
        self.pairs, self.configurations, self.depths = tuple(pairs), configurations, tuple(depths)
        """Names of the links in contact in the nearest configuration, and the penetration depths [m]."""
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
    """A geometric path cannot be timed within the joint limits."""

    reason = "timing"

    def __init__(self, cause: str) -> None:
        self.cause = cause
        super().__init__(f"The path cannot be timed under the joint limits: {cause}.")


class ProblemFileError(RlbenchPinError):
    """A file is not a valid planning problem."""

    def __init__(self, path: Path | str, problem: str) -> None:
        self.path, self.problem = Path(path), problem
        super().__init__(f"'{path}' contains no planning problem: {problem}. Create one with `rlbench-pin problems export TASK`.")


def _pairs_text(pairs: Sequence[tuple[str, str]], depths: Sequence[float] = ()) -> str:
    deep = [f" ({1000 * depth:.1f} mm deep)" for depth in depths] or [""] * len(pairs)
    return ", ".join(f"{a} with {b}{d}" for (a, b), d in zip(pairs[:4], deep)) or "unknown pair"


def _pose_text(pose: np.ndarray) -> str:
    x = ", ".join(f"{v:.3f}" for v in np.asarray(pose)[:3])
    q = ", ".join(f"{v:.3f}" for v in np.asarray(pose)[3:])
    return f"position ({x}) m with quaternion ({q})"


class InvalidActionError(RlbenchPinError):
    """An action was refused; the world has not changed.

    Args:
        message: The fault, and the next step.
        cause: The kind of the fault in a few words; for a motion that was not found, the `reason` of the planner.
    """

    def __init__(self, message: str = "", cause: str = "invalid") -> None:
        self.cause = cause
        super().__init__(message)


class TaskEnvironmentError(RlbenchPinError):
    """The environment does not support a call."""


class InvalidArgument(TaskEnvironmentError, InvalidValue):
    """An environment got an invalid seed, variation, number or setting."""


class NotReset(TaskEnvironmentError, RuntimeError):
    """An environment was used before the first reset."""

    def __init__(self, call: str) -> None:
        super().__init__(f"`{call}` was called before the first reset. Call `reset()` first.")


class NoShapedReward(TaskEnvironmentError, RuntimeError):
    """Shaped rewards were requested, but the task has none."""

    def __init__(self, task: str) -> None:
        super().__init__(f"Task '{task}' has no shaped reward. Use shaped_rewards=False, or give the task a `reward()`.")


class ResetError(TaskEnvironmentError):
    """No start state was found; `causes` has the cause of each failed attempt."""

    def __init__(self, task: str, causes: Sequence[str]) -> None:
        self.causes = tuple(causes)
        counts = {c: self.causes.count(c) for c in dict.fromkeys(self.causes)}
        text = "; ".join(f"{n} x {c}" for c, n in counts.items())
        super().__init__(f"Task '{task}' could not be placed in {len(self.causes)} attempts: {text}. Choose another seed.")


class UsedByTwoThreads(TaskEnvironmentError, RuntimeError):
    """An environment was called while another thread was in a call of it."""

    def __init__(self, call: str) -> None:
        super().__init__(
            f"`{call}` was called while another thread was in a call of the same environment, which simulates one world. "
            "Give each thread its own environment, or better each process: threads share one core."
        )


class EnvironmentClosed(TaskEnvironmentError, RuntimeError):
    """A world was used after it was shut down."""


class CameraError(RlbenchPinError):
    """A camera cannot render a requested image."""


class InvalidCamera(CameraError, InvalidValue):
    """A camera got an invalid size, pose or setting."""


class TaskError(RlbenchPinError):
    """A task definition is wrong: a missing registration, a bad return value, an empty success list."""


class BoundaryError(RlbenchPinError):
    """An object could not be placed inside its region."""


class WaypointError(RlbenchPinError):
    """A waypoint is missing or cannot be reached."""

    def __init__(self, message: str, task: object = None) -> None:
        self.task = task
        super().__init__(message)


class NoWaypointsError(WaypointError):
    """A demonstration was requested of a task without waypoints."""


class DemoError(RlbenchPinError):
    """A demonstration ended without success."""

    def __init__(self, message: str, task: object = None) -> None:
        self.task = task
        super().__init__(message)


class DatasetError(RlbenchPinError, RuntimeError):
    """A stored demonstration is missing, truncated or of another version, or more were requested than exist."""


class EpisodeFileError(DatasetError):
    """A file of a dataset is missing, truncated, altered or of another format; `path` is the file."""

    def __init__(self, path: Path | str, message: str) -> None:
        self.path = Path(path)
        super().__init__(message)


class StorageError(DatasetError):
    """The disk cannot be written to (full, read-only, no permission); files stored before are complete."""

    def __init__(self, path: Path | str, cause: OSError) -> None:
        self.path, self.errno = Path(path), cause.errno
        advice = _STORAGE_ADVICE.get(cause.errno or 0, "Check whether the folder can be written to.")
        reason = cause.strerror or str(cause)
        super().__init__(f"'{path}' cannot be written: {reason}. {advice} Everything stored before is complete.")


@contextmanager
def storing(path: Path) -> Iterator[None]:
    """Convert an OSError to a StorageError that names `path`."""
    try:
        yield
    except OSError as error:
        raise StorageError(path, error) from error


_STORAGE_ADVICE = {
    errno.ENOSPC: "Free some space and run it again; `rlbench-pin record` continues with `--resume`.",
    errno.EDQUOT: "Free some of your quota and run it again; `rlbench-pin record` continues with `--resume`.",
    errno.EROFS: "The disk is read-only: choose another folder.",
    errno.EACCES: "You may not write there: choose another folder or change its rights.",
    errno.EPERM: "You may not write there: choose another folder or change its rights.",
    errno.EISDIR: "A folder has that name: choose another name.",
    errno.ENAMETOOLONG: "Choose a shorter name.",
    errno.ENOTDIR: "A part of the path is a file: choose another folder.",
    errno.EEXIST: "A file is in the place of a folder: choose another folder.",
}


class UntrustedTaskFile(DatasetError):
    """The task of stored demonstrations is code from the dataset; it runs only if the user allows it.

    Attributes:
        task: Task name.
        path: The file.
    """

    def __init__(self, task: str, path: Path | str, remark: str = "") -> None:
        self.task, self.path, self.remark = task, Path(path), remark
        super().__init__(
            f"The task '{task}' is code that came with its episodes: '{path}'.{remark} It does not run without your permission. "
            "Read it, then pass `--trust-task-files` (`trust_task_files=True` in Python), or name your own file of the task."
        )

    def __reduce__(self) -> tuple[type[UntrustedTaskFile], tuple[str, Path, str]]:
        return type(self), (self.task, self.path, self.remark)


class DatasetConflict(DatasetError):
    """Two sets of demonstrations, or a recording and the stored demonstrations, are incompatible."""


class EvaluationError(RlbenchPinError, RuntimeError):
    """An evaluation cannot be run, read or compared."""


class ResultsFileError(EvaluationError):
    """A results file is missing, damaged, altered or of another format; `path` is the file."""

    def __init__(self, path: Path | str, problem: str, advice: str = "") -> None:
        self.path, self.problem = Path(path), problem
        advice = advice or "Copy it again from its source, or create it again with `rlbench-pin evaluate`."
        super().__init__(f"'{path}' is not a valid results file: {problem}. {advice}")


class IncompatibleResults(EvaluationError):
    """Two results files cannot be compared: their episodes, limits, protocols or versions of a task differ.

    Attributes:
        differences: The differences, one text each.
    """

    def __init__(self, first: str, second: str, differences: Sequence[str], advice: str) -> None:
        self.differences = tuple(differences)
        super().__init__(f"The results of '{first}' and '{second}' cannot be compared: {'; '.join(differences)}. {advice}")
