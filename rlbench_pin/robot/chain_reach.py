"""How far can a point that the arm carries ever be from the axis of one of its joints?

The next joint of the chain keeps its distance from the axis in any configuration; beyond it the links may be stretched. So
what depends on the arm alone, the distance to the last joint of the chain, is computed once.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rlbench_pin.spatial import FloatArray


class ChainReach:
    """Bounds that hold in every configuration of one arm.

    Args:
        full: Arm and fingers.
        arm: Names of the arm joints, n of them.
        slide: How far a finger joint can slide [m].
    """

    def __init__(self, full: pin.Model, arm: tuple[str, ...], slide: float) -> None:
        data = full.createData()
        joints = [full.getJointId(name) for name in arm]
        columns = [full.idx_vs[joint] for joint in joints]
        axes = pin.computeJointJacobians(full, data, pin.neutral(full))[:, columns].T
        self._placements = [data.oMi[i].copy() for i in range(full.njoints)]
        self._axes = axes
        self._links = np.full((full.njoints, len(arm)), -np.inf)
        self._own: dict[int, int] = {}
        for carrier in range(full.njoints):
            chain = list(full.supports[carrier])
            for j in (j for j, joint in enumerate(joints) if joint in chain):
                beyond = chain[chain.index(joints[j]) + 1 :]
                if not beyond:
                    self._own[carrier] = j
                    continue
                near = _distance(axes[j], data.oMi[beyond[0]].translation)
                stretched = sum(float(np.linalg.norm(full.jointPlacements[i].translation)) for i in beyond[1:])
                self._links[carrier, j] = near + stretched + slide * sum(joint not in joints for joint in beyond)

    def of(self, carrier: int, center: FloatArray, radius: float) -> FloatArray:
        """Return the reach of a ball about each joint's axis, shape (n,), [m]; 0 for joints that do not carry it.

        Args:
            carrier: Pinocchio joint that the ball moves with.
            center: Its centre in the frame of that joint (3,), [m].
            radius: Its radius [m].
        """
        reach = np.maximum(self._links[carrier] + (float(np.linalg.norm(center)) + radius), 0.0)
        own = self._own.get(carrier)
        if own is not None:
            reach[own] = _distance(self._axes[own], self._placements[carrier].act(center)) + radius
        return reach


def _distance(axis: FloatArray, point: FloatArray) -> float:
    """Return the distance [m] of a point (3,) from a joint's axis, a column (6,) of the spatial Jacobian."""
    x, y, z = point.tolist()
    a, b, c = axis[3:].tolist()
    return float(np.linalg.norm(axis[:3] + (b * z - c * y, c * x - a * z, a * y - b * x)))
