"""Where the joints of an arm are, for many configurations in one go.

Pinocchio places one at a time; for thirty and more, numpy is the faster way to have all of them in arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray

_SKEW = np.array([pin.skew(axis).ravel() for axis in np.eye(3)])


@dataclass(frozen=True, eq=False)
class Placed:
    """An arm in m configurations."""

    rotations: FloatArray
    """Of each joint's frame in the world, shape (m, n, 3, 3)."""
    origins: FloatArray
    """World positions of the joints' frames, shape (m, n, 3), [m]."""
    linear: FloatArray
    """Velocity of the point of each joint's body that is at the world's origin, at 1 rad/s, shape (m, n, 3), [m/rad]."""
    angular: FloatArray
    """Axes about which the joints turn, in the world, shape (m, n, 3); zero for a joint that slides."""


class ArmChain:
    """The serial chain of arm joints."""

    def __init__(self, model: RobotModel) -> None:
        """Read placements and axes of the joints of an arm."""
        full, data = model.full, model.full.createData()
        joints = [full.getJointId(name) for name in model.description.arm_joints]
        axes = pin.computeJointJacobians(full, data, pin.neutral(full))[:, [full.idx_vs[j] for j in joints]].T
        placements = [data.oMi[joint].copy() for joint in joints]
        before = [pin.SE3.Identity(), *placements[:-1]]
        steps = [a.inverse() * b for a, b in zip(before, placements, strict=True)]
        turns = np.array([T.rotation.T @ axis[3:] for T, axis in zip(placements, axes, strict=True)])
        slides = np.array([T.rotation.T @ axis[:3] for T, axis in zip(placements, axes, strict=True)])
        slides[np.linalg.norm(turns, axis=1) > 0.5] = 0.0
        self._axes = np.stack([turns, slides], axis=2)
        self._steps = np.array([step.homogeneous for step in steps])
        turned = np.zeros((3, len(joints), 4, 4))  # Rodrigues: 1 + sin(q) K + (1 - cos(q)) K^2
        turned[0, :, :3, :3] = skew(turns)
        turned[1, :, :3, :3] = skew(turns) @ skew(turns)
        turned[2, :, :3, 3] = slides
        self._sines, self._versines, self._slides = self._steps @ turned

    def place(self, q: FloatArray) -> Placed:
        """Place the joints for configurations (m, n), [rad]."""
        sine, versine = np.sin(q)[..., None, None], (1.0 - np.cos(q))[..., None, None]
        placements = self._steps + sine * self._sines + versine * self._versines + q[..., None, None] * self._slides
        for j in range(1, q.shape[1]):
            placements[:, j] = placements[:, j - 1] @ placements[:, j]
        rotations, origins = np.ascontiguousarray(placements[:, :, :3, :3]), np.ascontiguousarray(placements[:, :, :3, 3])
        axes = rotations @ self._axes
        angular = np.ascontiguousarray(axes[..., 0])
        linear = cross(origins, angular) + axes[..., 1]
        return Placed(rotations, origins, linear, angular)


def skew(a: FloatArray) -> FloatArray:
    """Return the matrices (..., 3, 3) that make cross products a x b of vectors b (3,)."""
    return (a @ _SKEW).reshape(*a.shape, 3)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products of vectors (..., 3); faster than numpy's on many."""
    return (skew(a) @ b[..., None])[..., 0]
