"""Tasks with the API of RLBench, adapted to tasks of rlbench_pin.

`adapter_of` creates a native class from the class of a user. The native task calls the user's object for all methods that a
task file may override; methods that the user did not override call the native task.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, cast

import numpy as np

from rlbench_pin.compat.task_memory import GlobalDraws, SavedAttributes
from rlbench_pin.errors import TaskError
from rlbench_pin.observation import Observation
from rlbench_pin.scene.spec import ROOT, WORLD
from rlbench_pin.sim import World
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import LIBRARY, Task, Waypoint
from rlbench_pin.tasks.task import RotationBounds, snake_case
from rlbench_pin.tasks.waypoints import WaypointHook

if TYPE_CHECKING:
    from rlbench.backend.task import Task as UserTask

FIXED_ATTRIBUTES = ("pyrep", "robot", "name", "_native")
"""Attributes of a user's task that are not part of the state of an episode."""


class PaperTask(Task):
    """A native task that calls an object of a user's class; base of the classes of `adapter_of`.

    Args:
        world: The world that was built from the scene file of the user's task.
    """

    user_class: ClassVar[type[UserTask]]
    """Class of the user's task."""
    has_step: ClassVar[bool] = True
    """Whether that class defines `step`."""

    def __init__(self, world: World) -> None:
        super().__init__(world)
        self._user: SavedAttributes | None = None
        self._draws = GlobalDraws()
        self._placement: np.random.Generator | None = None
        self._made: tuple[str, ...] = ()

    @property
    def user(self) -> UserTask:
        """The user's task.

        Raises:
            TaskError: No user's task is connected yet.
        """
        if self._user is None:
            raise TaskError(
                f"Task '{self.get_name()}' has a world, but no object of {self.user_class.__name__}. "
                "Load it with `Environment.get_task(...)` or `Scene.load(...)` of the package `rlbench`."
            )
        return cast("UserTask", self._user.owner)

    def tie(self, user: UserTask) -> None:
        """Connect the user's task, whose views then refer to this world, and call its `init_task`."""
        self._user = SavedAttributes(user, FIXED_ATTRIBUTES)
        with self._draws.lent():
            user.load()
            user.set_initial_objects_in_scene()
            user.init_task()
        self._made = tuple(sorted(name for name in self.world.spawned if self._hangs_in_task(name)))

    def _hangs_in_task(self, name: str | None) -> bool:
        """Return whether a body or frame is a descendant of the root of the task."""
        while name not in (None, ROOT, WORLD):
            name = self.world.places.parent(str(name).partition("/")[0])
        return name == ROOT

    # Where objects are -------------------------------------------------------------------------------------------------

    def get_name(self) -> str:  # type: ignore[override]  # a user may name each object
        """Return the name of the user's task; before it is connected, that of its class in snake case."""
        return snake_case(self.user_class.__name__) if self._user is None else str(self.user.get_name())

    @classmethod
    def scene_file(cls) -> Path:
        """Return the scene file: in the folder of the user's module, with the name of the task or of the module.

        Without such a file, a class that is derived from a library task or has its name uses the scene of the library.

        Raises:
            SceneNotFound: There is no scene file.
        """
        name, module = snake_case(cls.user_class.__name__), module_file(cls.user_class)
        wanted = [module.with_name(f"{name}.toml")]
        if cls.user_class.library_name:
            wanted.append(cls.user_class.native_origin().scene_file())
        else:
            wanted += [module.with_suffix(".toml"), LIBRARY / f"{name}.toml"]
        found = [file for file in wanted if file.is_file()]
        if not found:
            raise SceneNotFound(cls.user_class.__name__, list(dict.fromkeys(wanted[:2])))
        return found[0]

    # What a task file overrides ---------------------------------------------------------------------------------------

    def init_task(self) -> None:
        """No effect: `tie` calls `init_task` of the user's task."""

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Set up an episode by the user's task; its draws from the global generators are seeded by `rng`."""
        self._draws.seed(int(rng.integers(2**32)))
        self._placement = rng
        try:
            with self._draws.lent():
                sentences = self.user.init_episode(variation)
        finally:
            self._placement = None
        return list(dict.fromkeys(sentences)) if isinstance(sentences, list | tuple) else sentences

    def origin_episode(self, variation: int) -> list[str]:
        """Set up an episode by the library task from which the user's class is derived."""
        rng = self._placement
        if rng is None:
            rng = np.random.default_rng(np.random.randint(2**31 - 1))  # noqa: NPY002
        return self.user_class.native_origin().init_episode(self, variation, rng)

    def variation_count(self) -> int:
        """Return the number of variations of the user's task."""
        return int(self.user.variation_count())

    def step(self) -> None:
        """Call `step` of the user's task, if it defines one."""
        if not self.has_step:
            super().step()
            return
        with self._draws.lent():
            self.user.step()

    def cleanup(self) -> None:
        """Call `cleanup` of the user's task."""
        with self._draws.lent():
            self.user.cleanup()

    def reward(self) -> float | None:
        """Return the shaped reward of the user's task; None if it has none."""
        return self.user.reward()

    def get_low_dim_state(self) -> FloatArray:
        """Return the state of the objects from the user's task, shape (n,)."""
        return np.asarray(self.user.get_low_dim_state(), dtype=float)

    def poses_of_made(self) -> FloatArray:
        """Return the poses of the shapes that the user's `init_task` added to the task, sorted by name; zeros if removed."""
        bodies = self.world.bodies
        return np.concatenate([np.zeros(0), *(bodies[name].pose if name in bodies else np.zeros(7) for name in self._made)])

    def decorate_observation(self, observation: Observation) -> Observation:
        """Return the observation as the user's task changes it."""
        return self.user.decorate_observation(observation)

    def is_static_workspace(self) -> bool:
        """Return whether the user's task has a fixed pose on the table."""
        return bool(self.user.is_static_workspace())

    def base_rotation_bounds(self) -> RotationBounds:
        """Return the bounds of the random rotation of the task root from the user's task [rad]."""
        low, high = self.user.base_rotation_bounds()
        return (float(low[0]), float(low[1]), float(low[2])), (float(high[0]), float(high[1]), float(high[2]))

    def success(self) -> tuple[bool, bool]:
        """Return whether the user's task is successful, and whether it ends the episode."""
        success, terminate = self.user.success()
        return bool(success), bool(terminate)

    def should_repeat_waypoints(self) -> bool:
        """Return whether the user's task repeats its waypoints."""
        with self._draws.lent():
            return super().should_repeat_waypoints()

    # Registrations ----------------------------------------------------------------------------------------------------

    def register_graspable_objects(self, names: Iterable[str]) -> None:
        """Allow the gripper to grasp these bodies, and remove registrations of bodies that no longer exist."""
        self._graspable = tuple(name for name in self._graspable if name in self.world.bodies)
        super().register_graspable_objects(names)

    def register_waypoint_ability_start(self, index: int, hook: WaypointHook) -> None:
        """Call `hook(waypoint)` before the segment to a waypoint is planned, with the random generators of this task."""
        super().register_waypoint_ability_start(index, self._drawing(hook))

    def register_waypoint_ability_end(self, index: int, hook: WaypointHook) -> None:
        """Call `hook(waypoint)` after the segment to a waypoint was executed, with the random generators of this task."""
        super().register_waypoint_ability_end(index, self._drawing(hook))

    def _drawing(self, hook: WaypointHook) -> WaypointHook:
        """Return a hook that calls `hook` with the random generators of this task."""

        def run(waypoint: Waypoint) -> None:
            with self._draws.lent():
                hook(waypoint)

        return run

    def forget_registrations(self) -> None:
        """Remove all registered conditions, graspable bodies and hooks."""
        self.register_success_conditions([])
        self.register_fail_conditions([])
        self.register_graspable_objects([])
        self._start_hooks, self._end_hooks, self._repeat, self._stop_at = {}, {}, None, None
        for waypoint in self.get_waypoints():
            waypoint.set_hooks(None, None)


