"""Base class of tasks: a goal in one world, set up once and started anew for every episode."""

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
    """Some of the numbers of a state."""

    name: str
    """`<body>`, or `<body>/<joint>`."""
    kind: Literal["pose", "slider", "hinge"]
    """Pose of a body (7 numbers, [m] and unit quaternion), or value of a joint that slides [m] or turns [rad]."""

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return 7 if self.kind == "pose" else 1


def low_dim_layout(spec: SceneSpec) -> tuple[LowDimPart, ...]:
    """Return what the default state of a scene holds, in order: the bodies by name, then their movable joints by name."""
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
    """Reads the pose of every body of a world and the value of every joint, in the order of their names.

    The layout is fixed by the scene file: a body that was removed gives zeros, one that an episode adds is left out.
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
"""Kind of sentences, see `InstructionsSpec`."""
RotationBounds = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Lowest and highest roll, pitch, yaw [rad]."""


class Task:
    """Base class of all tasks. Override `init_task` and `init_episode`; the rest is optional.

    What varies from episode to episode is drawn from the generator that `init_episode` is given and from nothing else.

    Every attribute is saved and restored with the world, and so must be one of:

    * a number, a string, None, a function, a frozen record;
    * an array, or a list, tuple, dict or set of what is named here: its contents are saved;
    * what the world hands out (bodies, joints, frames, regions, sensors): the world saves it;
    * an object with `state()` and `set_state(state)`, such as a condition or a `SpawnBoundary`: these two are used.

    Anything else is refused with a TaskError when an episode begins.

    Args:
        world: The world that was built from the scene file of this task.

    Attributes:
        world: The world: `body`, `joint`, `frame`, `region`, `sensor` by name.
        robot: The arm.
        gripper: The gripper.
        round: How often the waypoints were played, for tasks that call `register_rounds`.
    """

    solved_by_chance: ClassVar[bool] = False
    """Whether a randomly moving arm may reach the goal now and then, as with a ball in the air; otherwise that is a fault."""
    variations_share_goals: ClassVar[bool] = False
    """Whether some variations ask for the same, in the same words; otherwise that is a fault."""

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
        """Look objects up and register what never changes; called once, when the world was built."""
        raise NotImplementedError

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Lay out one episode of one variation; called at each try of a reset, in a clean world, before the task is placed.

        Args:
            variation: 0 to `variation_count() - 1`.
            rng: The only random generator to draw from.

        Returns:
            Sentences that all ask for the goal.
        """
        raise NotImplementedError

    def variation_count(self) -> int:
        """Return how many variations there are; one unless a task says otherwise. Always the same number."""
        return 1

    def step(self) -> None:
        """Run after every control tick of an action or a demonstration; not while objects settle in a reset."""

    def cleanup(self) -> None:
        """Run after an episode, when the next one begins, before the world is put back."""

    def reward(self) -> float | None:
        """Return the shaped reward of this instant, None when the task has none; asked by steps with `shaped_rewards=True`."""
        return None

    def get_low_dim_state(self) -> FloatArray:
        """Return `task_low_dim_state` (k,); by default the poses of all bodies by name, then all joint values by name."""
        return self._low_dim.read()

    def decorate_observation(self, observation: Observation) -> Observation:
        """Return the observation, perhaps with more in it; called last, for every observation."""
        return observation

    def is_static_workspace(self) -> bool:
        """Return whether the task root stays at its nominal place; by default what `[placement]` says. Asked in every reset."""
        return self.world.spec.placement.static

    def base_rotation_bounds(self) -> RotationBounds:
        """Return the bounds of the random rotation of the task root [rad]; by default `[placement] yaw`, about z alone."""
        low, high = self.world.spec.placement.yaw
        return (0.0, 0.0, low), (0.0, 0.0, high)

    # What a task file calls ---------------------------------------------------------------------------------------------

    def register_success_conditions(self, conditions: Sequence[Condition]) -> None:
        """Success is all of these at the same instant. Replaces what was registered before."""
        self._success = tuple(conditions)

    def register_fail_conditions(self, conditions: Sequence[Condition]) -> None:
        """All of these at the same instant end the episode without success. Replaces what was registered before."""
        self._fail = tuple(conditions)

    def register_graspable_objects(self, names: Iterable[str]) -> None:
        """Allow the gripper to hold these bodies, where both fingers touch them. Replaces what was registered before.

        Args:
            names: `body`, or `body/link` for a body that may be held by that link alone.
        """
        wanted = tuple(names)
        parts = [graspable_part(self.world, name) for name in wanted]
        for name in self._graspable:
            graspable_part(self.world, name)[0].graspable = False
        for body, _ in parts:
            body.graspable, body.grasp_links = True, tuple(link for other, link in parts if other is body and link)
        self._graspable = wanted

    def register_waypoint_ability_start(self, index: int, hook: WaypointHook) -> None:
        """Call `hook(waypoint)` before the segment to a waypoint is planned; where waypoints repeat, resets call it as well."""
        self._start_hooks[self._checked(index)] = hook
        self._waypoints[index].set_hooks(hook, self._end_hooks.get(index))

    def register_waypoint_ability_end(self, index: int, hook: WaypointHook) -> None:
        """Call `hook(waypoint)` after the segment to a waypoint was run and the gripper has acted."""
        self._end_hooks[self._checked(index)] = hook
        self._waypoints[index].set_hooks(self._start_hooks.get(index), hook)

    def register_waypoints_should_repeat(self, repeat: Callable[[], bool]) -> None:
        """Ask `repeat` after the last waypoint whether to play the list again; it may also advance a counter."""
        self._repeat = repeat

    def register_rounds(self, count: int) -> None:
        """Play the waypoints `count` times; `self.round` is 0 in the first round, and one more in each that follows."""
        self.round = 0
        self._rounds = count
        self.register_waypoints_should_repeat(self._next_round)

    def _next_round(self) -> bool:
        self.round += 1
        return self.round < self._rounds

    def register_stop_at_waypoint(self, index: int) -> None:
        """Leave out waypoint `index` and all later ones."""
        self._stop_at = self._checked(index)

    def make_instructions(self, **words: object) -> list[str]:
        """Return the training sentences of `[instructions]` in the scene file; `get_wording` returns the other kinds.

        Args:
            words: What `{word}` stands for in this variation.

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
        """Return the scene file: the neighbour of the task file with the same stem."""
        return Path(inspect.getfile(cls)).with_suffix(".toml")

    def begin_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Lay out one episode in a clean world and return its instructions.

        Raises:
            TaskError: The variation does not exist, the task does not return a list of different sentences, or it keeps an
                attribute that cannot be saved.
        """
        count = self.variation_count()
        if not 0 <= variation < count:
            raise TaskError(f"Task '{self.get_name()}' has no variation {variation}; it has 0 to {count - 1}.")
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
        """Put the whole task somewhere on the table; called after `init_episode` unless it is to stay."""
        place_task(self.world, rng, self.base_rotation_bounds())

    def end_episode(self) -> None:
        """Clean up after an episode, if one was begun."""
        if self._started:
            self._started = False
            self.cleanup()

    def reset_conditions(self) -> None:
        """Let every condition start from the present instant."""
        for condition in (*self._success, *self._fail):
            condition.reset()

    def success(self) -> tuple[bool, bool]:
        """Return whether the goal is reached, and whether the episode is over.

        Every condition is evaluated on every call, so that those which keep count see every instant.

        Raises:
            TaskError: No success condition is registered.
        """
        if not self._success:
            raise TaskError(f"Task '{self.get_name()}' registers no success condition; call register_success_conditions.")
        failed = [condition.met() for condition in self._fail]
        if failed and all(failed):
            return False, True
        met = [condition.met() for condition in self._success]
        return all(met), all(met)

    def get_success_conditions(self) -> tuple[Condition, ...]:
        """Return what has to be met for success."""
        return self._success

    def get_wording(self, kind: Wording) -> tuple[str, ...]:
        """Return the sentences of one kind for the present episode; none when the scene file has none of that kind.

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
        """Whether the task may ask for its waypoints again."""
        return self._repeat is not None

    def should_repeat_waypoints(self) -> bool:
        """Return whether the waypoint list is to be played again; asked once after the last waypoint."""
        return self._repeat is not None and bool(self._repeat())

    def state(self) -> TaskState:
        """Return everything that changes during an episode.

        Raises:
            TaskError: An attribute is of a kind that cannot be saved.
        """
        changing = {name: value for name, value in vars(self).items() if name not in _FIXED}
        return TaskState(self.get_name(), remember(self.get_name(), changing))

    def set_state(self, state: TaskState | PortableTaskState) -> None:
        """Go back to a state of this task object, or to one of another process whose episode has begun here, too."""
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
            raise TaskError(f"Task '{self.get_name()}' has no waypoint {index}; its scene has {len(self._waypoints)}.")
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
"""Attributes that are the same throughout the life of a task."""


def snake_case(name: str) -> str:
    """Turn `ReachTarget` into `reach_target`."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
