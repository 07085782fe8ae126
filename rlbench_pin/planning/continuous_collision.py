"""Continuous collision checks: a motion is free between the checked configurations too (after Schwarzer, Saha, Latombe 2005).

A path is a sequence of Bezier pieces. In each joint, the control points of a piece bound the distance of its configurations from
its middle. This bounds the relative motion of each pair of shapes. A pair is cleared for a whole piece by the first of two bounds
that is large enough:

1. the gap between their axis-aligned boxes in the middle of the piece, minus their largest motion (`Poses`), for all
   pieces at once;
2. their distance in the middle, by Coal, minus the part of their motion that closes it (`advances`).

Pieces with remaining pairs are divided, and only these pairs are checked again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.planning.path import JointPath, edge_is_free
from rlbench_pin.planning.plan import PlannerConfig
from rlbench_pin.robot.collision import CollisionGeometry, CollisionModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import LARGEST_COUNT, as_record, as_whole

_SKEW = np.array([pin.skew(axis).ravel() for axis in np.eye(3)])


@dataclass(frozen=True, eq=False)
class Placed:
    """An arm in m configurations."""

    rotations: FloatArray
    """Rotations of the joint frames in the world, shape (m, n, 3, 3)."""
    origins: FloatArray
    """World positions of the joint frames, shape (m, n, 3), [m]."""
    linear: FloatArray
    """Velocity of the point of each joint's body that is at the world's origin, at 1 rad/s, shape (m, n, 3), [m/rad]."""
    angular: FloatArray
    """Rotation axes of the joints in the world, shape (m, n, 3); zero for a prismatic joint."""


class ArmChain:
    """The serial chain of arm joints.

    Pinocchio computes one configuration at a time; for thirty and more configurations, numpy arrays are faster.
    """

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


IndexArray = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Shape:
    """One shape in the frame of the arm joint that carries it, or in the world."""

    depth: int
    """Number of arm joints that carry it."""
    center: FloatArray
    """Centre of its bounding sphere and box (3,), [m]."""
    rotation: FloatArray
    """Rotation of the box (3, 3)."""
    half: FloatArray
    """Half the edges of the box (3,), [m]."""
    radius: float
    """Radius of the bounding sphere [m]."""
    reach: FloatArray
    """Largest distance from the axis of each joint that carries it (n,), [m]; 0 for other joints."""


class ArmShapes:
    """Shapes of the arm itself, the same in any world; the fingers may move.

    Args:
        model: The arm.
    """

    def __init__(self, model: RobotModel) -> None:
        self.chain = ArmChain(model)
        self._model = model
        self._joints = [model.full.getJointId(name) for name in model.description.arm_joints]
        self._data, self._still = model.full.createData(), np.zeros(model.size)
        self._geometry: CollisionGeometry | None = None
        self._solids: list[tuple[FloatArray, FloatArray, float]] = []
        self._fingers: bytes | None = None
        self._own: list[_Shape] = []

    def read(self, collision: CollisionModel) -> list[_Shape]:
        """Return all shapes of a collision model in their present state."""
        q, objects = collision.configuration(np.zeros(self._model.size)), collision.geometry.model.geometryObjects
        pin.forwardKinematics(self._model.full, self._data, q)
        own = collision.geometry.first_body
        if collision.geometry is not self._geometry:
            self._geometry, self._solids = collision.geometry, [_extent(item) for item in objects]
        if q.tobytes() != self._fingers:
            self._fingers, self._own = q.tobytes(), [self._shape(objects[k], *self._solids[k]) for k in range(own)]
        return [*self._own, *(self._shape(objects[k], *self._solids[k]) for k in range(own, len(objects)))]

    def place(self, collision: CollisionModel, q: FloatArray) -> None:
        """Set the poses of the shapes of a collision model for the arm at `q` (n,), [rad]."""
        geometry = collision.geometry
        pin.updateGeometryPlacements(self._model.full, self._data, geometry.model, geometry.data, collision.configuration(q))

    def _shape(self, item: pin.GeometryObject, center: FloatArray, half: FloatArray, radius: float) -> _Shape:
        """Return a shape with the `center` (3,) of its box in its own frame, half its edges (3,), and sphere `radius` [m]."""
        T, joint, depth, reach = item.placement, item.parentJoint, 0, self._still
        if joint > 0:
            reach = self._model.chain_reach.of(joint, T.act(center), radius)
            depth = sum(carrier in self._joints for carrier in self._model.full.supports[joint])
            T = self._data.oMi[self._joints[depth - 1]].actInv(self._data.oMi[joint] * T)
        return _Shape(depth, T.act(center), T.rotation, half, radius, reach)


def _extent(item: pin.GeometryObject) -> tuple[FloatArray, FloatArray, float]:
    """Return the centre (3,) of the box and sphere of a solid in its own frame, half the box edges (3,), the radius [m]."""
    solid = item.geometry
    solid.computeLocalAABB()
    box = solid.aabb_local
    return np.array(solid.aabb_center), 0.5 * np.array([box.width(), box.height(), box.depth()]), solid.aabb_radius


class Shapes:
    """All shapes of one world, and the pairs of shapes that may collide.

    Args:
        arm: Shapes of the arm.
        collision: Collision model of the world; its fingers and held bodies do not move relative to the arm.
    """

    def __init__(self, arm: ArmShapes, collision: CollisionModel) -> None:
        self.chain = arm.chain
        found = arm.read(collision)
        self.depth: IndexArray = np.array([shape.depth for shape in found], dtype=np.intp)
        """Number of arm joints that carry each shape, shape (k,)."""
        self.moving: IndexArray = np.flatnonzero(self.depth)
        """Indices of the shapes that the arm carries."""
        moving = [found[k] for k in self.moving.tolist()]
        self.center = np.array([shape.center for shape in found])
        self.rotation = np.array([shape.rotation for shape in found])
        self.half = np.array([shape.half for shape in found])
        self.upright = (np.abs(self.rotation) @ self.half[:, :, None])[:, :, 0]
        """Half the edges of boxes along the axes of their parent frames, or of the world, shape (k, 3), [m]."""
        self.radius = np.array([shape.radius for shape in moving])
        self.reaches = np.array([shape.reach for shape in moving]).reshape(len(moving), -1)
        first, second = collision.geometry.ends
        self.second_farther = self.depth[second] >= self.depth[first]
        """Whether the second shape of a pair is the one that more joints carry, shape (pairs,)."""
        self.far: IndexArray = np.where(self.second_farther, second, first)
        """The shape of each pair that more joints carry, shape (pairs,)."""
        self.near: IndexArray = np.where(self.second_farther, first, second)
        """The other shape of each pair."""


class Pieces:
    """Cubic pieces of a path.

    Args:
        path: The path.
        low: Start parameters (m,).
        high: End parameters (m,), without a knot in between.
    """

    def __init__(self, path: JointPath, low: FloatArray, high: FloatArray) -> None:
        self._path, self.low, self.high = path, low, high
        control = path.bezier(low, high)
        self.middles = 0.125 * (control[:, 0] + 3.0 * (control[:, 1] + control[:, 2]) + control[:, 3])
        """Configurations in the middle of each (m, n), [rad]."""
        self.steps = control - self.middles[:, None]
        """Control points relative to the middle (m, 4, n), [rad]; the piece is in their hull."""
        self.turns = np.abs(self.steps).max(axis=1)
        """Largest motion of each joint from the middle (m, n), [rad]."""

    @classmethod
    def of(cls, path: JointPath) -> Pieces:
        """Return the cubic pieces of the path."""
        knots = path.knots
        return cls(path, knots[:-1], knots[1:])

    def cut(self, which: NDArray[np.intp], counts: NDArray[np.intp]) -> Pieces:
        """Return pieces `which` (k,), each divided into `counts` (k,) equal parts, in order."""
        low, width = np.repeat(self.low[which], counts), np.repeat((self.high - self.low)[which] / counts, counts)
        part = np.arange(len(low)) - np.repeat(np.cumsum(counts) - counts, counts)
        last = part + 1 == np.repeat(counts, counts)
        return Pieces(
            self._path, low + part * width, np.where(last, np.repeat(self.high[which], counts), low + (part + 1) * width)
        )


class Poses:
    """Placed shapes.

    No joint moves by more than T_j, so that no point of a shape moves farther than

        D = sum_j min(l_j + D0 / (1 - sum_i T_i), r_j) T_j,  D0 = sum_i l_i T_i               (1)

    with levers l_j, the largest distance of its bounding sphere from the joint axis, and reaches r_j (`robot.distances`).

    Args:
        shapes: The shapes.
        pieces: The m pieces; shapes are placed in the middle of each.
    """

    def __init__(self, shapes: Shapes, pieces: Pieces) -> None:
        self.shapes, self.pieces, q = shapes, pieces, pieces.middles
        self.arm = shapes.chain.place(q)
        moving, carrier = shapes.moving, shapes.depth[shapes.moving] - 1
        rotations = self.arm.rotations.take(carrier, axis=1)
        centers = (rotations @ shapes.center[moving, :, None])[..., 0] + self.arm.origins.take(carrier, axis=1)
        halves = (np.abs(rotations @ shapes.rotation[moving]) @ shapes.half[moving, :, None])[..., 0]
        self._row = np.zeros(len(shapes.depth), dtype=np.intp)
        self._row[moving] = np.arange(len(moving))
        self._centers = np.repeat(shapes.center.T[:, None], len(q), axis=1)  # (3, m, k): numpy is fast along the last axis
        self._halves = np.repeat(shapes.upright.T[:, None], len(q), axis=1)
        self._centers[:, :, moving] = centers.transpose(2, 0, 1)
        self._halves[:, :, moving] = halves.transpose(2, 0, 1)
        self._measure_levers(centers)

    def _measure_levers(self, centers: FloatArray) -> None:
        """Compute equation (1) for moving shapes with sphere centres (m, s, 3)."""
        arm, shapes, turns = self.arm, self.shapes, self.pieces.turns
        count, size = turns.shape
        speeds = skew(arm.angular).reshape(count, 3 * size, 3) @ centers.swapaxes(1, 2)
        speeds = speeds.reshape(count, size, 3, -1) + arm.linear[..., None]  # (m, n, 3, s)
        speeds *= speeds
        levers = np.sqrt(speeds[:, :, 0] + speeds[:, :, 1] + speeds[:, :, 2]).swapaxes(1, 2)
        levers = (levers + shapes.radius[:, None]) * (np.arange(size) < shapes.depth[shapes.moving, None])
        left = np.maximum(1.0 - turns.sum(axis=1), 1e-9)
        growth = (levers @ turns[:, :, None]) / left[:, None, None]
        self.levers = np.minimum(levers + growth, shapes.reaches)
        """Largest distance of a moving shape from the axis of each joint on the piece, shape (m, s, n), [m]."""
        self._parts = np.zeros((*levers.shape[:2], levers.shape[2] + 1))
        np.cumsum(self.levers * turns[:, None], axis=2, out=self._parts[:, :, 1:])

    def levers_of(self, piece: IndexArray, pair: IndexArray) -> FloatArray:
        """Return the levers of the farther shapes of pairs, shape (e, n), [m]."""
        return self.levers[piece, self._row[self.shapes.far[pair]]]

    def moves(self, piece: IndexArray, pair: IndexArray) -> FloatArray:
        """Return the largest relative motion of the two shapes of pairs, shape (e,), [m]."""
        row = self._row[self.shapes.far[pair]]
        return self._parts[piece, row, -1] - self._parts[piece, row, self.shapes.depth[self.shapes.near[pair]]]

    def close(self, pairs: IndexArray, floors: FloatArray) -> tuple[IndexArray, IndexArray]:
        """Return piece and pair (e,) of the pairs that axis-aligned boxes do not clear.

        Args:
            pairs: Indices of the pairs to check.
            floors: Minimum distance of each pair, shape (all pairs,), [m].
        """
        shapes = self.shapes
        far, near = shapes.far[pairs], shapes.near[pairs]
        gap = np.abs(self._centers.take(far, axis=2) - self._centers.take(near, axis=2))  # (3, m, pairs)
        gap -= self._halves.take(far, axis=2)
        gap -= self._halves.take(near, axis=2)
        np.maximum(gap, 0.0, out=gap)
        gap *= gap
        row, depth = self._row[far], shapes.depth[near]
        needed = self._parts[:, row, -1] - self._parts[:, row, depth] + floors[pairs]
        piece, at = np.nonzero((gap[0] + gap[1] + gap[2] < needed * needed) | (needed < 0.0))
        return piece, pairs[at]

    def centers(self, piece: IndexArray, pair: IndexArray) -> FloatArray:
        """Return the centres of the farther shapes of pairs in the world, shape (e, 3), [m]."""
        return self._centers[:, piece, self.shapes.far[pair]].T

    def box(self, piece: IndexArray, pair: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Return the rotations (e, 3, 3) of the boxes of the farther shapes of pairs, and half their edges (e, 3), [m]."""
        far = self.shapes.far[pair]
        rotations = self.arm.rotations[piece, self.shapes.depth[far] - 1] @ self.shapes.rotation[far]
        return rotations, self.shapes.half[far]


