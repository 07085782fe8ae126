"""Tasks with the API of RLBench: tasks of the library, or classes of a program."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from numbers import Number
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from pyrep.objects import Dummy
from pyrep.objects.object import Object, view_of
from pyrep.objects.shape import Shape
from rlbench.backend.conditions import Condition, NativeCondition, condition_of
from rlbench.backend.waypoints import Waypoint, waypoint_of
from rlbench_pin.compat.objects import Element
from rlbench_pin.compat.paper_tasks import PaperTask, adapter_of
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.waypoint_planning import check_feasible
from rlbench_pin.errors import RlbenchPinError, TaskError
from rlbench_pin.observation import Observation
from rlbench_pin.sim import Body, Frame, ObjectJoint
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import LIBRARY, task_class
from rlbench_pin.tasks import Task as NativeTask
from rlbench_pin.tasks.task import RotationBounds, snake_case

if TYPE_CHECKING:
    from pyrep import PyRep
    from rlbench.backend.robot import Robot

TASKS_PATH = str(LIBRARY)
"""Folder whose `.py` files are the tasks of the library."""


@dataclass(frozen=True, eq=False)
class TreeState:
    """Poses, joint values and parents of the objects of a task."""

    bodies: dict[str, tuple[FloatArray, FloatArray]]
    """Name -> pose (7,) and velocity (6,)."""
    joints: dict[str, tuple[float, float]]
    """Name -> position and velocity."""
    frames: dict[str, tuple[str, FloatArray]]
    """Name -> parent and pose (7,) in the frame of the parent."""


class TreeChanged(RlbenchPinError, RuntimeError):
    """The task has other objects than the saved state."""


class Task:
    """A task: override `init_task`, `init_episode` and `variation_count`; the rest is optional.

    The scene of a user's task is a `.toml` file in the folder of its module, named after the task or the module. Draws of
    `init_episode` and of hooks from `np.random` or `random` repeat with the seed of the episode.

    Args:
        pyrep: The simulator.
        robot: Arm and gripper.
        name: Name of the task; by default that of the class in snake case.
    """

    library_name: ClassVar[str] = ""
    """Name of the library task that the class is, or is derived from; empty for others."""

    def __init__(self, pyrep: PyRep, robot: Robot, name: str | None = None) -> None:
        self.pyrep, self.robot = pyrep, robot
        self.name = snake_case(type(self).__name__) if name is None else name
        self._native: NativeTask | None = None

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of a loaded library task as an object of PyRep, such as `target` of `reach_target`.

        Attributes of a task of a program take precedence.

        Raises:
            AttributeError: The task has no such attribute.
        """
        native = vars(self).get("_native")
        if native is not None and name == "_success_conditions":
            return [condition_of(condition) for condition in native.get_success_conditions()]
        if native is not None and name == "_graspable_objects":
            return self.get_graspable_objects()
        try:
            return _attribute_of(native, name)
        except AttributeError:
            raise AttributeError(f"'{type(self).__name__}' object has no attribute '{name}'", name=name, obj=self) from None

    # The native task --------------------------------------------------------------------------------------------------

    @classmethod
    def native_origin(cls) -> type[NativeTask]:
        """Return the native class of the methods that are not overridden."""
        return task_class(cls.library_name) if cls.library_name else NativeTask

    @classmethod
    def native_class(cls) -> type[NativeTask]:
        """Return the native class that runs this one."""
        return cls.native_origin() if "library_name" in vars(cls) else adapter_of(cast("Any", cls), cls.step is not Task.step)

    def bind(self, native: NativeTask) -> None:
        """Connect the native task of a new world; for a class of a program this calls `init_task`."""
        self._native = native
        if isinstance(native, PaperTask):
            native.tie(self)

    @property
    def native(self) -> NativeTask:
        """The native task.

        Raises:
            TaskError: The task is not loaded.
        """
        if self._native is None:
            raise TaskError(f"Task '{self.name}' is not loaded. Load it with `Environment.get_task(...)` or `Scene.load(...)`.")
        return self._native

    # To override ------------------------------------------------------------------------------------------------------

    def init_task(self) -> None:
        """Find objects and register conditions and graspable objects; called once."""
        if not self.library_name:
            raise NotImplementedError(f"Task '{self.name}' must define init_task(self).")
        type(self).native_origin().init_task(self.native)

    def init_episode(self, index: int) -> list[str]:
        """Set up one episode of variation `index` and return instructions that all describe the goal."""
        if not self.library_name:
            raise NotImplementedError(f"Task '{self.name}' must define init_episode(self, index).")
        if isinstance(self.native, PaperTask):
            return self.native.origin_episode(index)
        rng = np.random.default_rng(np.random.randint(2**31 - 1))
        return self.native.begin_episode(index, rng)

    def variation_count(self) -> int:
        """Return the number of variations; for library tasks also before they are loaded."""
        if not self.library_name:
            raise NotImplementedError(f"Task '{self.name}' must define variation_count(self).")
        origin = type(self).native_origin()
        return origin.variation_count(object.__new__(origin) if self._native is None else self._native)

    def get_low_dim_state(self) -> FloatArray:
        """Return poses of bodies by name, joint values, poses of shapes that `init_task` attached to the task, shape (n,)."""
        state, native = type(self).native_origin().get_low_dim_state(self.native), self.native
        return np.concatenate([state, native.poses_of_made()]) if isinstance(native, PaperTask) else state

    def step(self) -> None:
        """Run after every simulation step."""
        type(self).native_origin().step(self.native)

    def reward(self) -> float | None:
        """Return the current shaped reward; None if the task has none."""
        return type(self).native_origin().reward(self.native)

    def cleanup(self) -> None:
        """Run after an episode."""
        type(self).native_origin().cleanup(self.native)

    def base_rotation_bounds(self) -> RotationBounds:
        """Return the lowest and highest roll, pitch, yaw [rad] of the random rotation; by default those of the scene file."""
        return type(self).native_origin().base_rotation_bounds(self.native)

    def boundary_root(self) -> Object:
        """Return the object that is moved when the task is placed at random; by default the whole task."""
        return self.get_base()

    def decorate_observation(self, observation: Observation) -> Observation:
        """Return the observation, with changes or additions of the task."""
        return type(self).native_origin().decorate_observation(self.native, observation)

    def is_static_workspace(self) -> bool:
        """Return whether the task has a fixed place; by default as in the scene file."""
        return type(self).native_origin().is_static_workspace(self.native)

    def set_initial_objects_in_scene(self) -> None:
        """No effect: the objects of the low-dimensional state, and their order, follow from the scene file."""

    def load(self) -> Object:
        """Build the world of the task, unless it is the current world, and return the base of the task.

        Raises:
            FileNotFoundError: The task has no scene file.
        """
        simulator = Simulator.current()
        if self._native is None or simulator.runtime.task is not self._native:
            self.bind(simulator.load(self.native_class(), ObservationConfig()).task)
        return self.get_base()

    # To register; each call replaces what was registered before -------------------------------------------------------

    def register_success_conditions(self, condition: Sequence[Condition]) -> None:
        """Define success: all of these conditions are met at the same instant."""
        self.native.register_success_conditions([NativeCondition(c) for c in condition])

    def register_fail_conditions(self, condition: Sequence[Condition]) -> None:
        """Define failure: all of these conditions, met at the same instant, end the episode without success."""
        self.native.register_fail_conditions([NativeCondition(c) for c in condition])

    def register_graspable_objects(self, objects: Iterable[Object]) -> None:
        """Allow the gripper to grasp these objects."""
        self.native.register_graspable_objects([_world_name(item) for item in objects])

    def register_waypoint_ability_start(self, waypoint_index: int, func: Callable[[Waypoint], Any]) -> None:
        """Call `func(waypoint)` before the path to a waypoint is planned."""
        self.native.register_waypoint_ability_start(waypoint_index, lambda w: func(waypoint_of(w, self.robot)))

    def register_waypoint_ability_end(self, waypoint_index: int, func: Callable[[Waypoint], Any]) -> None:
        """Call `func(waypoint)` when a waypoint was reached."""
        self.native.register_waypoint_ability_end(waypoint_index, lambda w: func(waypoint_of(w, self.robot)))

    def register_waypoints_should_repeat(self, func: Callable[[], bool]) -> None:
        """Call `func` after the last waypoint; if it returns True, the list is repeated."""
        self.native.register_waypoints_should_repeat(func)

    def register_stop_at_waypoint(self, waypoint_index: int) -> None:
        """Leave out this waypoint and all later ones."""
        self.native.register_stop_at_waypoint(waypoint_index)

    # To call ----------------------------------------------------------------------------------------------------------

    def get_name(self) -> str:
        """Return the name of the task in snake case."""
        return self.name

    def get_base(self) -> Dummy:
        """Return the root of the task, the ancestor of all its objects."""
        return Dummy(self.native.world.root.name)

    def get_waypoints(self) -> list[Waypoint]:
        """Return the waypoints in order, up to the stop index."""
        return [waypoint_of(waypoint, self.robot) for waypoint in self.native.get_waypoints()]

    def should_repeat_waypoints(self) -> bool:
        """Return whether to repeat the waypoints; called once after the last waypoint."""
        return self.native.should_repeat_waypoints()

    def get_graspable_objects(self) -> list[Object]:
        """Return the objects that the gripper may grasp."""
        return [Shape(name) for name in self.native.get_graspable_objects()]

    def success(self) -> tuple[bool, bool]:
        """Return whether the task is successful, and whether the episode is over."""
        return type(self).native_origin().success(self.native)

    def validate(self) -> None:
        """Raise WaypointError unless all waypoints are reachable in sequence, without collision checks."""
        runtime = Simulator.current().runtime
        runtime.refresh_planner()
        home = np.array(runtime.description.home)
        check_feasible(runtime.planner, self.native.get_waypoints(), home, np.random.default_rng(0))

    def get_state(self) -> TreeState:
        """Return the state of the objects of the task."""
        world = self.native.world
        bodies = {name: (body.pose, body.velocity) for name, body in world.bodies.items()}
        joints = {joint.name: joint.state() for body in world.bodies.values() for joint in body.joints.values()}
        return TreeState(bodies, joints, {name: frame.state() for name, frame in world.frames.items()})

    def restore_state(self, state: TreeState) -> None:
        """Restore the objects of the task; the arm does not move.

        Raises:
            TreeChanged: The objects of the task have changed (also a RuntimeError).
        """
        world = self.native.world
        if set(world.bodies) != set(state.bodies):
            changed = ", ".join(sorted(set(world.bodies) ^ set(state.bodies)))
            raise TreeChanged(
                f"The task had {len(state.bodies)} objects and has {len(world.bodies)} now (other: {changed}). "
                "Remove what was created, then restore."
            )
        for name, (parent, local) in state.frames.items():
            world.frame(name).set_state(parent, local)
        for name, (pose, velocity) in state.bodies.items():
            body = world.body(name)
            body.place(pose)
            if not body.fixed:
                body.set_velocity(velocity)
        for name, (position, speed) in state.joints.items():
            world.joint(name).set_state(position, speed)

    def cleanup_(self) -> None:
        """Clean up after an episode, if one was started."""
        self.native.end_episode()

    def clear_registerings(self) -> None:
        """Remove all registered conditions, graspable objects and functions."""
        native = self.native
        if isinstance(native, PaperTask):
            native.forget_registrations()
            return
        native.register_success_conditions([])
        native.register_fail_conditions([])
        native.register_graspable_objects([])
        native.register_waypoints_should_repeat(bool)
        for waypoint in native.get_waypoints():
            waypoint.set_hooks(None, None)

    def unload(self) -> None:
        """Remove the task and its registrations from the simulator."""
        native, self._native = self._native, None
        simulator = Simulator.running
        if native is not None and simulator is not None and simulator.runtime.task is native:
            simulator.unload()


