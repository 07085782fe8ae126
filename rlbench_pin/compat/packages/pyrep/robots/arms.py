"""Arms: kinematics, collisions, and paths through the world as it is now.

A program has the arm of `robot_setup` of its environment; the construction of another arm raises an error. Programs
import a module per arm; all these names are aliases of this module.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from pyrep.const import ConfigurationPathAlgorithms as Algos
from pyrep.errors import ConfigurationError, ConfigurationPathError, IKError, UnsupportedCall
from pyrep.objects import CartesianPath, Dummy, Object
from pyrep.robots import Numbers, RobotComponent
from pyrep.robots.configuration_paths import ArmConfigurationPath
from rlbench_pin.compat import add_aliases, arm_planning
from rlbench_pin.compat.arm_planning import Pace
from rlbench_pin.compat.joints import ArmMotors
from rlbench_pin.compat.objects import Element
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning import Plan
from rlbench_pin.spatial import FloatArray

ROBOT_KINDS = ("robot", "gripper", "tip", "robot_link", "robot_joint")
"""Kinds of elements that belong to the robot."""
CURVE_POINTS = 50
"""Number of poses for the sampling of a Cartesian path."""


class Arm(RobotComponent):
    """The arm of the current world.

    Poses are tip poses in the world or in the frame of `relative_to`: a position (3,) [m] and either Euler angles (3,) [rad]
    or a quaternion (x, y, z, w).

    Args:
        count: Index of the arm; only 0 is possible, since a world has one arm.
        name: Name of the arm.
        num_joints: Number of joints.
        base_name: Name of the base object; None is `name`.
        max_velocity: Maximum joint velocity in paths [rad/s].
        max_acceleration: Maximum joint acceleration in paths [rad/s^2].
        max_jerk: Maximum jerk in paths [rad/s^3]; from 1000 on there is no limit.

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
        super().__init__(count, name, [f"{name}_joint{i + 1}" for i in range(num_joints)], base_name)
        self._tip_name = f"{name}_tip"
        self.max_velocity, self.max_acceleration, self.max_jerk = max_velocity, max_acceleration, max_jerk

    @property
    def pace(self) -> Pace:
        """Limits of velocity, acceleration and jerk in paths."""
        return Pace(self.max_velocity, self.max_acceleration, self.max_jerk)

    @property
    def motors(self) -> ArmMotors:
        """The motors of the joints."""
        return ArmMotors()

    def get_tip(self) -> Dummy:
        """Return the tip: the frame between the fingers, with z out of the gripper."""
        return Dummy(Element("tip", self._tip_name))  # faster than by name: programs call this at each step

    def get_jacobian(self) -> FloatArray:
        """Return the Jacobian (n, 6) of the tip at the current configuration, in world axes.

        Row i is the `[linear, angular]` velocity of the tip per unit velocity of joint i, so
        `arm.get_jacobian().T @ joint_velocities` is the velocity (6,) of the tip.
        """
        runtime = Simulator.current().runtime
        return runtime.model.jacobian(runtime.robot.joint_positions).T.copy()

    # Inverse kinematics ----------------------------------------------------------------------------------------------

    def solve_ik_via_jacobian(
        self,
        position: Numbers,
        euler: Numbers | None = None,
        quaternion: Numbers | None = None,
        relative_to: Object | None = None,
    ) -> list[float]:
        """Return joint positions [rad] for a pose, found by iteration from the current configuration.

        Raises:
            IKError: The iteration does not reach the pose, or the pose is invalid.
        """
        try:
            pose = arm_planning.world_pose(position, euler, quaternion, relative_to)
            return arm_planning.nearest_configuration(Simulator.current().runtime, pose).tolist()
        except (PlanningError, ValueError) as error:
            raise IKError(f"No joint positions near the present ones reach the pose: {error}") from error

    def solve_ik(
        self,
        position: Numbers,
        euler: Numbers | None = None,
        quaternion: Numbers | None = None,
        relative_to: Object | None = None,
    ) -> list[float]:
        """Return the result of `solve_ik_via_jacobian`, of which this is the older name."""
        return self.solve_ik_via_jacobian(position, euler, quaternion, relative_to)

    def solve_ik_via_sampling(
        self,
        position: Numbers,
        euler: Numbers | None = None,
        quaternion: Numbers | None = None,
        ignore_collisions: bool = False,
        trials: int = 300,
        max_configs: int = 1,
        distance_threshold: float = 0.65,
        max_time_ms: int = 10,
        relative_to: Object | None = None,
    ) -> FloatArray:
        """Return up to `max_configs` different configurations for a pose, shape (found, n) [rad], the nearest first.

        * Pose: see the class.
        * `ignore_collisions`: accept configurations in collision.
        * `trials`: maximum number of initial configurations; `max_configs`: maximum number of solutions.
        * `distance_threshold` and `max_time_ms` have no effect.

        Raises:
            ConfigurationError: No configuration was found, all are in collision, or the pose is invalid.
        """
        try:
            pose = arm_planning.world_pose(position, euler, quaternion, relative_to)
            found = arm_planning.configurations(
                Simulator.current(), pose, ignore_collisions=ignore_collisions, starts=trials, most=max_configs
            )
        except (PlanningError, ValueError) as error:
            raise ConfigurationError(f"No configuration was found for the pose: {error}") from error
        return np.array(found)

    def get_configs_for_tip_pose(
        self,
        position: Numbers,
        euler: Numbers | None = None,
        quaternion: Numbers | None = None,
        ignore_collisions: bool = False,
        trials: int = 300,
        max_configs: int = 60,
        relative_to: Object | None = None,
    ) -> list[list[float]]:
        """Return the result of `solve_ik_via_sampling` as lists; this is its older name."""
        found = self.solve_ik_via_sampling(
            position, euler, quaternion, ignore_collisions, trials, max_configs, relative_to=relative_to
        )
        return found.tolist()

    def set_ik_element_properties(
        self,
        constraint_x: bool = True,
        constraint_y: bool = True,
        constraint_z: bool = True,
        constraint_alpha_beta: bool = True,
        constraint_gamma: bool = True,
    ) -> None:
        """No effect if all arguments are True: inverse kinematics always constrains the whole pose.

        Raises:
            UnsupportedCall: An argument is False.
        """
        if not (constraint_x and constraint_y and constraint_z and constraint_alpha_beta and constraint_gamma):
            raise UnsupportedCall(
                "set_ik_element_properties",
                "inverse kinematics fixes the whole pose.",
                "Try several poses with `solve_ik_via_sampling` to leave a part of it free.",
            )

    def set_ik_group_properties(
        self, resolution_method: str = "pseudo_inverse", max_iterations: int = 6, dls_damping: float = 0.1
    ) -> None:
        """No effect: the solver of this package has its own damping and iterates to an error of 1 micrometre."""

    # Collisions ------------------------------------------------------------------------------------------------------

    def check_arm_collision(self, obj: Object | None = None) -> bool:
        """Return whether arm or gripper collide with `obj`; None: with any collidable object, or with themselves."""
        if obj is None:
            return arm_planning.arm_collides(Simulator.current(), None)
        if obj.element.kind in ("body", "room"):
            return obj.is_collidable() and arm_planning.arm_collides(Simulator.current(), obj.element.name)
        return obj.element.kind not in ROBOT_KINDS and self.check_collision(obj)

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
        """Plan a timed path to a pose: along a straight line of the tip if it is free, otherwise around obstacles.

        * Pose: see the class.
        * `ignore_collisions`: plan without collision checks. Otherwise only objects that the arm touches now are ignored.
        * `algorithm`: algorithm for paths around obstacles; RRT-Connect for names that are not in `arm_planning.ALGORITHMS`.
        * All other arguments have no effect.

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
        """Plan a timed path of the tip along a straight line to a pose; `steps` has no effect.

        Raises:
            ConfigurationPathError: The arm cannot follow the line.
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
        """Plan a timed path to a pose without a straight line of the tip; the arguments are those of `get_path`.

        Raises:
            ConfigurationPathError: There is no path.
        """
        return self._path((position, euler, quaternion, relative_to), False, ignore_collisions, algorithm)

    def get_path_from_cartesian_path(self, path: CartesianPath) -> ArmConfigurationPath:
        """Plan a timed path of the tip from its current pose along a Cartesian path, without collision checks.

        Raises:
            ConfigurationPathError: The arm cannot follow the path.
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
        """Plan a timed path to a pose; `straight` is the argument of `arm_planning.plan_to`."""
        try:
            pose = arm_planning.world_pose(*target)
            plan = arm_planning.plan_to(
                Simulator.current(), pose, straight=straight, ignore_collisions=ignore_collisions, algorithm=algorithm.name
            )
            return self._timed(plan)
        except (PlanningError, ValueError) as error:
            raise ConfigurationPathError(f"No path to the pose: {error}") from error

    def _timed(self, plan: Plan) -> ArmConfigurationPath:
        """Return the path of a plan, timed within the limits of this arm."""
        trajectory = arm_planning.paced(Simulator.current().runtime, plan, self.pace)
        return ArmConfigurationPath(self, plan.path.ravel(), trajectory)


class KnownArm(Arm):
    """Base of the arm classes of PyRep.

    Args:
        count: Index of the arm; only 0 is possible, since a world has one arm.
        max_velocity: Maximum joint velocity in paths [rad/s].
        max_acceleration: Maximum joint acceleration in paths [rad/s^2].
        max_jerk: Maximum jerk in paths [rad/s^3]; from 1000 on there is no limit.
    """

    known_name: ClassVar[str]
    joint_count: ClassVar[int]

    def __init__(self, count: int = 0, max_velocity: float = 1.0, max_acceleration: float = 4.0, max_jerk: float = 1000) -> None:
        super().__init__(count, self.known_name, self.joint_count, None, max_velocity, max_acceleration, max_jerk)


def _known_arm(title: str, name: str, joint_count: int) -> type[KnownArm]:
    """Return the class `title` of the arm with a name and number of joints in PyRep."""
    return type(title, (KnownArm,), {"__module__": __name__, "known_name": name, "joint_count": joint_count})


Panda = _known_arm("Panda", "Panda", 7)
BaxterLeft = _known_arm("BaxterLeft", "Baxter_leftArm", 7)
BaxterRight = _known_arm("BaxterRight", "Baxter_rightArm", 7)
Jaco = _known_arm("Jaco", "Jaco", 6)
LBRIwaa14R820 = _known_arm("LBRIwaa14R820", "LBRIwaa14R820", 7)
LBRIwaa7R800 = _known_arm("LBRIwaa7R800", "LBRIwaa7R800", 7)
Mico = _known_arm("Mico", "Mico", 6)
Sawyer = _known_arm("Sawyer", "Sawyer", 7)
UR3 = _known_arm("UR3", "UR3", 6)
UR5 = _known_arm("UR5", "UR5", 6)
UR10 = _known_arm("UR10", "UR10", 6)

add_aliases(
    __name__,
    ("arm", "baxter", "jaco", "lbr_iiwa_14_r820", "lbr_iiwa_7_r800", "mico", "panda", "sawyer", "ur10", "ur3", "ur5"),
)
