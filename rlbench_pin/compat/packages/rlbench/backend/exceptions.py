"""The errors that programs catch; the classes are those which this package raises."""

from __future__ import annotations

from rlbench_pin.errors import BoundaryError, DemoError, InvalidActionError, NoWaypointsError, TaskEnvironmentError, WaypointError

__all__ = ["BoundaryError", "DemoError", "InvalidActionError", "NoWaypointsError", "TaskEnvironmentError", "WaypointError"]
