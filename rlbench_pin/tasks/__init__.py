"""Tasks: what a task file needs, and the classes of the library by name.

`from rlbench_pin.tasks import ReachTarget` imports that one task and no other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.errors import BoundaryError
from rlbench_pin.front_door import front_door
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.tasks.conditions import (
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
from rlbench_pin.tasks.placement import PLACEMENT_AREA, place_task, swap_places
from rlbench_pin.tasks.registry import (
    LIBRARY,
    find_task,
    library_names,
    plugin_faults,
    task_class,
    task_names,
    task_origin,
    task_scene,
    usable_task_names,
)
from rlbench_pin.tasks.settling import at_rest, settle
from rlbench_pin.tasks.spawn_boundary import NO_ROTATION, SpawnBoundary, clearance
from rlbench_pin.tasks.task import Task, TaskState
from rlbench_pin.tasks.task_file import (
    OwnTasks,
    camel_case,
    checked_class,
    is_task_file,
    load_task_file,
    own_tasks,
    task_digest,
    task_reference,
)
from rlbench_pin.tasks.waypoints import Waypoint

if TYPE_CHECKING:
    from rlbench_pin.tasks.stored import chosen_tasks_of, keep_task, keep_tasks, stored_task

__all__ = [
    "BUTTON_COLORS",
    "COLORS",
    "LIBRARY",
    "NO_ROTATION",
    "PLACEMENT_AREA",
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

_OF_DATASETS = ("chosen_tasks_of", "keep_task", "keep_tasks", "stored_task")
"""What needs the libraries that read data; they are loaded when one of these names is first used."""

if not TYPE_CHECKING:
    _look_up, _names = front_door(__name__, dict.fromkeys(_OF_DATASETS, "stored"))

    def __getattr__(name: str) -> object:
        """Import the class of a task on first use, and what deals with datasets."""
        if name[:1].isupper() and (name in map(camel_case, library_names()) or name in map(camel_case, task_names())):
            return task_class(name)
        return _look_up(name)

    def __dir__() -> list[str]:
        """List the public names, and the classes of all tasks."""
        return sorted({*_names(), *map(camel_case, task_names())})