def advances(poses: Poses, piece: IndexArray, pair: IndexArray, normal: FloatArray) -> FloatArray:
    """Return the largest motion of the farther shapes of pairs along normals (e, 3) on their pieces, equation (1), (e,), [m].

    In the middle q_m of a piece two convex shapes A and B are a distance d apart along the unit normal n from A to B. A plane
    separates them. With joint motions h = q - q_m in the hull of the piece's control points h_k, and
    |h_j| <= T_j, Taylor's formula gives for each point x of A

        n^T (x(q) - x(q_m)) <= max_k n^T J_x h_k + R,   R = 1/2 sum_ij T_i T_j l_max(i,j)          (1)

    because |d2x / dq_i dq_j| is at most the lever l of x about the axis of the more distal joint. The first term is
    linear in x, so that a box around A bounds it. Only joints between B and A contribute. Motion along the plane adds only R.
    """
    shapes, pieces = poses.shapes, poses.pieces
    joint = np.arange(pieces.turns.shape[1])
    between = (joint >= shapes.depth[shapes.near[pair], None]) & (joint < shapes.depth[shapes.far[pair], None])
    steps, turns = pieces.steps[piece] * between[:, None], pieces.turns[piece] * between
    rest = 0.5 * (poses.levers_of(piece, pair) * turns * (2.0 * np.cumsum(turns, axis=1) - turns)).sum(axis=1)
    across = cross(normal[:, None], steps @ poses.arm.angular[piece])  # n^T (w x x) = (n x w)^T x, shape (e, 4, 3)
    shifts = steps @ poses.arm.linear[piece] @ normal[:, :, None]
    rotation, half = poses.box(piece, pair)
    moved = shifts + across @ poses.centers(piece, pair)[:, :, None] + np.abs(across @ rotation) @ half[:, :, None]
    return moved[:, :, 0].max(axis=1) + rest