class SceneNotFound(TaskError, FileNotFoundError):
    """A user's task has no scene file (TOML)."""

    def __init__(self, task: str, wanted: list[Path]) -> None:
        self.wanted = tuple(wanted)
        model = wanted[-1].with_suffix(".ttm")
        ttm = f" The model file '{model.name}' cannot be read: it belongs to another simulator." if model.is_file() else ""
        super().__init__(
            f"The task {task} has no scene file. Looked for {' and '.join(str(file) for file in wanted)}.{ttm} Write the scene "
            "as TOML beside the task file; `rlbench-pin new` makes an example, CONTRIBUTING.md explains it."
        )


def module_file(user: type) -> Path:
    """Return the file that defines a class.

    Raises:
        TaskError: The class was defined interactively, so there is no file.
    """
    try:
        return Path(inspect.getfile(user)).resolve()
    except (OSError, TypeError):
        pass
    for member in vars(user).values():
        if inspect.isfunction(member) and Path(member.__code__.co_filename).is_file():
            return Path(member.__code__.co_filename).resolve()
    raise TaskError(f"The task {user.__name__} was not read from a file. Write it to a .py file with its .toml scene beside it.")


@cache
def adapter_of(user: type[UserTask], has_step: bool) -> type[PaperTask]:
    """Return the native class that calls objects of a user's class; `has_step`: also after each tick."""
    origin = user.native_origin()
    bases = (PaperTask,) if origin is Task else (PaperTask, origin)
    namespace = {"user_class": user, "has_step": has_step, "__doc__": user.__doc__, "__module__": user.__module__}
    return cast("type[PaperTask]", type(user.__name__, bases, namespace))
