"""Tasks that are defined wrongly, cannot be placed, or are not solved by their demonstration."""

from __future__ import annotations

from rlbench_pin.errors.base import RlbenchPinError


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
