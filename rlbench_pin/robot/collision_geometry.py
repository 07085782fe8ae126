"""All shapes that may meet, in one Pinocchio geometry model: the arm, what it holds, and the bodies of a snapshot."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.robot.geometry import Part, bounds, link_geometry, primitive
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import BodySnapshot
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.urdf import disabled_pairs

Kind = Literal["arm", "hand", "held", "thing", "room"]


@dataclass(frozen=True)
class Owner:
    """What a shape belongs to."""

    body: str
    """Name of the body, or of the arm."""
    link: str
    """Name of the link."""
    kind: Kind
    """Part of the arm, of its hand, a held body, an object, or the room."""

    @property
    def label(self) -> str:
        """Name in reports: the link of the arm, or the body."""
        return self.link if self.kind in ("arm", "hand") else self.body

    @property
    def moves(self) -> bool:
        """Whether the arm carries it."""
        return self.kind in ("arm", "hand", "held")


@dataclass(frozen=True, eq=False)
class Distance:
    """The nearest points of two things; negative when they overlap."""

    a: str
    """A link of the arm, or a held body."""
    b: str
    """A body of the world, or another link of the arm."""
    distance: float
    """[m]."""
    point_a: FloatArray
    """World position (3,) on `a`."""
    point_b: FloatArray
    """World position (3,) on `b`."""
    normal: FloatArray
    """Unit vector (3,) from `a` to `b`."""


class CollisionGeometry:
    """The shapes of one set of bodies, the pairs worth checking, and placements that can be renewed.

    Args:
        model: The arm.
        bodies: Bodies with collision geometry.
        held: Names of those that move with the hand.
    """

    def __init__(self, model: RobotModel, bodies: Sequence[BodySnapshot], held: Collection[str]) -> None:
        self._model, self._held = model, frozenset(held)
        hand_frame = model.full.frames[model.full.getFrameId(model.description.hand_link)]
        self._hand_joint = hand_frame.parentJoint
        self.model = pin.GeometryModel()
        self.owners: list[Owner] = []
        self._excluded = disabled_pairs(model.description.srdf)
        self._add_robot()
        self.first_body = len(self.owners)
        """Index of the first shape that is not the arm's own."""
        for body in bodies:
            self._add_body(body)
        self._add_pairs()
        self.pairs: list[tuple[int, int]] = [(pair.first, pair.second) for pair in self.model.collisionPairs]
        self.ends: NDArray[np.intp] = np.array(self.pairs, dtype=np.intp).reshape(-1, 2).T
        """The first and the second shapes of all pairs, shape (2, pairs)."""
        self.data = self.model.createData()
        _forget_guesses(self.data)
        moves = np.array([owner.moves for owner in self.owners])
        self.crosses = moves[:, None] != moves[None, :]
        """Which pairs are of the arm or a held body with the world, shape (m, m)."""
        self._poses: dict[int, FloatArray] = {}

    def place(self, bodies: Sequence[BodySnapshot], T_world_hand_joint: pin.SE3) -> None:
        """Write the placements of all bodies; those held relative to the hand as it is now."""
        T_hand_world = T_world_hand_joint.inverse()
        objects = self.model.geometryObjects
        index = self.first_body
        for body in bodies:
            held = body.name in self._held
            geometry = body_geometry(body)
            for link, pose in zip(body.link_names, body.link_poses, strict=True):
                parts = geometry.get(link, ())
                if parts and (held or index not in self._poses or not np.array_equal(self._poses[index], pose)):
                    self._poses[index] = pose.copy()
                    T_joint_link = T_hand_world * pose_to_se3(pose) if held else pose_to_se3(pose)
                    for k, (_, placement) in enumerate(parts):
                        objects[index + k].placement = T_joint_link * placement
                index += len(parts)

    def owners_of(self, k: int) -> tuple[Owner, Owner]:
        """Return what the shapes of pair `k` belong to."""
        i, j = self.pairs[k]
        return self.owners[i], self.owners[j]

    def nearest_points(self, k: int, result: coal.DistanceResult) -> Distance:
        """Return what Coal found for pair `k` as a record."""
        a, b = self.owners_of(k)
        points = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
        return Distance(a.label, b.label, float(result.min_distance), *points, np.array(result.normal))

    @property
    def hand_joint(self) -> int:
        """Pinocchio's number of the joint that carries the hand."""
        return int(self._hand_joint)

    def _add_robot(self) -> None:
        description, full = self._model.description, self._model.full
        hand = {description.hand_link, *description.finger_links}
        for link, parts in link_geometry(description.urdf).items():
            frame_id = full.getFrameId(link)
            frame = full.frames[frame_id]
            owner = Owner(description.name, link, "hand" if link in hand else "arm")
            for k, (shape, placement) in enumerate(parts):
                placed = frame.placement * placement
                self.model.addGeometryObject(pin.GeometryObject(f"{link}:{k}", frame.parentJoint, frame_id, placed, shape))
                self.owners.append(owner)

    def _add_body(self, body: BodySnapshot) -> None:
        held = body.name in self._held
        kind: Kind = "held" if held else "room" if body.in_room else "thing"
        joint = self._hand_joint if held else 0
        geometry = body_geometry(body)
        for link in body.link_names:
            for k, (shape, _) in enumerate(geometry.get(link, ())):
                name = f"{body.name}/{link}:{k}"
                self.model.addGeometryObject(pin.GeometryObject(name, joint, pin.SE3.Identity(), shape))
                self.owners.append(Owner(body.name, link, kind))

    def _add_pairs(self) -> None:
        joints = [shape.parentJoint for shape in self.model.geometryObjects]
        for j in range(len(joints)):
            for i in range(j):
                if joints[i] != joints[j] and self._matters(self.owners[i], self.owners[j]):
                    self.model.addCollisionPair(pin.CollisionPair(i, j))

    def _matters(self, a: Owner, b: Owner) -> bool:
        kinds = {a.kind, b.kind}
        if kinds <= {"arm", "hand"}:
            return a.link != b.link and frozenset((a.link, b.link)) not in self._excluded
        return kinds != {"held"} and kinds != {"held", "hand"}


def body_geometry(body: BodySnapshot) -> Mapping[str, tuple[Part, ...]]:
    """Return the collision shapes of every link of a body: those of its model file, or its own."""
    if not body.shapes:
        return link_geometry(body.urdf, body.scale)
    return {body.link_names[0]: tuple(primitive(shape) for shape in body.shapes)}


def body_distance(body: BodySnapshot, point: FloatArray) -> float:
    """Return a lower bound of the distance between a body and a world point (3,), [m]."""
    geometry, least = body_geometry(body), np.inf
    for link, pose in zip(body.link_names, body.link_poses, strict=True):
        if link in geometry:
            box = bounds(geometry[link])
            local = pose_to_se3(pose).actInv(point)
            least = min(least, float(np.linalg.norm(np.maximum(0.0, np.maximum(box[0] - local, local - box[1])))))
    return least


def _forget_guesses(data: pin.GeometryData) -> None:
    """Let every query start afresh, so that a distance depends on poses alone, not on the query before, to the last bit."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Coal's new name for this setting leaves the old one switched on
        for request in data.distanceRequests:
            request.enable_cached_gjk_guess = False
