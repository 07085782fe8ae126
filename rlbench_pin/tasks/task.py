"""Base class of tasks: a goal in one world, set up once, with a new start in each episode."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from rlbench_pin.errors import TaskError
from rlbench_pin.scene.reader import resolve_asset
from rlbench_pin.scene.spec import InstructionsSpec, SceneSpec
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks.conditions import Condition
from rlbench_pin.tasks.grasps import graspable_part
from rlbench_pin.tasks.placement import place_task
from rlbench_pin.tasks.saved.portable_state import Memory, PortableTaskState, TaskState, recall, remember, take_over
from rlbench_pin.tasks.waypoints import Waypoint, WaypointHook, waypoints_of
from rlbench_pin.urdf import read_urdf

if TYPE_CHECKING:
    from rlbench_pin.observation import Observation
    from rlbench_pin.sim import Body, World


@dataclass(frozen=True)
class LowDimPart:
    """A part of the values of a state."""

    name: str
    """`<body>`, or `<body>/<joint>`."""
    kind: Literal["pose", "slider", "hinge"]
    """Pose of a body (7 values, [m] and unit quaternion), or value of a prismatic [m] or revolute [rad] joint."""

    @property
    def size(self) -> int:
        """Number of values."""
        return 7 if self.kind == "pose" else 1


def low_dim_layout(spec: SceneSpec) -> tuple[LowDimPart, ...]:
    """Return the parts of the default state of a scene, in order: bodies by name, then their movable joints by name."""
    bodies = sorted(body.name for body in spec.body)
    joints = sorted(
        (f"{body.name}/{joint.name}", joint.kind)
        for body in spec.body
        for joint in read_urdf(resolve_asset(spec, body.asset)).joints
        if joint.kind != "fixed"
    )
    poses = [LowDimPart(name, "pose") for name in bodies]
    return (*poses, *(LowDimPart(name, "slider" if kind == "prismatic" else "hinge") for name, kind in joints))


class LowDimState:
    """Reads the poses of all bodies of a world and the values of all joints, in the order of their names.

    The scene file defines the layout: a removed body gives zeros, and a body that an episode adds is omitted.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._layout = low_dim_layout(world.spec)

    def read(self) -> FloatArray:
        """Return poses (7 each, [m] and unit quaternion), then joint values [m] or [rad]."""
        present = self._world.bodies
        parts = [self._value(part, present.get(part.name.split("/")[0])) for part in self._layout]
        return np.concatenate(parts) if parts else np.zeros(0)

    def _value(self, part: LowDimPart, body: Body | None) -> FloatArray:
        if body is None:
            return np.zeros(part.size)
        return body.pose if part.kind == "pose" else np.array([float(self._world.joint(part.name).position)])


