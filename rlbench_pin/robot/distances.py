"""How far is the arm from everything, and which way does that change? Exact for what is near, bounded for the rest.

For a pair of bodies with nearest points p_a, p_b and unit normal n from a to b, the distance d = n^T (p_b - p_a) changes as

    dd/dt = n^T (v_b - v_a) = [n, p x n]^T (V_b - V_a)                                        (1)

where V are spatial twists, and p is either point: both lie on one line along n. A joint that carries only the farther
body (a: +1, b: -1 the other way) contributes its column of the spatial Jacobian, so that one product gives the gradients
of all pairs.

Measuring costs; `motion_bounds` finds without it which pairs are far enough.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pinocchio as pin

from rlbench_pin.robot.collision_geometry import CollisionGeometry, Distance
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.motion_bounds import IndexArray, MotionBounds, cross
from rlbench_pin.robot.payload import payload_inertia
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_names, as_record, as_vector, as_whole


class DistanceModel:
    """Distances of one arm, and of what it holds, in a world. A pair of shapes is named by its index. Not thread-safe."""

    def __init__(self, model: RobotModel) -> None:
        """Start in an empty world, at home."""
        self.model = as_record(model, RobotModel, "model")
        self._data = model.full.createData()
        self._columns = _as_slice(model.full_index[: model.size])
        self._layout: object = None
        fingers = np.full(len(model.description.gripper_joints), model.description.gripper_open)
        self.update(WorldSnapshot((), model.home, fingers))

    def update(self, snapshot: WorldSnapshot, allowed: Collection[str] = ()) -> None:
        """Take over the world; pairs with bodies named in `allowed` do not count until the next update."""
        as_record(snapshot, WorldSnapshot, "snapshot")
        as_names(allowed, "allowed")
        self.payload = payload_inertia(self.model, snapshot)
        """Inertia of what the arm holds, in the frame of its last joint."""
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
        """Prepare what is known of each pair as long as the hand holds the same."""
        geometry = self._geometry
        self.motion = MotionBounds(self.model, list(geometry.model.geometryObjects), geometry.pairs)
        """How bodies move against each other."""
        self.crosses = np.array([geometry.crosses[pair] for pair in geometry.pairs], dtype=bool)
        """Which pairs are with the world, shape (pairs,); the others are within the arm."""

    def _index_pairs(self, allowed: set[str]) -> None:
        """Prepare which pairs count."""
        geometry, pairs = self._geometry, self._geometry.pairs
        self._allowed = allowed
        self.counts = np.array([not {geometry.owners[i].body for i in pair} & allowed for pair in pairs], dtype=bool)
        """Which pairs count, shape (pairs,); a new array whenever that changes."""

    # Moving -------------------------------------------------------------------------------------------------------

    def place(self, q: FloatArray) -> None:
        """Put the arm at `q` (n,) [rad]."""
        self.visit(q)
        jacobian = pin.computeJointJacobians(self.model.full, self._data, self._q)
        self._jacobian = jacobian[:, self._columns]
        self.bounds = self.motion.place(self._data, self._jacobian)
        """Lower bound of each pair's distance where `place` put the arm, shape (pairs,), [m]; exact where measured."""
        self._found: dict[int, float] = {}

    def visit(self, q: FloatArray) -> None:
        """Put the arm at `q` for `probe` only: what `place` and `measure` found stays."""
        self._q[self._columns] = q
        pin.updateGeometryPlacements(self.model.full, self._data, self._geometry.model, self._geometry.data, self._q)

    # Measuring ----------------------------------------------------------------------------------------------------

    def measure(self, which: IndexArray) -> FloatArray:
        """Return the distances [m] of pairs `which` where `place` put the arm; their bounds are exact then."""
        distances = np.array([self.distance(k) for k in which.tolist()])
        self.bounds[which] = distances
        return distances

    def distance(self, k: int) -> float:
        """Return the distance [m] of one pair where `place` put the arm; its bound stays as it is."""
        found = self._found
        if k not in found:
            found[k] = pin.computeDistance(self._geometry.model, self._geometry.data, k).min_distance
        return found[k]

    def probe(self, which: IndexArray) -> FloatArray:
        """Return the distances [m] of pairs `which` where the arm was put last, and remember nothing."""
        geometry, data = self._geometry.model, self._geometry.data
        compute = pin.computeDistance
        return np.array([compute(geometry, data, k).min_distance for k in which.tolist()])

    def gradients(self, which: IndexArray) -> FloatArray:
        """Return the gradients of distances by the joint angles, equation (1), shape (len(which), n), [m/rad].

        The pairs have to be measured where `place` put the arm, with no `visit` in between.
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
        """Return the names of pair `k`: a link of the arm or a held body, and what it is near to."""
        a, b = self._geometry.owners_of(k)
        return a.label, b.label

    def nearest(self, q: FloatArray, count: int = 1) -> list[Distance]:
        """Return the `count` smallest distances of pairs that count, at `q` (n,) [rad], nearest first."""
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


def _as_slice(indices: FloatArray) -> slice | FloatArray:
    """Return indices that follow each other as a slice, which numpy takes faster."""
    first, count = int(indices[0]), len(indices)
    return slice(first, first + count) if np.array_equal(indices, np.arange(first, first + count)) else indices
