"""Arms: kinematics, collisions, and paths through the world as it is now."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyrep.const import ConfigurationPathAlgorithms as Algos
from pyrep.errors import ConfigurationPathError
from pyrep.objects.cartesian_path import CartesianPath
from pyrep.objects.object import Object
from pyrep.robots.arms.kinematic_arm import KinematicArm
from pyrep.robots.configuration_paths.arm_configuration_path import ArmConfigurationPath
from rlbench_pin.compat import arm_planning
from rlbench_pin.compat.arm_planning import Pace
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning import Plan
from rlbench_pin.spatial import FloatArray

Numbers = Sequence[float] | FloatArray
CURVE_POINTS = 50
"""How many poses of a Cartesian path the tip is led through."""


class Arm(KinematicArm):
    """The arm of the running world.

    Poses are of the tip, in the world or in the frame of `relative_to`: a position (3,) [m] and either Euler angles (3,) [rad]
    or a quaternion (x, y, z, w).

    Args:
        count: Which arm of this kind; a world has one.
        name: Name of the arm.
        num_joints: How many joints it has.
        base_name: Name of the object that carries it; None is `name`.
        max_velocity: No joint is faster in paths [rad/s].
        max_acceleration: No joint accelerates more in paths [rad/s^2].
        max_jerk: Accelerations change no faster in paths [rad/s^3]; from 1000 on they may jump.

    Attributes:
        joints: The joints, from base to wrist.
    """

    def __init__(
        self,
        count: int,
        name: str,
        num_joints: int,
        base_name: str | None = None,
        max_velocity: float = 1.0,
        max_acceleration: float = 4.0,
        max_jerk: float = 1000,
    ) -> None:
        super().__init__(count, name, num_joints, base_name)
        self.max_velocity, self.max_acceleration, self.max_jerk = max_velocity, max_acceleration, max_jerk

    @property
    def pace(self) -> Pace:
        """How fast paths are."""
        return Pace(self.max_velocity, self.max_acceleration, self.max_jerk)

    # Paths -----------------------------------------------------------------------------------------------------------

    def get_path(
        self,
        position: Numbers,
        euler: Numbers | None = None,
        quaternion: Numbers | None = None,
        ignore_collisions: bool = False,
        trials: int = 300,
        max_configs: int = 1,
        distance_threshold: float = 0.65,
        max_time_ms: int = 10,
        trials_per_goal: int = 1,
        algorithm: Algos = Algos.SBL,
        relative_to: Object | None = None,
    ) -> ArmConfigurationPath:
        """Plan a timed path to a pose: along a straight line of the tip if that is free, otherwise around obstacles.

        Args:
            position: See the class.
            euler: See the class.
            quaternion: See the class.
            ignore_collisions: Plan as if nothing could be touched. Otherwise what the arm touches already may be touched.
            trials: Accepted; our planner has a budget of its own, as for the next four.
            max_configs: Accepted.
            distance_threshold: Accepted.
            max_time_ms: Accepted.
            trials_per_goal: Accepted.
            algorithm: Searches around obstacles; names that `arm_planning.ALGORITHMS` lacks mean our RRT-Connect.
            relative_to: See the class.

        Raises:
            ConfigurationPathError: There is no path.
        """
        return self._path((position, euler, quaternion, relative_to), None, ignore_collisions, algorithm)

    def get_linear_path(
        self,
        position: Numbers,
        euler: Numbers | None = None,
        quaternion: Numbers | None = None,
        steps: int = 50,
        ignore_collisions: bool = False,
        relative_to: Object | None = None,
    ) -> ArmConfigurationPath:
        """Plan a timed path along the straight line of the tip to a pose; `steps` is accepted, our lines are as fine as needed.

        Raises:
            ConfigurationPathError: The line cannot be followed.
        """
        return self._path((position, euler, quaternion, relative_to), True, ignore_collisions)

    def get_nonlinear_path(
        self,
        position: Numbers,
        euler: Numbers | None = None,
        quaternion: Numbers | None = None,
        ignore_collisions: bool = False,
        trials: int = 300,
        max_configs: int = 1,
        distance_threshold: float = 0.65,
        max_time_ms: int = 10,
        trials_per_goal: int = 1,
        algorithm: Algos = Algos.SBL,
        relative_to: Object | None = None,
    ) -> ArmConfigurationPath:
        """Plan a timed path to a pose without trying the straight line of the tip; the arguments are those of `get_path`.

        Raises:
            ConfigurationPathError: There is no path.
        """
        return self._path((position, euler, quaternion, relative_to), False, ignore_collisions, algorithm)

    def get_path_from_cartesian_path(self, path: CartesianPath) -> ArmConfigurationPath:
        """Plan a timed path that leads the tip from where it is along a Cartesian path; collisions do not count.

        Raises:
            ConfigurationPathError: The arm cannot follow it.
        """
        poses = []
        for share in np.linspace(0.0, 1.0, CURVE_POINTS):
            position, euler = path.get_pose_on_path(float(share))
            poses.append(arm_planning.world_pose(position, euler, None))
        try:
            return self._timed(arm_planning.plan_along(Simulator.current().runtime, poses))
        except PlanningError as error:
            raise ConfigurationPathError(f"The arm cannot follow the Cartesian path: {error}") from error

    def _path(
        self,
        target: tuple[Numbers, Numbers | None, Numbers | None, Object | None],
        straight: bool | None,
        ignore_collisions: bool,
        algorithm: Algos = Algos.SBL,
    ) -> ArmConfigurationPath:
        try:
            pose = arm_planning.world_pose(*target)
            plan = arm_planning.plan_to(
                Simulator.current(), pose, straight=straight, ignore_collisions=ignore_collisions, algorithm=algorithm.name
            )
            return self._timed(plan)
        except (PlanningError, ValueError) as error:
            raise ConfigurationPathError(f"No path to the pose: {error}") from error

    def _timed(self, plan: Plan) -> ArmConfigurationPath:
        trajectory = arm_planning.paced(Simulator.current().runtime, plan, self.pace)
        return ArmConfigurationPath(self, plan.path.ravel(), trajectory)
