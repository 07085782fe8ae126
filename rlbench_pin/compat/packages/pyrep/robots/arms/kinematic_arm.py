"""Kinematics and collisions of an arm, at the posture and in the world as they are now."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyrep.errors import ConfigurationError, IKError, UnsupportedCall
from pyrep.objects.dummy import Dummy
from pyrep.objects.object import Object
from pyrep.robots.robot_component import RobotComponent
from rlbench_pin.compat import arm_planning
from rlbench_pin.compat.motors import ArmMotors
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.compat.things import Element
from rlbench_pin.errors import PlanningError
from rlbench_pin.spatial import FloatArray

Numbers = Sequence[float] | FloatArray
ROBOT_KINDS = ("robot", "gripper", "tip", "robot_link", "robot_joint")
"""What belongs to the arm itself."""


class KinematicArm(RobotComponent):
    """The arm of the running world, without its paths.

    Poses are of the tip, in the world or in the frame of `relative_to`: a position (3,) [m] and either Euler angles (3,) [rad]
    or a quaternion (x, y, z, w).

    Args:
        count: Which arm of this kind; a world has one.
        name: Name of the arm.
        num_joints: How many joints it has.
        base_name: Name of the object that carries it; None is `name`.
    """

    def __init__(self, count: int, name: str, num_joints: int, base_name: str | None = None) -> None:
        super().__init__(count, name, [f"{name}_joint{i + 1}" for i in range(num_joints)], base_name)
        self._tip_name = f"{name}_tip"

    @property
    def motors(self) -> ArmMotors:
        """What drives the joints."""
        return ArmMotors()

    def get_tip(self) -> Dummy:
        """Return the tip: the frame between the fingers, z out of the hand."""
        return Dummy(Element("tip", self._tip_name))  # not looked up by name: programs ask in every step

    def get_jacobian(self) -> FloatArray:
        """Return the Jacobian (n, 6) at the present posture: row i is the tip's `[linear, angular]` velocity per unit of joint i.

        Along world axes; `arm.get_jacobian().T @ joint_velocities` is the tip's velocity (6,).
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
        """Return the joint positions [rad] that a descent from the present posture finds for a pose.

        Raises:
            IKError: The descent does not reach the pose, or it is no pose.
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
        """Do what `solve_ik_via_jacobian` does; its older name."""
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
        """Return up to `max_configs` different joint positions for a pose, shape (found, n), [rad], nearest first.

        Args:
            position: See the class.
            euler: See the class.
            quaternion: See the class.
            ignore_collisions: Accept configurations in which the arm touches something.
            trials: Descents from different postures, at most.
            max_configs: Enough solutions to stop.
            distance_threshold: Accepted; our descents need none.
            max_time_ms: Accepted; a descent takes well under a millisecond.
            relative_to: See the class.

        Raises:
            ConfigurationError: No configuration was found, all collide, or it is no pose.
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
        """Return different joint positions [rad] for a pose, as `solve_ik_via_sampling` does; its older name."""
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
        """Accept that inverse kinematics fixes the whole pose, which it always does.

        Raises:
            UnsupportedCall: A part of the pose is to be left free.
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
        """Accept settings of another solver: ours damps by itself and goes on until the pose is met to a micrometre."""

    # Collisions ------------------------------------------------------------------------------------------------------

    def check_arm_collision(self, obj: Object | None = None) -> bool:
        """Say whether arm or hand overlap `obj`, no part of them; with None anything that is collidable, or the arm itself."""
        if obj is None:
            return arm_planning.arm_collides(Simulator.current(), None)
        if obj.element.kind in ("body", "room"):
            return obj.is_collidable() and arm_planning.arm_collides(Simulator.current(), obj.element.name)
        return obj.element.kind not in ROBOT_KINDS and self.check_collision(obj)