def _world_name(item: Any) -> str:
    """Return the name in the world of an object, given as a view or a name; for a link or joint, the name of its body."""
    return (item if isinstance(item, str) else str(item.element.name)).partition("/")[0]


PLAIN_VALUES = (str, bytes, Number, np.ndarray, np.generic)
"""Types of values that are returned unchanged."""


def _attribute_of(native: object | None, name: str) -> Any:
    """Return the attribute `name` of a native task: an object of its scene as a view, a plain value unchanged.

    Args:
        native: The task, or None when it is not loaded.
        name: Public name of an attribute; its value may be a list or tuple of objects.

    Raises:
        AttributeError: There is no such attribute, or its value is of another type.
    """
    kept = {} if native is None or name.startswith("_") else vars(native)
    if name not in kept:
        raise AttributeError(name)
    return _view(kept[name], name)


def _view(value: Any, name: str) -> Any:
    """Return a value for programs; raise AttributeError with `name` if its type is internal."""
    if isinstance(value, list | tuple):
        return [_view(item, name) for item in value]
    if isinstance(value, Body | ObjectJoint | Frame):
        return view_of(
            Element("body" if isinstance(value, Body) else "joint" if isinstance(value, ObjectJoint) else "frame", value.name)
        )
    if isinstance(value, PLAIN_VALUES):
        return value
    raise AttributeError(name)