Wording = Literal["training", "held_out", "vague", "specific"]
"""Kind of instructions, see `InstructionsSpec`."""
RotationBounds = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Lowest and highest roll, pitch, yaw [rad]."""


class Task:
    """Base class of all tasks. Override `init_task` and `init_episode`; the rest is optional.

    All random draws of an episode use the generator that `init_episode` gets, and no other.

    All attributes are saved and restored with the world, so each must be one of:

    * a number, a string, None, a function, a frozen record;
    * an array, or a list, tuple, dict or set of the types in this list: its contents are saved;
    * an object of the world (body, joint, frame, region, sensor): the world saves it;
    * an object with `state()` and `set_state(state)`, such as a condition or a `SpawnBoundary`: these methods are used.

    Other types raise a TaskError at the start of an episode.

    Args:
        world: The world of the scene file of this task.

    Attributes:
        world: The world: `body`, `joint`, `frame`, `region`, `sensor` by name.
        robot: The arm.
        gripper: The gripper.
        round: Number of completed rounds through the waypoints, for tasks that call `register_rounds`.
    """

    solved_by_chance: ClassVar[bool] = False
    """Whether random motion may sometimes reach the goal, as with a ball in the air; otherwise checks report it as a fault."""
    variations_share_goals: ClassVar[bool] = False
    """Whether some variations have the same instructions; otherwise checks report it as a fault."""

    def __init__(self, world: World) -> None:
        self.world, self.robot, self.gripper = world, world.robot, world.gripper
        self._success: tuple[Condition, ...] = ()
        self._fail: tuple[Condition, ...] = ()
        self._graspable: tuple[str, ...] = ()
        self._start_hooks: dict[int, WaypointHook] = {}
        self._end_hooks: dict[int, WaypointHook] = {}
        self._repeat: Callable[[], bool] | None = None
        self._stop_at: int | None = None
        self.round = self._rounds = 0
        self._started = False
        self._wording: dict[str, tuple[str, ...]] = {}
        self._waypoints = waypoints_of(world)
        self._low_dim = LowDimState(world)

    # What a task file overrides ---------------------------------------------------------------------------------------

    def init_task(self) -> None:
        """Look up objects and register constant conditions and hooks; called once, after the world is built."""
        raise NotImplementedError

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Set up one episode of one variation; called at each attempt of a reset, in a clean world, before the task is placed.

        Args:
            variation: 0 to `variation_count() - 1`.
            rng: The only random generator to draw from.

        Returns:
            Instructions; each describes the goal.
        """
        raise NotImplementedError

    def variation_count(self) -> int:
        """Return the number of variations, by default one. The number must be constant."""
        return 1

    def step(self) -> None:
        """Run after each control tick of an action or a demonstration; not while objects settle in a reset."""

    def cleanup(self) -> None:
        """Run after an episode, at the start of the next one, before the world is restored."""

    def reward(self) -> float | None:
        """Return the shaped reward of this instant, None if the task has none; called by steps with `shaped_rewards=True`."""
        return None

    def get_low_dim_state(self) -> FloatArray:
        """Return `task_low_dim_state` (k,); by default the poses of all bodies by name, then all joint values by name."""
        return self._low_dim.read()

    def decorate_observation(self, observation: Observation) -> Observation:
        """Return the observation, with additions if the task needs them; called last, for each observation."""
        return observation

    def is_static_workspace(self) -> bool:
        """Return whether the task root stays at its nominal pose; by default the value in `[placement]`. Called in each reset."""
        return self.world.spec.placement.static

    def base_rotation_bounds(self) -> RotationBounds:
        """Return the bounds of the random rotation of the task root [rad]; by default `[placement] yaw`, only about z."""
        low, high = self.world.spec.placement.yaw
        return (0.0, 0.0, low), (0.0, 0.0, high)

    # What a task file calls ---------------------------------------------------------------------------------------------

    def register_success_conditions(self, conditions: Sequence[Condition]) -> None:
        """Set the success conditions, which must all hold at the same instant. Replaces an earlier registration."""
        self._success = tuple(conditions)

    def register_fail_conditions(self, conditions: Sequence[Condition]) -> None:
        """Set the fail conditions; if all hold at one instant, the episode ends in failure. Replaces an earlier registration."""
        self._fail = tuple(conditions)

    def register_graspable_objects(self, names: Iterable[str]) -> None:
        """Allow the gripper to hold these bodies when both fingers touch them. Replaces an earlier registration.

        Args:
            names: `body`, or `body/link` for a body that may be held only by that link.
        """
        wanted = tuple(names)
        parts = [graspable_part(self.world, name) for name in wanted]
        for name in self._graspable:
            graspable_part(self.world, name)[0].graspable = False
        for body, _ in parts:
            body.graspable, body.grasp_links = True, tuple(link for other, link in parts if other is body and link)
        self._graspable = wanted

    def register_waypoint_ability_start(self, index: int, hook: WaypointHook) -> None:
        """Call `hook(waypoint)` before the segment to a waypoint is planned; if waypoints repeat, resets call it too."""
        self._start_hooks[self._checked(index)] = hook
        self._waypoints[index].set_hooks(hook, self._end_hooks.get(index))

    def register_waypoint_ability_end(self, index: int, hook: WaypointHook) -> None:
        """Call `hook(waypoint)` after the segment to a waypoint and the action of the gripper."""
        self._end_hooks[self._checked(index)] = hook
        self._waypoints[index].set_hooks(self._start_hooks.get(index), hook)

    def register_waypoints_should_repeat(self, repeat: Callable[[], bool]) -> None:
        """Call `repeat` after the last waypoint; it returns whether to play the list again, and may advance a counter."""
        self._repeat = repeat

    def register_rounds(self, count: int) -> None:
        """Play the waypoints `count` times; `self.round` is 0 in the first round and increases by 1 in each further round."""
        self.round = 0
        self._rounds = count
        self.register_waypoints_should_repeat(self._next_round)

    def _next_round(self) -> bool:
        self.round += 1
        return self.round < self._rounds

    def register_stop_at_waypoint(self, index: int) -> None:
        """Omit waypoint `index` and all later ones."""
        self._stop_at = self._checked(index)

    def make_instructions(self, **words: object) -> list[str]:
        """Return the training instructions of `[instructions]` in the scene file; `get_wording` returns the other kinds.

        Args:
            words: Replacement of each `{word}` in this variation.

        Raises:
            TaskError: A sentence needs another word, or there is no sentence.
        """
        spec = self.world.spec.instructions
        self._wording = {kind: _filled(self.get_name(), getattr(spec, kind), words) for kind in InstructionsSpec.model_fields}
        if not self._wording["training"]:
            raise TaskError(f"The scene of task '{self.get_name()}' has no sentences. Add `[instructions]` with `training`.")
        return list(self._wording["training"])

    # What the environment calls -------------------------------------------------------------------------------------

    @classmethod
    def get_name(cls) -> str:
        """Return the name of the task in snake case."""
        return snake_case(cls.__name__)

    @classmethod
    def scene_file(cls) -> Path:
        """Return the scene file: the file with the same stem in the folder of the task file."""
        return Path(inspect.getfile(cls)).with_suffix(".toml")

    def begin_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Set up one episode in a clean world and return its instructions.

        Raises:
            TaskError: The variation does not exist, the task does not return a list of different sentences, or it has an
            attribute that cannot be saved.
        """
        count = self.variation_count()
        if not 0 <= variation < count:
            raise TaskError(f"Task '{self.get_name()}' has no variation {variation}. Choose 0 to {count - 1}.")
        self._started = True
        self._wording = {}
        for waypoint in self._waypoints:
            waypoint.skip = False
        instructions = self.init_episode(variation, rng)
        self._check_instructions(instructions)
        self.reset_conditions()
        self.state()  # an attribute that cannot be saved is found here, not at the first save
        return instructions

    def place(self, rng: np.random.Generator) -> None:
        """Move the whole task to a random pose on the table; called after `init_episode` unless the workspace is static."""
        place_task(self.world, rng, self.base_rotation_bounds())

    def end_episode(self) -> None:
        """Clean up after an episode, if one has started."""
        if self._started:
            self._started = False
            self.cleanup()

    def reset_conditions(self) -> None:
        """Reset all conditions at the present instant."""
        for condition in (*self._success, *self._fail):
            condition.reset()

    def success(self) -> tuple[bool, bool]:
        """Return whether the goal is reached, and whether the episode is over.

        Each call evaluates all conditions, so that conditions with a memory see each instant.

        Raises:
            TaskError: No success condition is registered.
        """
        if not self._success:
            raise TaskError(
                f"Task '{self.get_name()}' registers no success condition. "
                "Call `register_success_conditions` in `init_task` or `init_episode`."
            )
        failed = [condition.met() for condition in self._fail]
        if failed and all(failed):
            return False, True
        met = [condition.met() for condition in self._success]
        return all(met), all(met)

    def get_success_conditions(self) -> tuple[Condition, ...]:
        """Return the success conditions."""
        return self._success

    def get_wording(self, kind: Wording) -> tuple[str, ...]:
        """Return the instructions of one kind for the present episode; an empty result if the scene file has none of that kind.

        Args:
            kind: `training`, `held_out`, `vague` or `specific`.
        """
        return self._wording.get(kind, ())

    def get_graspable_objects(self) -> tuple[str, ...]:
        """Return the names of the bodies that the gripper may hold."""
        return tuple(dict.fromkeys(name.partition("/")[0] for name in self._graspable))

    def get_waypoints(self) -> list[Waypoint]:
        """Return the waypoints in order, up to the stop index."""
        return self._waypoints[: self._stop_at]

    @property
    def repeats_waypoints(self) -> bool:
        """Whether the task may repeat its waypoints."""
        return self._repeat is not None

    def should_repeat_waypoints(self) -> bool:
        """Return whether to play the waypoint list again; called once after the last waypoint."""
        return self._repeat is not None and bool(self._repeat())

    def state(self) -> TaskState:
        """Return all state that changes during an episode.

        Raises:
            TaskError: An attribute has a type that cannot be saved.
        """
        changing = {name: value for name, value in vars(self).items() if name not in _FIXED}
        return TaskState(self.get_name(), remember(self.get_name(), changing))

    def set_state(self, state: TaskState | PortableTaskState) -> None:
        """Restore a state of this task object, or of another process if its episode has been set up here."""
        for name in [name for name in vars(self) if name not in _FIXED and name not in state.attributes]:
            delattr(self, name)
        for name, memory in state.attributes.items():
            if isinstance(memory, Memory):
                setattr(self, name, recall(memory))
            else:
                setattr(self, name, take_over(memory, vars(self).get(name), self.world, f"self.{name}"))
        for waypoint in self._waypoints:
            waypoint.set_hooks(self._start_hooks.get(waypoint.index), self._end_hooks.get(waypoint.index))
        self.register_graspable_objects(self._graspable)

    def _checked(self, index: int) -> int:
        if not 0 <= index < len(self._waypoints):
            raise TaskError(
                f"Task '{self.get_name()}' has no waypoint {index}; its scene has {len(self._waypoints)}. "
                "Add it to the scene file, or choose another index."
            )
        return index

    def _check_instructions(self, instructions: object) -> None:
        given = instructions if isinstance(instructions, list) else []
        sentences = {s for s in given if isinstance(s, str) and s.strip()}
        if not sentences or len(sentences) < len(given):
            raise TaskError(
                f"init_episode of task '{self.get_name()}' must return a list of different sentences, not {instructions!r}."
            )


def _filled(task: str, sentences: Sequence[str], words: Mapping[str, object]) -> tuple[str, ...]:
    try:
        filled = [sentence.format_map(words) for sentence in sentences]
    except (KeyError, ValueError, IndexError, AttributeError) as error:
        known = ", ".join(sorted(words)) or "none"
        raise TaskError(f"A sentence of task '{task}' cannot be filled in: {error}. Words of this task: {known}.") from error
    return tuple(sentence[:1].upper() + sentence[1:] for sentence in filled)


_FIXED = frozenset({"world", "robot", "gripper", "_low_dim"})
"""Attributes that do not change during the lifetime of a task."""


def snake_case(name: str) -> str:
    """Convert `ReachTarget` to `reach_target`."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
