"""How far apart are two bodies at least, and how far can joints swing one against the other? Cheap bounds for many pairs at
once.

Every moving shape is put in a ball, every other one in a box along world axes; their distance is a lower bound of the true one.

No point of a body moves by more than the joint's lever l_j, its distance from the joint axis, times the angle. Levers hold
now; while joints turn by angles T_j each grows at most by the motion itself, D0 / (1 - sum_i T_i) with D0 = sum_i l_i T_i, and at
most to the reach r_j that the chain of links allows. So no point moves farther than

    D = sum_j min(l_j + D0 / (1 - sum_i T_i), r_j) T_j                                        (1)

and a distance changes by D at most. Between two moving bodies only the joints between them count.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray

IndexArray = NDArray[np.intp]
_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])
_NOTHING = np.zeros(())


class MotionBounds:
    """Bounds for pairs of shapes of one arm and its world.

    Args:
        model: The arm.
        shapes: All shapes, placed in the frames of Pinocchio joints.
        pairs: Indices of the shapes of each pair.
    """

    def __init__(self, model: RobotModel, shapes: Sequence[pin.GeometryObject], pairs: Sequence[tuple[int, int]]) -> None:
        self._model = model
        ends = np.array(pairs, dtype=np.intp).reshape(-1, 2)
        support = np.array([self._support(shape.parentJoint) for shape in shapes]).reshape(-1, model.size)
        depth = support.sum(axis=1)
        self.sign = support[ends[:, 1]] - support[ends[:, 0]]
        """+1 where a joint carries only the second body of a pair, -1 only the first, shape (pairs, n)."""
        moving = np.flatnonzero(depth > 0)
        self._speed_of_points = _speed_of_points()
        self._index_moving(shapes, moving)
        self._index_boxes(shapes, moving)
        second_farther = depth[ends[:, 1]] >= depth[ends[:, 0]]
        order = np.empty(len(shapes), dtype=np.intp)
        order[moving] = np.arange(len(moving))
        ball = order[np.where(second_farther, ends[:, 1], ends[:, 0])]
        other = np.where(second_farther, ends[:, 0], ends[:, 1])
        self._spread = self._radius[ball] + self._other_radius[other]
        self._cell = ball * len(shapes) + other
        rows = np.concatenate([ball[:, None], np.abs(self.sign)], axis=1)
        rows, self._row = np.unique(rows, axis=0, return_inverse=True)
        self._row_ball, self._row_between = rows[:, 0].astype(np.intp), rows[:, 1:]
        balls = zip(self._carrier.tolist(), self._center[:, :3, 0], self._radius.tolist(), strict=True)
        reaches = np.array([model.chain_reach.of(self._joints[place], center, radius) for place, center, radius in balls])
        self._reaches = reaches.reshape(-1, model.size)[self._row_ball] * self._row_between

    def _support(self, joint: int) -> FloatArray:
        """Return 1 for every arm joint that carries Pinocchio joint `joint`, shape (n,)."""
        full, names = self._model.full, self._model.description.arm_joints
        carriers = set(full.supports[joint])
        return np.array([float(full.getJointId(name) in carriers) for name in names])

    def _index_moving(self, shapes: Sequence[pin.GeometryObject], moving: IndexArray) -> None:
        """Put a ball around each moving shape, in the frame of its joint."""
        items = [shapes[i] for i in moving.tolist()]
        for item in items:
            item.geometry.computeLocalAABB()
        self._radius = np.array([item.geometry.aabb_radius for item in items])
        centers = [item.placement.act(np.asarray(item.geometry.aabb_center)) for item in items]
        self._center = np.array([[*center, 1.0] for center in centers]).reshape(-1, 4, 1)
        joints, self._carrier = np.unique([item.parentJoint for item in items], return_inverse=True)
        self._joints: list[int] = joints.tolist()

    def _index_boxes(self, shapes: Sequence[pin.GeometryObject], moving: IndexArray) -> None:
        """Put a box along world axes around each shape that stands still; a moving one gets its ball's centre at each `place`."""
        self._moving = moving
        self._middle, self._half = np.zeros((3, len(shapes))), np.zeros((3, 1, len(shapes)))  # numpy is fast along the last axis
        self._other_radius = np.zeros(len(shapes))
        self._other_radius[moving] = self._radius
        self._fixed = np.setdiff1d(np.arange(len(shapes)), moving)
        for i in self._fixed.tolist():
            shapes[i].geometry.computeLocalAABB()
        self.place_fixed(shapes)

    def place_fixed(self, shapes: Sequence[pin.GeometryObject]) -> None:
        """Take over where the shapes are that stand still; the same shapes as at the beginning."""
        for i in self._fixed.tolist():
            box, placement = shapes[i].geometry.aabb_local, shapes[i].placement
            self._middle[:, i] = placement.act(np.asarray(box.center()))
            self._half[:, 0, i] = 0.5 * np.abs(placement.rotation) @ np.array([box.width(), box.height(), box.depth()])

    # Questions ----------------------------------------------------------------------------------------------------

    def place(self, data: pin.Data, jacobian: FloatArray) -> FloatArray:
        """Take over the arm's placement, and return a lower bound of each pair's distance, shape (pairs,), [m].

        A bound that is not above 0 says nothing: the pair may be anywhere, also inside each other.

        Args:
            data: Pinocchio's, with joint placements.
            jacobian: Spatial Jacobian of the arm joints, shape (6, n).
        """
        joints = data.oMi
        placements = np.array([joints[joint].homogeneous for joint in self._joints]).take(self._carrier, axis=0)
        centers = np.ascontiguousarray((placements @ self._center)[:, :, 0].T)
        self._place_levers(centers, jacobian)
        balls = centers[:3]
        self._middle[:, self._moving] = balls
        gap = self._middle[:, None] - balls[:, :, None]
        np.abs(gap, out=gap)
        gap -= self._half
        np.maximum(gap, _NOTHING, out=gap)
        gap *= gap
        bounds = (gap[0] + gap[1] + gap[2]).take(self._cell)
        np.sqrt(bounds, out=bounds)
        bounds -= self._spread
        return bounds

    def _place_levers(self, centers: FloatArray, jacobian: FloatArray) -> None:
        """Compute levers: the speeds |v + w x c| of ball centres c (4, balls), last row 1, while one joint turns at 1 rad/s."""
        speeds = (self._speed_of_points @ jacobian).reshape(3, 4, -1).transpose(0, 2, 1) @ centers  # (3, n, balls)
        speeds *= speeds
        levers = speeds[0] + speeds[1] + speeds[2]
        np.sqrt(levers, out=levers)
        levers += self._radius
        self._levers = levers.T.take(self._row_ball, axis=0)
        self._levers *= self._row_between

    def levers(self, turns: FloatArray) -> FloatArray:
        """Return levers that hold while joints turn by at most `turns` (n,) [rad]; rows are those of `rows_of`, [m/rad]."""
        left = 1.0 - sum(turns.tolist())
        if left <= 0.0:
            return self._reaches
        growth = (self._levers @ turns) / left
        return np.minimum(self._levers + growth[:, None], self._reaches)

    def rows_of(self, which: IndexArray) -> IndexArray:
        """Return which row of `levers` belongs to each of the pairs `which`."""
        return self._row[which]

    def displacement(self, turns: FloatArray) -> FloatArray:
        """Return how far each pair's bodies move against each other at most while joints turn by `turns` (n,), (pairs,), [m]."""
        return (self.levers(turns) @ turns).take(self._row)

    def approach(self, speeds: FloatArray) -> FloatArray:
        """Return how fast each pair can close in at most with joint speeds up to `speeds` (n,), shape (pairs,), [m/s]."""
        return (self._levers @ speeds).take(self._row)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products of rows, shape (m, 3); much faster on few rows than numpy's."""
    return a[:, _NEXT] * b[:, _LAST] - a[:, _LAST] * b[:, _NEXT]


def _speed_of_points() -> FloatArray:
    """Return the matrix (12, 6) that makes of a twist [v, w] three rows (4,), which times [c, 1] are v + w x c."""
    rows, axes = np.zeros((3, 4, 6)), np.arange(3)
    rows[axes, 3, axes] = 1.0
    rows[axes, _LAST, 3 + _NEXT] = 1.0
    rows[axes, _NEXT, 3 + _LAST] = -1.0
    return rows.reshape(12, 6)
