"""The arm's own surface, to tell what it is from what it handles."""

from __future__ import annotations

from rlbench_pin.evaluation.baselines.sight.models import KnownModel
from rlbench_pin.robot import RobotModel
from rlbench_pin.spatial import FloatArray


def arm_surface(arm: RobotModel, q: FloatArray, fingers: FloatArray) -> FloatArray:
    """Return points (m, 3) on the surface of arm and hand at joint positions `q` (n,) [rad] and `fingers` (2,) [m]."""
    description = arm.description
    names = (*description.arm_joints, *description.gripper_joints)
    joints = dict(zip(names, [*q.tolist(), *fingers.tolist()], strict=True))
    model = KnownModel.load(description.urdf)
    return model.points_at(joints) @ arm.base.rotation.T + arm.base.translation
