"""The simulator that all views refer to, and the runtime of a scene.

Programs for RLBench expect one simulator per process, and look up objects by name. All code that steps or observes the
runtime of a scene calls methods of the scene, so that subclasses of the scene can override them.
"""

from __future__ import annotations

from typing import Any, ClassVar, Protocol

import numpy as np

from rlbench_pin.compat.objects import ObjectTable
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.runtime import EmptyTable, Runtime, RuntimeT, build_runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.observation import Observation
from rlbench_pin.planning.planner import PlannerConfig
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import World
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Task


class Simulator:
    """One arm, and the world of the loaded task; before the first task an empty table.

    Args:
        robot: Name of the arm.

    Attributes:
        model: Analytic model of the arm.
        runtime: World, task and planner that views refer to; each `load` replaces it.
        objects: Names, handles and parents of all objects in that world.
        planning: Settings of planners that are created later.
    """

    running: ClassVar[Simulator | None] = None
    """The simulator of this process."""

    def __init__(self, robot: str = DEFAULT_ROBOT) -> None:
        self.model = RobotModel(robot_description(robot))
        self.planning = PlannerConfig()
        self._camera_places: dict[str, FloatArray] = {}
        config = ObservationConfig()
        self.runtime: Runtime = build_runtime(EmptyTable, self.model, config, camera_places=self._camera_places)
        self.objects = ObjectTable(self.runtime, config)
        Simulator.running = self

    @classmethod
    def current(cls) -> Simulator:
        """Return the simulator of this process.

        Raises:
            RuntimeError: No simulator is launched.
        """
        if cls.running is None:
            raise RuntimeError("No simulator is running. Call `Environment.launch()` or `PyRep().launch()` first.")
        return cls.running

    @classmethod
    def make_current(cls, simulator: Simulator | None) -> None:
        """Make views refer to `simulator`; programs with several environments switch between them."""
        Simulator.running = simulator

    @property
    def world(self) -> World:
        """The world that views refer to."""
        return self.runtime.world

    def load(
        self,
        task: type[Task],
        config: ObservationConfig,
        attach_grasped_objects: bool = True,
        kind: type[RuntimeT] = Runtime,  # type: ignore[assignment]
    ) -> RuntimeT:
        """Build the world of a task and replace the present one; the runtime has the class `kind`."""
        runtime = build_runtime(
            task,
            self.model,
            config,
            planning=self.planning,
            attach_grasped_objects=attach_grasped_objects,
            camera_places=self._camera_places,
            kind=kind,
        )
        before, self.runtime, self.objects = self.runtime, runtime, ObjectTable(runtime, config, self.objects)
        before.world.close()
        return runtime

    def unload(self) -> None:
        """Replace the present world by an empty table."""
        self.load(EmptyTable, ObservationConfig())

    def close(self) -> None:
        """Close the world."""
        self.runtime.world.close()
        if Simulator.running is self:
            Simulator.running = None


class SceneMethods(Protocol):
    """Methods of a scene that a runtime calls."""

    @property
    def runtime(self) -> Runtime:
        """World, task and planner together."""

    @property
    def robot(self) -> Any:
        """Arm and gripper."""

    def step(self) -> None:
        """Advance one control tick."""

    def get_observation(self) -> Observation:
        """Return an observation without a simulation step."""

    def check_target_in_workspace(self, pos: FloatArray) -> bool:
        """Whether a target (3,) [m] may be reached for."""

    def prepare(self) -> None:
        """Prepare an episode; called before its objects are placed, in the original world."""

    def place(self, rng: np.random.Generator) -> None:
        """Put the task at a random place on the table, drawn from `rng`."""


class SceneRuntime(Runtime):
    """A runtime for one scene. Code of this package and programs call the same methods of the scene."""

    _scene: SceneMethods | None = None

    def serve(self, scene: SceneMethods) -> None:
        """Step and observe through `scene` from now on."""
        self._scene = scene

    def step(self) -> None:
        """Advance one control tick, through the scene."""
        if self._scene is None:
            self.advance()
        else:
            self._scene.step()

    def advance(self) -> None:
        """Advance one control tick: physics, then the task's own step, then the callbacks."""
        super().step()

    def begin(self, variation: int, planning: np.random.Generator, noise: np.random.Generator) -> None:
        """Set the generators of an episode, and let the scene prepare it."""
        super().begin(variation, planning, noise)
        if self._scene is not None:
            self._scene.prepare()

    def place_task(self, rng: np.random.Generator) -> None:
        """Put the task at a random place on the table, through the scene."""
        if self._scene is None:
            super().place_task(rng)
        else:
            self._scene.place(rng)

    def get_observation(self) -> Observation:
        """Observe without stepping, through the scene."""
        return self.observe() if self._scene is None else self._scene.get_observation()

    def observe(self) -> Observation:
        """Observe without stepping."""
        return super().get_observation()

    def check_target_in_workspace(self, position: FloatArray) -> None:
        """Raise InvalidActionError when the scene says that `position` (3,) [m] is outside the workspace."""
        if self._scene is None or not self._scene.check_target_in_workspace(position):
            super().check_target_in_workspace(position)
        if self._scene is not None and not self._scene.check_target_in_workspace(position):
            x, y, z = position
            raise InvalidActionError(
                f"The target ({x:.4f}, {y:.4f}, {z:.4f}) m is outside the workspace of the scene. Choose a target inside."
            )


SceneLike = SceneMethods | Runtime
"""Argument of action modes: a scene, or a runtime itself."""


def runtime_of(scene: SceneLike | None) -> Runtime:
    """Return the runtime of a scene; of a runtime itself; of the simulator of this process when there is no scene.

    Raises:
        TypeError: `scene` has another type.
    """
    if scene is None:
        return Simulator.current().runtime
    if isinstance(scene, Runtime):
        return scene
    runtime = getattr(scene, "runtime", None)
    if not isinstance(runtime, Runtime):
        raise TypeError(
            f"An action mode takes a scene, not {type(scene).__name__}: `rlbench.backend.scene.Scene` or a class derived from it."
        )
    return runtime
