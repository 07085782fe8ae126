"""Collision checks of configurations: the arm, held bodies and the world of a snapshot, by Coal.

`update` sets the world from a snapshot, `begin` sets the rules of one motion (allowed contacts, clearance), and `in_collision`
checks a configuration.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.errors import StartInCollision
from rlbench_pin.robot.geometry import Part, bounds, link_geometry, primitive
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import BodySnapshot, WorldSnapshot
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.urdf import disabled_pairs
from rlbench_pin.values import as_flag, as_names, as_number, as_record, as_several, as_vector

Kind = Literal["arm", "gripper", "held", "object", "room"]


@dataclass(frozen=True)
class Owner:
    """The body and link that a shape belongs to."""

    body: str
    """Name of the body, or of the arm."""
    link: str
    """Name of the link."""
    kind: Kind
    """Kind of the owner: the arm, its gripper, a held body, an object, or the room."""

    @property
    def label(self) -> str:
        """Name in reports: the link of the arm, or the body."""
        return self.link if self.kind in ("arm", "gripper") else self.body

    @property
    def moves(self) -> bool:
        """Whether the arm carries the shape."""
        return self.kind in ("arm", "gripper", "held")


@dataclass(frozen=True, eq=False)
class Distance:
    """The nearest points of two bodies; the distance is negative if they overlap."""

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
    """The shapes of a set of bodies, the pairs to check, and their placements.

    Args:
        model: The arm.
        bodies: Bodies with collision geometry.
        held: Names of the bodies that move with the gripper.
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
        """Index of the first shape that does not belong to the arm."""
        for body in bodies:
            self._add_body(body)
        checked = np.triu(self._checked())
        self.model.setCollisionPairs(checked)
        self.ends: NDArray[np.intp] = np.stack(np.nonzero(checked))
        """The first and the second shapes of all pairs, shape (2, pairs)."""
        self.pairs: list[tuple[int, int]] = list(zip(*self.ends.tolist(), strict=True))
        self.data = self.model.createData()
        _forget_guesses(self.data)
        moves = np.array([owner.moves for owner in self.owners])
        self.crosses = moves[:, None] != moves[None, :]
        """Mask of the pairs between the arm or a held body and the world, shape (m, m)."""
        self._poses: dict[int, FloatArray] = {}

    def place(self, bodies: Sequence[BodySnapshot], T_world_hand_joint: pin.SE3) -> None:
        """Update the placements of all bodies; held bodies are placed relative to the present gripper pose."""
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
        """Return the owners of the shapes of pair `k`."""
        i, j = self.pairs[k]
        return self.owners[i], self.owners[j]

    def nearest_points(self, k: int, result: coal.DistanceResult) -> Distance:
        """Return the nearest points of pair `k`, computed by Coal."""
        a, b = self.owners_of(k)
        points = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
        return Distance(a.label, b.label, float(result.min_distance), *points, np.array(result.normal))

    @property
    def hand_joint(self) -> int:
        """Index of the joint that carries the gripper in Pinocchio."""
        return int(self._hand_joint)

    def _add_robot(self) -> None:
        description, full = self._model.description, self._model.full
        gripper = {*self._model.fingers.links}
        for link, parts in link_geometry(description.urdf).items():
            frame_id = full.getFrameId(link)
            frame = full.frames[frame_id]
            owner = Owner(description.name, link, "gripper" if link in gripper else "arm")
            for k, (shape, placement) in enumerate(parts):
                placed = frame.placement * placement
                self.model.addGeometryObject(pin.GeometryObject(f"{link}:{k}", frame.parentJoint, frame_id, placed, shape))
                self.owners.append(owner)

    def _add_body(self, body: BodySnapshot) -> None:
        held = body.name in self._held
        kind: Kind = "held" if held else "room" if body.in_room else "object"
        joint = self._hand_joint if held else 0
        geometry = body_geometry(body)
        for link in body.link_names:
            for k, (shape, _) in enumerate(geometry.get(link, ())):
                name = f"{body.name}/{link}:{k}"
                self.model.addGeometryObject(pin.GeometryObject(name, joint, pin.SE3.Identity(), shape))
                self.owners.append(Owner(body.name, link, kind))

    def _checked(self) -> NDArray[np.bool_]:
        """Return the mask of the pairs of shapes that are checked, shape (m, m), symmetric."""
        joints = np.array([shape.parentJoint for shape in self.model.geometryObjects])
        kinds = np.array([owner.kind for owner in self.owners])
        held, gripper = kinds == "held", kinds == "gripper"
        never = held[:, None] & (held | gripper)
        checked = (joints[:, None] != joints) & ~(never | never.T)
        for i, j in combinations(range(self.first_body), 2):
            pair = frozenset((self.owners[i].link, self.owners[j].link))
            if len(pair) == 1 or pair in self._excluded:
                checked[i, j] = checked[j, i] = False
        return checked


