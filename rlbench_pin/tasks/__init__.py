"""Tasks: the API for task files, and the task classes of the library by name.

`from rlbench_pin.tasks import ReachTarget` imports only that task.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import lazy_loader as lazy

from rlbench_pin.errors import BoundaryError
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.tasks.conditions import (
    Aligned,
    AllOf,
    AnyOf,
    Condition,
    Detected,
    DetectedSeveral,
    FollowPath,
    Grasped,
    HasColor,
    InOrder,
    JointMoved,
    ListEmpty,
    NothingGrasped,
    TipInside,
)
from rlbench_pin.tasks.grasps import Tray, easiest_top_grasp, free_direction
from rlbench_pin.tasks.palette import BUTTON_COLORS, COLORS, Color, distractor_colors, fill_up_colors
from rlbench_pin.tasks.placement import NO_ROTATION, PLACEMENT_AREA, SpawnBoundary, clearance, place_task, swap_places
from rlbench_pin.tasks.registry import (
    LIBRARY,
    OwnTasks,
    camel_case,
    checked_class,
    find_task,
    is_task_file,
    library_names,
    load_task_file,
    own_tasks,
    plugin_faults,
    task_class,
    task_digest,
    task_names,
    task_origin,
    task_reference,
    task_scene,
    usable_task_names,
)
from rlbench_pin.tasks.settling import at_rest, settle
from rlbench_pin.tasks.task import Task, TaskState, Wording
from rlbench_pin.tasks.waypoints import Waypoint

if TYPE_CHECKING:
    from rlbench_pin.tasks.stored import chosen_tasks_of, keep_task, keep_tasks, stored_task

__all__ = [
    "BUTTON_COLORS",
    "COLORS",
    "LIBRARY",
    "NO_ROTATION",
    "PLACEMENT_AREA",
    "Aligned",
    "AllOf",
    "AnyOf",
    "BodySpec",
    "BoundaryError",
    "Color",
    "Condition",
    "Detected",
    "DetectedSeveral",
    "FollowPath",
    "Grasped",
    "HasColor",
    "InOrder",
    "JointMoved",
    "ListEmpty",
    "NothingGrasped",
    "OwnTasks",
    "SpawnBoundary",
    "Task",
    "TaskState",
    "TipInside",
    "Tray",
    "Waypoint",
    "Wording",
    "at_rest",
    "camel_case",
    "checked_class",
    "chosen_tasks_of",
    "clearance",
    "distractor_colors",
    "easiest_top_grasp",
    "fill_up_colors",
    "find_task",
    "free_direction",
    "is_task_file",
    "keep_task",
    "keep_tasks",
    "library_names",
    "load_task_file",
    "own_tasks",
    "place_task",
    "plugin_faults",
    "settle",
    "stored_task",
    "swap_places",
    "task_class",
    "task_digest",
    "task_names",
    "task_origin",
    "task_reference",
    "task_scene",
    "usable_task_names",
]

_stored, _, _ = lazy.attach(__name__, submod_attrs={"stored": ["chosen_tasks_of", "keep_task", "keep_tasks", "stored_task"]})
"""Names that need the libraries of datasets; these libraries are imported when one of the names is first used."""

if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        """Import the class of a task, or a function for datasets, on first use."""
        if name[:1].isupper() and (name in map(camel_case, library_names()) or name in map(camel_case, task_names())):
            return task_class(name)
        return _stored(name)

    def __dir__() -> list[str]:
        """List the public names, and the classes of all tasks."""
        return sorted({*globals(), *__all__, *map(camel_case, task_names())})
