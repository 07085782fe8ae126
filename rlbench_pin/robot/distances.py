"""Distances of the arm and their gradients: exact for near pairs, bounds for the others.

For a pair of bodies with nearest points p_a, p_b and unit normal n from a to b, the distance d = n^T (p_b - p_a) changes as

    dd/dt = n^T (v_b - v_a) = [n, p x n]^T (V_b - V_a)                                        (1)

where V are spatial twists, and p is either point: both are on one line along n. A joint that carries only the farther
body (a: +1, b: -1 the other way) contributes its column of the spatial Jacobian, so that one product gives the gradients
of all pairs.

Measuring is expensive; bounds show without it which pairs are far enough. Every moving shape is put in a ball, every other one in
a box along world axes; their distance is a lower bound of the true one. No point of a body moves by more than the joint's lever
l_j, its distance from the joint axis, times the angle. Levers hold now; while joints turn by angles T_j each grows at most by the
motion itself, D0 / (1 - sum_i T_i) with D0 = sum_i l_i T_i, and at most to the reach r_j that the chain of links allows. So no
point moves farther than

    D = sum_j min(l_j + D0 / (1 - sum_i T_i), r_j) T_j                                        (2)

and a distance changes by D at most. Between two moving bodies only the joints between them count.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.robot.collision import CollisionGeometry, Distance, as_slice
from rlbench_pin.robot.dynamics import payload_inertia
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_names, as_record, as_vector, as_whole

IndexArray = NDArray[np.intp]
_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])
_ZERO = np.zeros(())


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
        """Put a box along world axes around each stationary shape; a moving one gets its ball's centre at each `place`."""
        self._moving = moving
        self._middle, self._half = np.zeros((3, len(shapes))), np.zeros((3, 1, len(shapes)))  # numpy is fast along the last axis
        self._other_radius = np.zeros(len(shapes))
        self._other_radius[moving] = self._radius
        self._fixed = np.setdiff1d(np.arange(len(shapes)), moving)
        for i in self._fixed.tolist():
            shapes[i].geometry.computeLocalAABB()
        self.place_fixed(shapes)

    def place_fixed(self, shapes: Sequence[pin.GeometryObject]) -> None:
        """Update the placements of stationary shapes; the shapes stay the same."""
        for i in self._fixed.tolist():
            box, placement = shapes[i].geometry.aabb_local, shapes[i].placement
            self._middle[:, i] = placement.act(np.asarray(box.center()))
            self._half[:, 0, i] = 0.5 * np.abs(placement.rotation) @ np.array([box.width(), box.height(), box.depth()])

    # Questions ----------------------------------------------------------------------------------------------------

    def place(self, data: pin.Data, jacobian: FloatArray) -> FloatArray:
        """Take over the arm's placement, and return a lower bound of each pair's distance, shape (pairs,), [m].

        A bound that is not above 0 has no information: the shapes may also overlap.

        Args:
            data: Pinocchio data with joint placements.
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
        np.maximum(gap, _ZERO, out=gap)
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


class DistanceModel:
    """Distances of one arm and its held bodies in a world. Pairs of shapes are identified by their index. Not thread-safe."""

    def __init__(self, model: RobotModel) -> None:
        """Start in an empty world, with the arm at home."""
        self.model = as_record(model, RobotModel, "model")
        self._data = model.full.createData()
        self._columns = as_slice(model.full_index[: model.size])
        self._layout: object = None
        fingers = np.full(len(model.description.gripper_joints), model.description.gripper_open)
        self.update(WorldSnapshot((), model.home, fingers))

    def update(self, snapshot: WorldSnapshot, allowed: Collection[str] = ()) -> None:
        """Set the world; pairs with bodies in `allowed` are ignored until the next update."""
        as_record(snapshot, WorldSnapshot, "snapshot")
        as_names(allowed, "allowed")
        self.payload = payload_inertia(self.model, snapshot)
        """Inertia of the held bodies, in the frame of the last joint."""
        self._q = self.model.full_configuration(snapshot.arm, snapshot.fingers)
        bodies = [body for body in snapshot.bodies if body.collides and not (body.fixed and body.name in snapshot.attached)]
        layout = (snapshot.attached, tuple(body.layout for body in bodies))
        same = layout == self._layout
        if not same:
            self._geometry = CollisionGeometry(self.model, bodies, snapshot.attached)
            self._layout = layout
            self._results = list(self._geometry.data.distanceResults)  # views, which later queries renew
        pin.forwardKinematics(self.model.full, self._data, self._q)
        self._geometry.place(bodies, self._data.oMi[self._geometry.hand_joint])
        if same and not snapshot.attached:
            self.motion.place_fixed(list(self._geometry.model.geometryObjects))
        else:
            self._index_motion()
        if not same or self._allowed != set(allowed):
            self._index_pairs(set(allowed))
        self.place(snapshot.arm)

    def _index_motion(self) -> None:
        """Prepare the data of each pair that depends only on the held bodies."""
        geometry = self._geometry
        self.motion = MotionBounds(self.model, list(geometry.model.geometryObjects), geometry.pairs)
        """Bounds of the relative motion of bodies."""
        self.crosses = np.array([geometry.crosses[pair] for pair in geometry.pairs], dtype=bool)
        """Mask of the pairs with the world, shape (pairs,); the others are within the arm."""

    def _index_pairs(self, allowed: set[str]) -> None:
        """Prepare the mask of the checked pairs."""
        geometry, pairs = self._geometry, self._geometry.pairs
        self._allowed = allowed
        self.counts = np.array([not {geometry.owners[i].body for i in pair} & allowed for pair in pairs], dtype=bool)
        """Mask of the checked pairs, shape (pairs,); each change creates a new array."""

    # Moving -------------------------------------------------------------------------------------------------------

    def place(self, q: FloatArray) -> None:
        """Set the configuration of the arm to `q` (n,) [rad]."""
        self.visit(q)
        jacobian = pin.computeJointJacobians(self.model.full, self._data, self._q)
        self._jacobian = jacobian[:, self._columns]
        self.bounds = self.motion.place(self._data, self._jacobian)
        """Lower bound of the distance of each pair at the configuration of `place`, shape (pairs,), [m]; exact if measured."""
        self._found: dict[int, float] = {}

    def visit(self, q: FloatArray) -> None:
        """Set the configuration `q` for `probe` only; the results of `place` and `measure` do not change."""
        self._q[self._columns] = q
        pin.updateGeometryPlacements(self.model.full, self._data, self._geometry.model, self._geometry.data, self._q)

    # Measuring ----------------------------------------------------------------------------------------------------

    def measure(self, which: IndexArray) -> FloatArray:
        """Return the distances [m] of pairs `which` at the configuration of `place`, and store them as exact bounds."""
        distances = np.array([self.distance(k) for k in which.tolist()])
        self.bounds[which] = distances
        return distances

    def distance(self, k: int) -> float:
        """Return the distance [m] of one pair at the configuration of `place`, without a change of its bound."""
        found = self._found
        if k not in found:
            found[k] = pin.computeDistance(self._geometry.model, self._geometry.data, k).min_distance
        return found[k]

    def probe(self, which: IndexArray) -> FloatArray:
        """Return the distances [m] of pairs `which` at the last configuration, without storing them."""
        geometry, data = self._geometry.model, self._geometry.data
        compute = pin.computeDistance
        return np.array([compute(geometry, data, k).min_distance for k in which.tolist()])

    def gradients(self, which: IndexArray) -> FloatArray:
        """Return the gradients of distances by the joint angles, equation (1), shape (len(which), n), [m/rad].

        The pairs must be measured at the configuration of `place`, without a `visit` in between.
        """
        points, normals = self._nearest_points(which)
        wrenches = np.concatenate([normals, cross(points, normals)], axis=1)
        return (wrenches @ self._jacobian) * self.motion.sign[which]

    def _nearest_points(self, which: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Return nearest points on the first bodies of pairs, and normals, each (len(which), 3)."""
        found = [self._results[k] for k in which.tolist()]
        points = np.array([result.getNearestPoint1() for result in found]).reshape(-1, 3)
        return points, np.array([result.normal for result in found]).reshape(-1, 3)

    def names(self, k: int) -> tuple[str, str]:
        """Return the names of pair `k`: a link of the arm or a held body, and the other link or body."""
        a, b = self._geometry.owners_of(k)
        return a.label, b.label

    def pairs_of(self, links: Collection[str]) -> IndexArray:
        """Return the checked pairs that contain one of the `links` of the arm."""
        ours = [owner.kind in ("arm", "gripper") and owner.link in links for owner in self._geometry.owners]
        pairs = enumerate(self._geometry.pairs)
        return np.array([k for k, (i, j) in pairs if self.counts[k] and (ours[i] or ours[j])], dtype=np.intp)

    def nearest(self, q: FloatArray, count: int = 1) -> list[Distance]:
        """Return the `count` smallest distances of checked pairs at `q` (n,) [rad], nearest first."""
        as_whole(count, "count", least=1)
        as_vector(q, self.model.size, "configuration")
        self.place(q)
        self.measure(np.flatnonzero(self.counts))
        order = np.argsort(np.where(self.counts, self.bounds, np.inf), kind="stable")[:count]
        return [self._record(k) for k in order.tolist() if self.counts[k]]

    def _record(self, k: int) -> Distance:
        points, normals = self._nearest_points(np.array([k]))
        distance = float(self.bounds[k])
        return Distance(*self.names(k), distance, points[0], points[0] + distance * normals[0], normals[0])