WIDEST = 0.08
"""Largest motion of any shape to either side of the middle of an initial piece [m]."""
MIN_CLOSING = 3e-4
"""Approach of a pair on a piece below which an uncleared pair remains undecided [m]."""
_PARTS, _MAX_PARTS = 2.0, 16
DISTANCE_TOLERANCE = 1e-5
"""Amount by which distances have to exceed the margin, because those of Coal are not exact [m]."""


@dataclass(frozen=True)
class Certificate:
    """Result of the continuous check of a path."""

    doubt: float | None
    """First parameter of the path (0..1) that could not be certified; None if the whole path is free."""
    checks: int
    """Number of configurations in which distances were measured."""


class ContinuousCheck:
    """Certifies paths of one motion.

    Args:
        arm: Shapes of the arm.
        collision: Collision model with the rules of the motion, after `begin`.
    """

    def __init__(self, arm: ArmShapes, collision: CollisionModel) -> None:
        self._arm, self._collision = arm, collision

    @cached_property
    def _shapes(self) -> Shapes:
        return Shapes(self._arm, self._collision)

    def certify(self, path: JointPath, checks: int) -> Certificate:
        """Try to certify that `path` is free of forbidden contacts everywhere between its ends.

        Args:
            path: Smooth path.
            checks: Maximum number of configurations in which distances are measured.
        """
        counts, floors = self._collision.least_distances()
        floors, pieces, spent = floors + DISTANCE_TOLERANCE, self._begin(path), 0
        poses = Poses(self._shapes, pieces)
        piece, pair = poses.close(np.flatnonzero(counts), floors)
        while len(pair):
            spent += len(pieces.low)
            distance, normal = self._measure(pieces.middles, piece, pair)
            room, moves = distance - floors[pair], poses.moves(piece, pair)
            left = np.flatnonzero(room < moves)
            piece, pair, room, moves, normal = piece[left], pair[left], room[left], moves[left], normal[left]
            closing = np.minimum(moves, advances(poses, piece, pair, normal))
            left = np.flatnonzero(room < closing)
            piece, pair, room, closing = piece[left], pair[left], room[left], closing[left]
            hopeless = (room <= 0.0) | (closing < MIN_CLOSING)
            if hopeless.any() or (len(left) and spent > checks):
                return Certificate(float(pieces.low[piece[hopeless] if hopeless.any() else piece].min()), spent)
            if len(left):
                pieces, piece, pair = _cut(pieces, piece, pair, closing / room)
                poses = Poses(self._shapes, pieces)
        return Certificate(None, spent)

    def _begin(self, path: JointPath) -> Pieces:
        """Divide a path into pieces on which no shape moves much farther than `WIDEST` from its middle."""
        pieces, reaches = Pieces.of(path), self._shapes.reaches.max(axis=0)
        return pieces.cut(np.arange(len(pieces.low)), np.maximum(1, np.ceil(pieces.turns @ reaches / WIDEST)).astype(np.intp))

    def _measure(self, q: FloatArray, piece: IndexArray, pair: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Measure pairs in configurations q[piece], (m, n).

        Returns:
            Distances (e,), [m], negative where shapes overlap; normals (e, 3) from the farther shape to the other one.
        """
        distances, normals = [], []
        geometry, placed, last = self._collision.geometry.model, self._collision.geometry.data, -1
        for i, k in zip(piece.tolist(), pair.tolist(), strict=True):
            if i != last:
                self._arm.place(self._collision, q[i])
                last = i
            result = pin.computeDistance(geometry, placed, k)
            distances.append(result.min_distance)
            normals.append(result.normal)
        normal = np.array(normals)
        normal[self._shapes.second_farther[pair]] *= -1.0  # Coal's point from the first to the second shape
        return np.array(distances), normal


def _cut(pieces: Pieces, piece: IndexArray, pair: IndexArray, shares: FloatArray) -> tuple[Pieces, IndexArray, IndexArray]:
    """Divide the pieces with remaining pairs, and assign these pairs to all parts, in the order of pieces.

    Args:
        pieces: All pieces.
        piece: Index of the piece (e,) of each remaining pair, in ascending order.
        pair: Index of the pair (e,).
        shares: Ratio of the possible loss of distance on the piece to the available distance (e,).
    """
    chosen, first = np.unique(piece, return_index=True)
    counts = np.clip(np.ceil(_PARTS * np.maximum.reduceat(shares, first)), 2, _MAX_PARTS).astype(np.intp)
    parts = pieces.cut(chosen, counts)
    pairs = np.split(pair, first[1:])
    owner = np.repeat(np.arange(len(chosen)), counts)
    sizes = np.array([len(some) for some in pairs])
    return parts, np.repeat(np.arange(len(owner)), sizes[owner]), np.concatenate([pairs[k] for k in owner.tolist()])


def certify(path: JointPath, collision: CollisionModel, checks: int = 20_000) -> Certificate:
    """Try to certify that `path` keeps the rules of the motion that `collision` has begun, everywhere between its ends.

    Args:
        path: Smooth path.
        collision: Collision model with the rules of the motion: pairs and minimum distances; see `CollisionModel.begin`.
        checks: Maximum number of configurations; a path that needs more is not certified.
    """
    as_record(path, JointPath, "path")
    as_record(collision, CollisionModel, "collision")
    checks = as_whole(checks, "checks", least=0, most=LARGEST_COUNT)
    return ContinuousCheck(ArmShapes(collision.model), collision).certify(path, checks)


@dataclass(eq=False)
class Rules:
    """The rules of one motion, which `collision` has begun."""

    collision: CollisionModel
    """Collision model that checks configurations."""
    config: PlannerConfig
    """Settings: resolution and budget of the checks."""
    continuous: ContinuousCheck
    """Continuous check of paths of this motion."""
    world: bool = True
    """Check collisions with the world; otherwise only of the arm and held bodies with the arm itself."""
    doubts: int = 0
    """Number of paths that passed all samples and could not be certified."""
    measured: int = 0
    """Number of configurations in which continuous checks measured distances."""

    def is_free(self, q: FloatArray) -> bool:
        """Return whether a configuration (n,) keeps the rules."""
        return not self.collision.collides(q)

    def first_violation(self, path: JointPath) -> float | None:
        """Return the first parameter (0..1) of a path that violates the rules or is not certified; None if there is none."""
        hit = path.first_collision(self.is_free, self.config.check_step)
        if hit is None and self.config.certify:
            certificate = self.continuous.certify(path, self.config.certify_checks)
            hit = certificate.doubt
            self.doubts += hit is not None
            self.measured += certificate.checks
        return hit

    def blocked_edges(self, path: FloatArray) -> list[int]:
        """Return the edges of a polyline (m, n) that are not free, with checks every `config.check_step`."""
        step = self.config.check_step
        return [i for i, (a, b) in enumerate(pairwise(path)) if not edge_is_free(a, b, self.is_free, step)]
