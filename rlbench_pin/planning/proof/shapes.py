"""The shapes of an arm and of its world as arrays: centres, boxes, and which joint carries them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.planning.proof.chain import ArmChain
from rlbench_pin.robot.collision import CollisionGeometry, CollisionModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray

IndexArray = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Shape:
    """One shape in the frame of the arm joint that carries it, or in the world."""

    depth: int
    """How many arm joints carry it."""
    center: FloatArray
    """Of the ball and the box around it (3,), [m]."""
    rotation: FloatArray
    """Of the box (3, 3)."""
    half: FloatArray
    """Half the edges of the box (3,), [m]."""
    radius: float
    """Of the ball [m]."""
    reach: FloatArray
    """How far it can get from the axis of each joint that carries it (n,), [m]; 0 for other joints."""


class ArmShapes:
    """What is known of an arm's own shapes in any world; the fingers may move.

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
        """Return all shapes of a collision model as they are now."""
        q, objects = collision.configuration(np.zeros(self._model.size)), collision.geometry.model.geometryObjects
        pin.forwardKinematics(self._model.full, self._data, q)
        own = collision.geometry.first_body
        if collision.geometry is not self._geometry:
            self._geometry, self._solids = collision.geometry, [_extent(item) for item in objects]
        if q.tobytes() != self._fingers:
            self._fingers, self._own = q.tobytes(), [self._shape(objects[k], *self._solids[k]) for k in range(own)]
        return [*self._own, *(self._shape(objects[k], *self._solids[k]) for k in range(own, len(objects)))]

    def place(self, collision: CollisionModel, q: FloatArray) -> None:
        """Put the shapes of a collision model where they are with the arm at `q` (n,), [rad]."""
        geometry = collision.geometry
        pin.updateGeometryPlacements(self._model.full, self._data, geometry.model, geometry.data, collision.configuration(q))

    def _shape(self, item: pin.GeometryObject, center: FloatArray, half: FloatArray, radius: float) -> _Shape:
        """Return a shape; `center` (3,) of its box in its own frame, `half` its edges (3,), `radius` of its ball [m]."""
        T, joint, depth, reach = item.placement, item.parentJoint, 0, self._still
        if joint > 0:
            reach = self._model.chain_reach.of(joint, T.act(center), radius)
            depth = sum(carrier in self._joints for carrier in self._model.full.supports[joint])
            T = self._data.oMi[self._joints[depth - 1]].actInv(self._data.oMi[joint] * T)
        return _Shape(depth, T.act(center), T.rotation, half, radius, reach)


def _extent(item: pin.GeometryObject) -> tuple[FloatArray, FloatArray, float]:
    """Return of a solid, in its own frame, the centre of box and ball (3,), half the box's edges (3,), the ball's radius [m]."""
    solid = item.geometry
    solid.computeLocalAABB()
    box = solid.aabb_local
    return np.array(solid.aabb_center), 0.5 * np.array([box.width(), box.height(), box.depth()]), solid.aabb_radius


class Shapes:
    """All shapes of one world, and the pairs of them that may meet.

    Args:
        arm: The arm's own shapes.
        collision: Has taken over the world; its fingers and held bodies are where they stay.
    """

    def __init__(self, arm: ArmShapes, collision: CollisionModel) -> None:
        self.chain = arm.chain
        found = arm.read(collision)
        self.depth: IndexArray = np.array([shape.depth for shape in found], dtype=np.intp)
        """How many arm joints carry each shape, shape (k,)."""
        self.moving: IndexArray = np.flatnonzero(self.depth)
        """Indices of those that the arm carries."""
        moving = [found[k] for k in self.moving.tolist()]
        self.center = np.array([shape.center for shape in found])
        self.rotation = np.array([shape.rotation for shape in found])
        self.half = np.array([shape.half for shape in found])
        self.upright = (np.abs(self.rotation) @ self.half[:, :, None])[:, :, 0]
        """Half the edges of boxes along the axes of the frames that carry them, or of the world, shape (k, 3), [m]."""
        self.radius = np.array([shape.radius for shape in moving])
        self.reaches = np.array([shape.reach for shape in moving]).reshape(len(moving), -1)
        first, second = collision.geometry.ends
        self.second_farther = self.depth[second] >= self.depth[first]
        """Whether the second shape of a pair is the one that more joints carry, shape (pairs,)."""
        self.far: IndexArray = np.where(self.second_farther, second, first)
        """The shape of each pair that more joints carry, shape (pairs,)."""
        self.near: IndexArray = np.where(self.second_farther, first, second)
        """The other shape of each pair."""