def body_geometry(body: BodySnapshot) -> Mapping[str, tuple[Part, ...]]:
    """Return the collision shapes of each link of a body, from its model file or from its record."""
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
    """Reset the start of each query, so that a distance depends only on poses, bit-identical for any earlier query."""
    if len(data.distanceRequests) == 0:
        return
    request, requests = data.distanceRequests[0], coal.StdVec_DistanceRequest()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Coal's new name for this setting leaves the old one switched on
        request.enable_cached_gjk_guess = False
    requests.extend([request] * len(data.distanceRequests))
    data.distanceRequests = requests


TOUCH = 5e-4
"""Distance below which objects touch at the start of a motion [m]."""
SLACK = 2e-3
"""Allowed further penetration of a contact at the start [m]."""
DEEPEST = 1e-2
"""Maximum penetration of the room, or of the arm itself, at the start [m]."""
MIN_MARGIN = 2e-4
"""Smallest margin that can be distinguished from contact [m]."""
GOAL_TOLERANCE = 5e-4
"""Penetration accepted in a goal configuration [m]; a held body, which may be set down, gets `SLACK`."""
_FEW = 100
"""Number of shapes up to which comparing all boxes is faster than a tree of boxes."""


class CollisionModel:
    """Collision checks for one arm in a changing world. Not thread-safe."""

    def __init__(self, model: RobotModel) -> None:
        """Start in an empty world, with the arm at home and open fingers."""
        self.model = as_record(model, RobotModel, "model")
        self.checks = 0
        """Number of configurations checked so far."""
        self._data = model.full.createData()
        self._arm_index = as_slice(model.full_index[: model.size])
        self._layout: object = None
        fingers = np.full(len(model.description.gripper_joints), model.description.gripper_open)
        self.update(WorldSnapshot((), model.home, fingers))

    def update(self, snapshot: WorldSnapshot) -> None:
        """Set bodies, finger positions and held bodies; fast if the same bodies are present and held.

        A held body that is fixed to the world cannot follow the gripper, so it is omitted.
        """
        as_record(snapshot, WorldSnapshot, "snapshot")
        self._q = self.model.full_configuration(snapshot.arm, snapshot.fingers)
        bodies = [body for body in snapshot.bodies if body.collides and not (body.fixed and body.name in snapshot.attached)]
        bodies = [body for body in bodies if not self._is_beyond_reach(body)]
        layout = (snapshot.attached, tuple(b.layout for b in bodies))
        if layout != self._layout:
            self._geometry = CollisionGeometry(self.model, bodies, snapshot.attached)
            self._wide_data: pin.GeometryData | None = None
            self._layout = layout
        pin.forwardKinematics(self.model.full, self._data, self._q)
        self._geometry.place(bodies, self._data.oMi[self._geometry.hand_joint])
        self.clear()

    # The rules of one motion --------------------------------------------------------------------------------------

    def clear(self) -> None:
        """Remove the rules of the last motion: all pairs are checked, without clearance."""
        count = len(self._geometry.owners)
        self._active = np.ones((count, count), dtype=bool)
        self._margins = np.zeros((count, count))
        self._apply()

    def allow(self, names: Collection[str]) -> None:
        """Allow the arm and held bodies to touch the objects called `names`, until the next `begin`, `clear` or `update`.

        Contacts with the room (table, floor, walls) are not allowed by this method.
        """
        self._allow(as_names(names, "names"))
        self._apply()

    def begin(
        self, q_start: FloatArray, *, margin: float = 0.0, own: float = 0.0, allowed: Collection[str] = (), world: bool = True
    ) -> None:
        """Set the rules of one motion from its start configuration.

        World bodies keep `margin` [m] from the arm and links keep `own` [m] from each other; pairs that are nearer at the start
        may stay as near. Links of objects that touch the arm at the start may be touched. Contacts at the start with the room, or
        of a held body, may not become deeper. Without `world`, only the arm is checked, and no start is rejected.

        Raises:
            StartInCollision: The start penetrates the room or the arm itself.
        """
        q_start = as_vector(q_start, self.model.size, "start configuration")
        margin, own = as_number(margin, "margin [m]", least=0.0), as_number(own, "own [m]", least=0.0)
        as_names(allowed, "allowed")
        self._active = np.ones(self._active.shape, dtype=bool) if as_flag(world, "world") else ~self._geometry.crosses
        self._margins = np.where(self._geometry.crosses, margin, own)
        self._allow(allowed)
        self._apply()
        if self.in_collision(q_start):
            self._admit_start(q_start, world)

    def relax(self, q: FloatArray) -> None:
        """Reduce the clearance of this motion for pairs that are nearer in configuration `q`, its goal."""
        near = self._near(q) if self.in_collision(q) else ()
        for k, depth in near:
            self._set_margin(k, depth - 1e-4)
        if near:
            self._apply()

    @contextmanager
    def wider(self, more: float, ends: Sequence[FloatArray]) -> Iterator[None]:
        """Keep `more` clearance [m] to the world during a block, except for pairs that are nearer in configurations `ends`."""
        more = as_number(more, "more [m]", least=0.0)
        ends = [as_vector(q, self.model.size, "an entry of ends") for q in as_several(ends, "ends")]
        before, self._margins = self._margins, np.where(
            self._geometry.crosses & (self._margins >= MIN_MARGIN), self._margins + more, self._margins
        )  # fmt: skip
        self._apply()
        try:
            for q in ends:
                self.relax(q)
            yield
        finally:
            self._margins = before
            self._apply()

    def _apply(self) -> None:
        geometry = self._geometry
        geometry.data.setActiveCollisionPairs(geometry.model, self._active)
        geometry.data.setSecurityMargins(geometry.model, self._margins)
        self._manager = self._broad_phase(geometry.data)
        self._level = -1.0

    def _broad_phase(self, data: pin.GeometryData) -> object:
        few = len(self._geometry.owners) <= _FEW
        kind = pin.BroadPhaseManager_NaiveCollisionManager if few else pin.BroadPhaseManager_SSaPCollisionManager
        return kind(self.model.full, self._geometry.model, data)

    def _is_beyond_reach(self, body: BodySnapshot) -> bool:
        """Return whether the arm and held bodies cannot reach a part of the room, such as a far wall."""
        return body.in_room and body_distance(body, self.model.base.translation) > self.model.description.reach

    def _allow(self, names: Collection[str]) -> None:
        named = np.array([o.body in names and o.kind == "object" for o in self._geometry.owners], dtype=bool)
        self._active[named, :] = False
        self._active[:, named] = False

    def _admit_start(self, q_start: FloatArray, refuses: bool) -> None:
        """Relax the rules that the start already violates; `refuses` selects pairs with too large violations."""
        refused: dict[tuple[str, str], float] = {}
        for k, depth in self._near(q_start):
            a, b = self._geometry.owners_of(k)
            kinds = {a.kind, b.kind}
            if "object" in kinds and "held" not in kinds:
                if depth < TOUCH:
                    self._ignore(a, b)
                    continue
            elif depth < -DEEPEST and kinds != {"held", "object"}:
                refused[a.label, b.label] = max(-depth, refused.get((a.label, b.label), 0.0))
            slack = SLACK if depth < TOUCH else min(SLACK, 0.5 * depth)
            self._set_margin(k, -np.inf if depth < -DEEPEST else depth - slack)
        if refused and refuses:
            pairs = sorted(refused)
            raise StartInCollision(pairs, [refused[pair] for pair in pairs])
        self._apply()

    def _ignore(self, a: Owner, b: Owner) -> None:
        """Allow a link of the arm (or the whole gripper, if it is a part of it) to touch one link of an object."""
        robot, item = (b, a) if a.kind == "object" else (a, b)
        owners = self._geometry.owners
        one = np.array([o.kind == "gripper" if robot.kind == "gripper" else o == robot for o in owners])
        other = np.array([o == item for o in owners])
        self._active[np.ix_(one, other)] = False
        self._active[np.ix_(other, one)] = False

    def _set_margin(self, k: int, margin: float) -> None:
        """Reduce the margin of a pair; minus infinity removes the pair."""
        i, j = self._geometry.pairs[k]
        if np.isinf(margin):
            self._active[i, j] = self._active[j, i] = False
        else:
            self._margins[i, j] = self._margins[j, i] = min(self._margins[i, j], margin)

    @property
    def geometry(self) -> CollisionGeometry:
        """All shapes and their pairs, with the placements of the last update."""
        return self._geometry

    def configuration(self, q: FloatArray) -> FloatArray:
        """Return the Pinocchio configuration of arm `q` (n,), [rad], and fingers; the array is reused."""
        self._q[self._arm_index] = q
        return self._q

    def least_distances(self) -> tuple[NDArray[np.bool_], FloatArray]:
        """Return for each pair of shapes whether it is checked, and its minimum distance in any motion, shapes (pairs,), [m]."""
        first, second = self._geometry.ends
        return self._active[first, second], self._floors()[first, second]

    # Questions ----------------------------------------------------------------------------------------------------

    def in_collision(self, q: FloatArray) -> bool:
        """Return whether arm configuration `q` violates the rules: a forbidden contact, or a distance below its margin."""
        return self.collides(as_vector(q, self.model.size, "configuration"))

    def collides(self, q: FloatArray) -> bool:
        """Return the result of `in_collision` without a check of the argument `q` (n,), for searches with many calls."""
        self.checks += 1
        self._q[self._arm_index] = q
        return bool(pin.computeCollisions(self.model.full, self._data, self._manager, self._q, True))

    def keeps_away(self, q: FloatArray, distance: float) -> bool:
        """Return whether configuration `q` is at least `distance` [m] away from all forbidden contacts.

        For pairs that start or end in contact, or nearer than `MIN_MARGIN`, the distance is measured from `SLACK / 2` below
        their margin. Repeated calls with the same distance are fastest.
        """
        self.checks += 1
        if distance is not self._level and as_number(distance, "distance [m]") != self._level:
            self._widen(distance)
        self._q[self._arm_index] = as_vector(q, self.model.size, "configuration")
        return not pin.computeCollisions(self.model.full, self._data, self._wide, self._q, True)

    def _widen(self, distance: float) -> None:
        """Prepare checks with margins of `distance` above contact."""
        geometry = self._geometry
        if self._wide_data is None:
            self._wide_data = geometry.model.createData()
        self._wide_data.setActiveCollisionPairs(geometry.model, self._active)
        self._wide_data.setSecurityMargins(geometry.model, self._floors() + distance)
        self._wide = self._broad_phase(self._wide_data)
        self._level = distance

    def _floors(self) -> FloatArray:
        """Return the minimum distance in any motion, for each pair of shapes (m, m), [m]."""
        sure = (self._margins >= MIN_MARGIN) | (self._margins == 0.0)
        return np.where(sure, 0.0, self._margins - 0.5 * SLACK)

    def goal_in_collision(self, q: FloatArray) -> bool:
        """Return the result of `in_collision` without clearance: a goal may be near objects, and a held body may be put down."""
        if not self.in_collision(q):
            return False
        for k, depth in self._near(q):
            tolerance = SLACK if "held" in {o.kind for o in self._geometry.owners_of(k)} else GOAL_TOLERANCE
            if depth < min(-tolerance, self._margins[self._geometry.pairs[k]]):
                return True
        return False

    def colliding_pairs(self, q: FloatArray) -> list[tuple[str, str]]:
        """Return the pairs of names in contact in configuration `q`, links of the arm first."""
        return sorted({(a.label, b.label) for a, b in map(self._geometry.owners_of, self._breaking(q))})

    def penetrations(self, q: FloatArray) -> tuple[list[tuple[str, str]], list[float]]:
        """Return the pairs of names in contact, deepest first, and the penetration [m]; negative if only a margin is violated."""
        deepest: dict[tuple[str, str], float] = {}
        for k, distance in self._near(q):
            a, b = self._geometry.owners_of(k)
            deepest[a.label, b.label] = max(-distance, deepest.get((a.label, b.label), -np.inf))
        pairs = sorted(deepest, key=lambda pair: (-deepest[pair], pair))
        return pairs, [deepest[pair] for pair in pairs]

    def distances(self, q: FloatArray, within: float = np.inf) -> list[Distance]:
        """Return the distances of all active pairs nearer than `within` [m], nearest first, without margins."""
        within = as_number(within, "within [m]", finite=False)
        self._q[self._arm_index] = as_vector(q, self.model.size, "configuration")
        geometry = self._geometry
        pin.computeDistances(self.model.full, self._data, geometry.model, geometry.data, self._q)
        found = [
            geometry.nearest_points(k, result)
            for k, result in enumerate(geometry.data.distanceResults)
            if result.min_distance < within and self._active[geometry.pairs[k]]
        ]
        return sorted(found, key=lambda d: d.distance)

    def distance(self, q: FloatArray) -> Distance | None:
        """Return the smallest distance of the arm or a held body to any body; None if there is no pair."""
        return next(iter(self.distances(q)), None)

    def _breaking(self, q: FloatArray) -> list[int]:
        """Return the indices of the active pairs that violate their margin."""
        self._q[self._arm_index] = as_vector(q, self.model.size, "configuration")
        geometry = self._geometry
        pin.computeCollisions(self.model.full, self._data, geometry.model, geometry.data, self._q, False)
        active = geometry.data.activeCollisionPairs
        return [k for k, result in enumerate(geometry.data.collisionResults) if active[k] and result.isCollision()]

    def _near(self, q: FloatArray) -> list[tuple[int, float]]:
        """Return pair index and distance [m] of the active pairs that violate their margin."""
        geometry = self._geometry
        return [(k, pin.computeDistance(geometry.model, geometry.data, k).min_distance) for k in self._breaking(q)]


def as_slice(index: FloatArray) -> slice | FloatArray:
    """Return a slice instead of consecutive indices, for faster writes."""
    first = int(index[0])
    return slice(first, first + len(index)) if np.array_equal(index, np.arange(first, first + len(index))) else index
