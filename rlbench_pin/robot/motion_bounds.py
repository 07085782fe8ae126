"""How far apart are two bodies at least, and how far can joints swing one against the other? Cheap bounds for many pairs at
once.

Every moving shape is put in a ball, every other one in a box along world axes; their distance is a lower bound of the true one.

No point of a body moves by more than the joint's lever, its distance from the joint axis, times the angle. Levers hold
now; while joints turn by angles T_j they grow with the motion itself, up to the reach r_j that the chain of links allows.
So no point moves farther than

    D = sum_j min(lever_j / (1 - sum_i T_i), r_j) T_j                                         (1)

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


class MotionBounds:
    """Bounds for pairs of shapes of one arm and its world.

    Args:
        model: The arm.
        shapes: All shapes, placed in the frames of Pinocchio joints.
        pairs: Indices of the shapes of each pair.
    """

    def __init__(self, model: RobotModel, shapes: Sequence[pin.GeometryObject], pairs: Sequence[tuple[int, int]]) -> None:
        self._model, self._columns = model, model.full_index[: model.size]
        ends = np.array(pairs, dtype=np.intp).reshape(-1, 2)
        support = np.array([self._support(shape.parentJoint) for shape in shapes]).reshape(-1, model.size)
        depth = support.sum(axis=1)
        self.sign = support[ends[:, 1]] - support[ends[:, 0]]
        """+1 where a joint carries only the second body of a pair, -1 only the first, shape (pairs, n)."""
        moving = np.flatnonzero(depth > 0)
        self._index_moving(shapes, moving)
        self._index_boxes(shapes, moving)
        second_farther = depth[ends[:, 1]] >= depth[ends[:, 0]]
        order = np.empty(len(shapes), dtype=np.intp)
        order[moving] = np.arange(len(moving))
        ball = order[np.where(second_farther, ends[:, 1], ends[:, 0])]
        other = np.where(second_farther, ends[:, 0], ends[:, 1])
        self._spread = self._radius[ball, 0] + self._other_radius[other]
        self._cell = ball * len(shapes) + other
        rows = np.concatenate([ball[:, None], np.abs(self.sign)], axis=1)
        rows, self._row = np.unique(rows, axis=0, return_inverse=True)
        self._row_ball, self._row_between = rows[:, 0].astype(np.intp), rows[:, 1:]
        balls = zip(self._carrier.tolist(), self._center, self._radius[:, 0].tolist(), strict=True)
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
        self._radius = np.array([item.geometry.aabb_radius for item in items]).reshape(-1, 1)
        self._center = np.array([item.placement.act(np.asarray(item.geometry.aabb_center)) for item in items]).reshape(-1, 3)
        joints, self._carrier = np.unique([item.parentJoint for item in items], return_inverse=True)
        self._joints: list[int] = joints.tolist()

    def _index_boxes(self, shapes: Sequence[pin.GeometryObject], moving: IndexArray) -> None:
        """Put a box along world axes around each shape that stands still; a moving one gets its ball's centre at each `place`."""
        self._moving = moving
        self._low, self._high = np.zeros((3, 1, len(shapes))), np.zeros((3, 1, len(shapes)))  # numpy is fast along the last axis
        self._other_radius = np.zeros(len(shapes))
        self._other_radius[moving] = self._radius[:, 0]
        self._fixed = np.setdiff1d(np.arange(len(shapes)), moving)
        for i in self._fixed.tolist():
            shapes[i].geometry.computeLocalAABB()
        self.place_fixed(shapes)

    def place_fixed(self, shapes: Sequence[pin.GeometryObject]) -> None:
        """Take over where the shapes are that stand still; the same shapes as at the beginning."""
        for i in self._fixed.tolist():
            box, placement = shapes[i].geometry.aabb_local, shapes[i].placement
            center = placement.act(np.asarray(box.center()))
            half = 0.5 * np.abs(placement.rotation) @ np.array([box.width(), box.height(), box.depth()])
            self._low[:, 0, i], self._high[:, 0, i] = center - half, center + half

    # Questions ----------------------------------------------------------------------------------------------------

    def place(self, data: pin.Data, jacobian: FloatArray) -> FloatArray:
        """Take over the arm's placement, and return a lower bound of each pair's distance, shape (pairs,), [m].

        A bound that is not above 0 says nothing: the pair may be anywhere, also inside each other.

        Args:
            data: Pinocchio's, with joint placements.
            jacobian: Spatial Jacobian of the arm joints, shape (6, n).
        """
        placements = np.array([data.oMi[joint].homogeneous for joint in self._joints])[self._carrier]
        centers = (placements[:, :3, :3] @ self._center[:, :, None])[:, :, 0] + placements[:, :3, 3]
        self._place_levers(centers, jacobian)
        self._low[:, 0, self._moving] = self._high[:, 0, self._moving] = centers.T
        balls = centers.T[:, :, None]
        gap = np.maximum(np.maximum(self._low - balls, balls - self._high), 0.0)
        gap *= gap
        return np.sqrt((gap[0] + gap[1] + gap[2]).ravel()[self._cell]) - self._spread

    def _place_levers(self, centers: FloatArray, jacobian: FloatArray) -> None:
        """Compute levers: with a the axis and o its point next to the world's origin, sqrt(|c - o|^2 - (a c)^2) from centre c."""
        axes = jacobian[3:].T
        feet = cross(axes, jacobian[:3].T)
        along = centers @ axes.T
        squares = np.einsum("ij,ij->i", centers, centers)[:, None] - 2.0 * (centers @ feet.T) - along * along
        levers = np.sqrt(np.maximum(squares + np.einsum("ij,ij->i", feet, feet), 0.0)) + self._radius
        self._levers = levers[self._row_ball] * self._row_between

    def levers(self, turns: FloatArray) -> FloatArray:
        """Return levers that hold while joints turn by at most `turns` (n,) [rad]; rows are those of `rows_of`, [m/rad]."""
        left = 1.0 - float(turns.sum())
        return np.minimum(self._levers / left, self._reaches) if left > 0.0 else self._reaches

    def rows_of(self, which: IndexArray) -> IndexArray:
        """Return which row of `levers` belongs to each of the pairs `which`."""
        return self._row[which]

    def displacement(self, turns: FloatArray) -> FloatArray:
        """Return how far each pair's bodies move against each other at most while joints turn by `turns` (n,), (pairs,), [m]."""
        return (self.levers(turns) @ turns)[self._row]

    def approach(self, speeds: FloatArray) -> FloatArray:
        """Return how fast each pair can close in at most with joint speeds up to `speeds` (n,), shape (pairs,), [m/s]."""
        return (self._levers @ speeds)[self._row]


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products of rows, shape (m, 3); much faster on few rows than numpy's."""
    return a[:, _NEXT] * b[:, _LAST] - a[:, _LAST] * b[:, _NEXT]
