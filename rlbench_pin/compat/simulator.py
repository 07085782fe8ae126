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
    """One arm, and the world of the loaded task; without a task the world is an empty table.

    Args:
        robot: Name of the arm.

    Attributes:
        model: Analytic model of the arm.
        runtime: World, task and planner to which views refer; each `load` replaces it.
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
        """The world to which views refer."""
        return self.runtime.world

    def load(
        self,
        task: type[Task],
        config: ObservationConfig,
        kind: type[RuntimeT] = Runtime,  # type: ignore[assignment]
    ) -> RuntimeT:
        """Build the world of a task, replace the current world by it, and return the runtime, an object of class `kind`."""
        runtime = build_runtime(
            task,
            self.model,
            config,
            planning=self.planning,
            camera_places=self._camera_places,
            kind=kind,
        )
        before, self.runtime, self.objects = self.runtime, runtime, ObjectTable(runtime, config, self.objects)
        before.world.close()
        return runtime

    def unload(self) -> None:
        """Replace the current world by an empty table."""
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
        """World, task and planner."""

    @property
    def robot(self) -> Any:
        """Arm and gripper."""

    def step(self) -> None:
        """Advance one control tick."""

    def get_observation(self) -> Observation:
        """Return an observation without a simulation step."""

    def check_target_in_workspace(self, pos: FloatArray) -> bool:
        """Whether a target (3,) [m] is inside the workspace."""

    def prepare(self) -> None:
        """Prepare an episode; called before its objects are placed."""

    def place(self, rng: np.random.Generator) -> None:
        """Place the task at a random pose on the table, drawn from `rng`."""


class SceneRuntime(Runtime):
    """A runtime that steps and observes through a scene, so that overridden methods of the scene take effect."""

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
        """Set the random generators of an episode, and call `prepare` of the scene."""
        super().begin(variation, planning, noise)
        if self._scene is not None:
            self._scene.prepare()

    def place_task(self, rng: np.random.Generator) -> None:
        """Place the task at a random pose on the table, through the scene."""
        if self._scene is None:
            super().place_task(rng)
        else:
            self._scene.place(rng)

    def get_observation(self) -> Observation:
        """Return an observation without a simulation step, through the scene."""
        return self.observe() if self._scene is None else self._scene.get_observation()

    def observe(self) -> Observation:
        """Return an observation without a simulation step, not through the scene."""
        return super().get_observation()

    def check_target_in_workspace(self, position: FloatArray) -> None:
        """Raise InvalidActionError if `position` (3,) [m] is outside the workspace of the scene."""
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
    """Return the runtime of a scene; a runtime itself; for None the runtime of the simulator of this process.

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
