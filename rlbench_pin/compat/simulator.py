"""The simulator that all views look at: users of these names expect one per process, and to reach objects by their names."""

from __future__ import annotations

from typing import ClassVar

from rlbench_pin.compat.things import ObjectTable
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.observations import CameraPlaces
from rlbench_pin.environment.runtime import EmptyTable, Runtime, RuntimeT, build_runtime
from rlbench_pin.planning.planner import PlannerConfig
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import World
from rlbench_pin.tasks import Task


class Simulator:
    """One arm, and the world of the task that is loaded; before the first task an empty table.

    Args:
        robot: Name of the arm.

    Attributes:
        model: Analytic model of the arm.
        runtime: World, task and planner that views look at; another one after every `load`.
        objects: Names, handles and parents of everything in that world.
        planning: Settings of the planners that are built from now on.
    """

    running: ClassVar[Simulator | None] = None
    """The simulator of this process."""

    def __init__(self, robot: str = DEFAULT_ROBOT) -> None:
        self.model = RobotModel(robot_description(robot))
        self.planning, self._camera_places = PlannerConfig(), CameraPlaces()
        config = ObservationConfig()
        self.runtime: Runtime = build_runtime(EmptyTable, self.model, config, camera_places=self._camera_places)
        self.objects = ObjectTable(self.runtime, config)
        Simulator.running = self

    @classmethod
    def current(cls) -> Simulator:
        """Return the simulator of this process.

        Raises:
            RuntimeError: Nothing is launched.
        """
        if cls.running is None:
            raise RuntimeError("No simulator runs. Call `Environment.launch()` or `PyRep().launch()` first.")
        return cls.running

    @classmethod
    def make_current(cls, simulator: Simulator | None) -> None:
        """Let views look at `simulator` from now on; programs with several environments switch between theirs."""
        Simulator.running = simulator

    @property
    def world(self) -> World:
        """The world that views look at."""
        return self.runtime.world

    def load(
        self,
        task: type[Task],
        config: ObservationConfig,
        attach_grasped_objects: bool = True,
        kind: type[RuntimeT] = Runtime,  # type: ignore[assignment]
    ) -> RuntimeT:
        """Build the world of a task in place of the present one; the runtime is of class `kind`."""
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
        """Go back to the empty table."""
        self.load(EmptyTable, ObservationConfig())

    def close(self) -> None:
        """Free the world."""
        self.runtime.world.close()
        if Simulator.running is self:
            Simulator.running = None
