"""The arm as PlaCo sees it: joints of the arm alone, base where it stands, fingers fixed, no geometry."""

from __future__ import annotations

from collections.abc import Sequence
from operator import add
from struct import Struct

import numpy as np
import placo

from rlbench_pin.errors import RobotModelError
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import kinematic_urdf

BASE = 7
"""PlaCo puts a pose (7,) of the base in front of the joints in q."""
BASE_SPEED = 6
"""And a twist (6,) in front of them in a displacement."""


class PlacoArm:
    """A PlaCo robot and kinematics solver for one arm, in the joint order of `RobotModel`."""

    def __init__(self, model: RobotModel) -> None:
        """Build the robot and check that it is the same arm.

        Raises:
            RobotModelError: PlaCo orders the joints differently, or its kinematics disagree with Pinocchio's.
        """
        self.size = model.size
        urdf = model.description.urdf
        text = kinematic_urdf(urdf, fixed=model.description.gripper_joints)
        self.robot = placo.RobotWrapper(urdf.name, int(placo.Flags.ignore_collisions), text)
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.mask_fbase(True)
        self.robot.set_T_world_fbase(model.base.homogeneous)
        self._state, self._pinocchio = self.robot.state, self.robot.model
        self._update, self._solve = self.robot.update_kinematics, self.solver.solve
        self._q = np.array(self._state.q)
        self._q_joints = self._q[BASE:]
        self._lower, self._upper = (
            memoryview(limit[BASE:]) for limit in (self._pinocchio.lowerPositionLimit, self._pinocchio.upperPositionLimit)
        )
        """What is written here, PlaCo reads."""
        self._write = Struct(f"{self.size}d").pack_into
        self._check(model)

    def set_configuration(self, q: FloatArray) -> None:
        """Put the arm at `q` (n,) [rad] and compute its kinematics."""
        self._q_joints[:] = q
        self._state.q = self._q
        self._update()

    def solve(self, q: Sequence[float], lowest: Sequence[float], highest: Sequence[float]) -> FloatArray:
        """Return the displacement (n,) [rad] of the next tick from `q`, between `lowest` and `highest`, plain numbers.

        PlaCo raises RuntimeError when there is none.
        """
        self._write(self._lower, 0, *map(add, q, lowest))
        self._write(self._upper, 0, *map(add, q, highest))
        return self._solve(False)[BASE_SPEED:]

    def _check(self, model: RobotModel) -> None:
        names = tuple(self.robot.joint_names())
        if names != model.description.arm_joints:
            raise RobotModelError(f"PlaCo orders the joints {names}, the description {model.description.arm_joints}.")
        self.set_configuration(model.home)
        placo_tip = np.asarray(self.robot.get_T_world_frame(model.description.tip_frame))
        if not np.allclose(placo_tip, model.tip_se3(model.home).homogeneous, atol=1e-9):
            raise RobotModelError(
                f"PlaCo and Pinocchio put '{model.description.tip_frame}' of '{model.description.name}' in two places."
            )
