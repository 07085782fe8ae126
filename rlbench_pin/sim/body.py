"""Bodies of the world: loaded URDF models, poses and joints, and contacts between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import UnknownName
from rlbench_pin.robot import geometry
from rlbench_pin.robot.geometry import Ball, Part, link_geometry, solid_balls, solid_geometry
from rlbench_pin.scene.spec import JointSpec
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.spatial import FloatArray, PoseLike, compose, pose_to_se3, relative, se3_to_pose
from rlbench_pin.urdf import DULL, Finish, read_urdf
from rlbench_pin.values import InvalidNumbers, as_flag, as_number, as_record, as_rows, color_values, finite_vector, pose_vector

BASE = -1
"""PyBullet's number of the base link."""
_MOVABLE = (bullet.JOINT_REVOLUTE, bullet.JOINT_PRISMATIC)


@dataclass(frozen=True)
class JointInfo:
    """One movable joint."""

    name: str
    index: int
    prismatic: bool
    lower: float
    upper: float
    effort: float
    velocity: float


@dataclass(frozen=True, eq=False)
class LoadedModel:
    """One body in the physics server."""

    client: PhysicsClient
    uid: int
    urdf: Path
    scale: float
    links: Mapping[str, int]
    """Link name -> number, base first."""
    joints: Mapping[str, JointInfo]
    T_base_com: pin.SE3
    """Placement of the base link's inertial frame, which is what PyBullet poses a body by."""
    com_at_base: bool
    """True when that placement is the identity."""

    def link_index(self, link: str) -> int:
        """Return PyBullet's number of a link."""
        if not isinstance(link, str) or link not in self.links:
            raise UnknownName(f"link of {self.urdf.stem}", link, tuple(self.links))
        return self.links[link]

    def collision_links(self) -> tuple[str, ...]:
        """Names of the links with collision geometry, base first."""
        shapes = link_geometry(self.urdf, self.scale)
        return tuple(name for name in self.links if name in shapes)

    def solid_links(self) -> tuple[str, ...]:
        """Names of the links that sensors detect: those with collision geometry, or with visuals if no link has any."""
        shapes = solid_geometry(self.urdf, self.scale)
        return tuple(name for name in self.links if name in shapes)

    @cached_property
    def solids(self) -> tuple[tuple[int, Ball, tuple[Part, ...]], ...]:
        """Number, bounding sphere and shapes of every link that sensors detect."""
        balls = solid_balls(self.urdf, self.scale)
        return tuple((self.links[link], balls[link], parts) for link, parts in solid_geometry(self.urdf, self.scale).items())

    def placement(self, index: int = BASE) -> pin.SE3:
        """T_world_link of the URDF frame of the link with number `index`; read once, until the world changes."""
        seen = self.client.placements
        if (self.uid, index) not in seen:
            seen[self.uid, index] = self._read_placement(index)
        return seen[self.uid, index].copy()

    def _read_placement(self, index: int) -> pin.SE3:
        if index != BASE:
            state = bullet.getLinkState(self.uid, index, computeForwardKinematics=1, physicsClientId=self.client.id)
            return _read_se3(state[4] + state[5])
        position, quaternion = bullet.getBasePositionAndOrientation(self.uid, physicsClientId=self.client.id)
        T_world_com = _read_se3(position + quaternion)
        return T_world_com if self.com_at_base else T_world_com * self.T_base_com.inverse()

    def base_pose(self) -> FloatArray:
        """Pose (7,) of the base link frame in the world."""
        return se3_to_pose(self.placement())

    def set_base_pose(self, pose: PoseLike) -> None:
        """Set the pose (7,) of the base link frame."""
        T_world_com = pose_to_se3(pose) if self.com_at_base else pose_to_se3(pose) * self.T_base_com
        com = se3_to_pose(T_world_com).tolist()
        self.client.change(bullet.resetBasePositionAndOrientation, self.uid, com[:3], com[3:])

    def link_pose(self, link: str) -> FloatArray:
        """Pose (7,) of a link's URDF frame in the world."""
        return se3_to_pose(self.placement(self.link_index(link)))

    def link_velocity(self, link: str) -> FloatArray:
        """Velocity (6,) of a link's centre of mass, linear [m/s] then angular [rad/s], in world axes."""
        index = self.link_index(link)
        if index == BASE:
            linear, angular = bullet.getBaseVelocity(self.uid, physicsClientId=self.client.id)
        else:
            state = bullet.getLinkState(self.uid, index, computeLinkVelocity=1, physicsClientId=self.client.id)
            linear, angular = state[6], state[7]
        return np.array(linear + angular)

    def link_pose_at(self, index: int) -> FloatArray:
        """Pose (7,) of the URDF frame of the link with number `index`; not for the base."""
        return se3_to_pose(self.placement(index))


def _read_se3(numbers: tuple[float, ...]) -> pin.SE3:
    """Convert seven numbers of PyBullet like `pose_to_se3`, which raises the error for an invalid pose."""
    pose = np.array(numbers)
    turn = pose[3:]
    norm = math.sqrt(turn @ turn)
    if not 0.0 < norm < math.inf:
        return pose_to_se3(numbers)
    turn /= norm
    return pin.XYZQUATToSE3(pose)


def inspect(client: PhysicsClient, uid: int, urdf: Path, scale: float) -> LoadedModel:
    """Return links and joints of a newly loaded body, as PyBullet numbers them."""
    identifier = client.id
    base_name = bullet.getBodyInfo(uid, physicsClientId=identifier)[0].decode()
    links, joints = {base_name: BASE}, {}
    for index in range(bullet.getNumJoints(uid, physicsClientId=identifier)):
        info = bullet.getJointInfo(uid, index, physicsClientId=identifier)
        links[info[12].decode()] = index
        if info[2] in _MOVABLE:
            joint = _joint_info(info)
            joints[joint.name] = joint
    dynamics = bullet.getDynamicsInfo(uid, BASE, physicsClientId=identifier)
    offset = pose_to_se3((*dynamics[3], *dynamics[4]))
    return LoadedModel(client, uid, urdf, scale, links, joints, offset, bool(offset.isIdentity(0.0)))


def _joint_info(info: tuple) -> JointInfo:
    lower, upper = (info[8], info[9]) if info[8] <= info[9] else (float("-inf"), float("inf"))
    return JointInfo(info[1].decode(), info[0], info[2] == bullet.JOINT_PRISMATIC, lower, upper, info[10], info[11])


_LOCK_FORCE = 1000.0  # [N] or [N m]
_LOCK_GAIN = 0.5


class ObjectJoint:
    """One movable joint of an object.

    Args:
        name: `<body>/<joint>`.
        model: The body it belongs to.
        info: PyBullet's data of the joint.
    """

    def __init__(self, name: str, model: LoadedModel, info: JointInfo) -> None:
        self.name, self.spec = name, JointSpec(name=name)
        self._model, self._info = model, info
        self._locked_at: float | None = None
        self._inertia = _link_inertia(model, info)
        self._drive()

    def configure(self, spec: JointSpec) -> None:
        """Set start position, friction, damping, spring and lock from the scene file."""
        self.spec = spec
        if spec.damping is not None:
            self._change(bullet.changeDynamics, jointDamping=spec.damping)
        self._reset(spec.position)
        self._locked_at = spec.position if spec.locked else None
        self._drive()

    @property
    def lower(self) -> float:
        """Lower limit [m] or [rad]; -inf without one."""
        return self._info.lower

    @property
    def upper(self) -> float:
        """Upper limit [m] or [rad]; inf without one."""
        return self._info.upper

    @property
    def position(self) -> float:
        """Position [m] or [rad]."""
        return self.state()[0]

    @property
    def velocity(self) -> float:
        """Velocity [m/s] or [rad/s]."""
        return self.state()[1]

    def state(self) -> tuple[float, float]:
        """Position and velocity."""
        state = bullet.getJointState(self._model.uid, self._info.index, physicsClientId=self._model.client.id)
        return state[0], state[1]

    def set_position(self, position: float) -> None:
        """Set the joint to a position [m] or [rad] with zero velocity; a lock holds it there from now on."""
        value = as_number(position, f"The value of joint '{self.name}'", InvalidNumbers)
        self._reset(value)
        if self.locked:
            self.set_lock(value)

    def set_state(self, position: float, velocity: float) -> None:
        """Set position and velocity; the lock does not change."""
        position = as_number(position, f"The value of joint '{self.name}'", InvalidNumbers)
        self._reset(position, as_number(velocity, f"The speed of joint '{self.name}'", InvalidNumbers))

    @property
    def locked(self) -> bool:
        """Whether the joint is locked: a stiff motor holds it."""
        return self._locked_at is not None

    @property
    def lock_position(self) -> float | None:
        """Position at which the joint is locked; None if it is free."""
        return self._locked_at

    def lock(self) -> None:
        """Lock the joint at its position."""
        self.set_lock(self.position)

    def unlock(self) -> None:
        """Release the lock."""
        self.set_lock(None)

    def set_lock(self, position: float | None) -> None:
        """Lock the joint at a position [m] or [rad], or release it if None.

        Raises:
            InvalidNumbers: The position is not a finite number (also a ValueError).
        """
        if position is not None:
            position = as_number(position, f"The value of joint '{self.name}'", InvalidNumbers)
        if position != self._locked_at:
            self._locked_at = position
            self._drive()

    def _reset(self, position: float, velocity: float = 0.0) -> None:
        self._change(bullet.resetJointState, position, targetVelocity=velocity)

    def _change(self, function: Callable[..., None], *positional: float, **named: float) -> None:
        self._model.client.change(function, self._model.uid, self._info.index, *positional, **named)

    def _drive(self) -> None:
        """Set PyBullet's motor according to lock and friction."""
        if self._locked_at is not None:
            self._change(
                bullet.setJointMotorControl2,
                controlMode=bullet.POSITION_CONTROL,
                targetPosition=self._locked_at,
                positionGain=_LOCK_GAIN,
                velocityGain=1.0,
                force=_LOCK_FORCE,
            )
        else:
            friction = self.spec.friction
            self._change(bullet.setJointMotorControl2, controlMode=bullet.VELOCITY_CONTROL, targetVelocity=0.0, force=friction)

    # Spring ----------------------------------------------------------------------------------------------------------

    @property
    def has_spring(self) -> bool:
        """Whether a spring pulls the joint."""
        return self.spec.spring is not None

    def pull(self, timestep: float) -> None:
        """Apply the spring's force for one physics step of length `timestep` [s].

        The force is k (rest - x) - d v. If k dt^2 + d dt exceeds the moving inertia, the explicit force would be unstable; it is
        then scaled down to the force of an implicit step.
        """
        spring = self.spec.spring
        if spring is None or self._locked_at is not None:
            return
        position, velocity = self.state()
        force = spring.stiffness * (spring.rest - position) - spring.damping * velocity
        demand = (spring.stiffness * timestep + spring.damping) * timestep
        force *= min(1.0, self._inertia / demand) if demand > 0.0 else 1.0
        limit = spring.max_force if spring.max_force is not None else float("inf")
        force = max(-limit, min(limit, force))
        bullet.setJointMotorControl2(
            self._model.uid, self._info.index, bullet.TORQUE_CONTROL, force=force, physicsClientId=self._model.client.id
        )


def _link_inertia(model: LoadedModel, info: JointInfo) -> float:
    """Return the inertia that the joint moves [kg] or [kg m^2], of its own link only."""
    dynamics = bullet.getDynamicsInfo(model.uid, info.index, physicsClientId=model.client.id)
    return float(dynamics[0]) if info.prismatic else float(max(dynamics[2]))


OnMove = Callable[[str, FloatArray, FloatArray], None]
"""Called with the name of a body and its old and new pose (7,)."""
Color = tuple[float, float, float, float]
_STATIC = (2, -3)  # PyBullet's own collision group and mask of objects that never move
_DYNAMIC = (1, -1)


class Body:
    """One object; its pose is that of the base link frame of its URDF.

    Args:
        name: Name in the scene file.
        model: The loaded model.
        fixed: Fixed to the world when it is loaded; see `DynamicsOverrides.set_fixed`.
        collides: Collides with other objects.
        on_move: Called with the old and the new pose after `set_pose`, to move the descendants along.
    """

    def __init__(self, name: str, model: LoadedModel, *, fixed: bool, collides: bool, on_move: OnMove) -> None:
        self.name, self.model, self.fixed, self.loaded_fixed = name, model, fixed, fixed
        self.graspable = False
        """Whether closing the gripper may attach this body; set by tasks."""
        self.grasp_links: tuple[str, ...] = ()
        """Links by which the gripper may hold it; empty: by all."""
        self.obstacle = True
        """Whether plans avoid this body; physics does not care."""
        self.joints: dict[str, ObjectJoint] = {n: ObjectJoint(f"{name}/{n}", model, info) for n, info in model.joints.items()}
        self._on_move = on_move
        self._collides = True
        self._visuals, self._finishes = visual_colors(model), visual_finishes(model)
        self._colors: dict[int, Color] = {}
        self._rigid_bounds: FloatArray | None = None
        if not collides:
            self.set_collides(False)

    # Place -----------------------------------------------------------------------------------------------------------

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) of the base link frame in the world."""
        return self.model.base_pose()

    @property
    def position(self) -> FloatArray:
        """Origin (3,) of the base link frame [m]."""
        return self.pose[:3]

    @property
    def quaternion(self) -> FloatArray:
        """Orientation (4,) of the base link frame, [qx, qy, qz, qw]."""
        return self.pose[3:]

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,) of the base's centre of mass, linear [m/s] then angular [rad/s], in world axes."""
        linear, angular = bullet.getBaseVelocity(self.model.uid, physicsClientId=self.model.client.id)
        return np.array(linear + angular)

    def set_pose(self, pose: PoseLike, zero_velocity: bool = True) -> None:
        """Set the pose (7,) of the body; its descendants in the scene file move along.

        Args:
            pose: Pose of the base link frame in the world.
            zero_velocity: Also set its velocity to zero.
        """
        new = pose_vector(pose, f"pose of '{self.name}'")
        zero_velocity = as_flag(zero_velocity, "zero_velocity")
        old, velocity = self.pose, self.velocity
        self.place(new)
        if not zero_velocity:
            self.set_velocity(velocity)
        self._on_move(self.name, old, new)

    def place(self, pose: PoseLike) -> None:
        """Set the pose (7,) of this body only, with zero velocity."""
        self.model.set_base_pose(pose)
        if not self.fixed:
            self.set_velocity(np.zeros(6))

    def set_velocity(self, velocity: Sequence[float] | FloatArray) -> None:
        """Set linear [m/s] and angular [rad/s] velocity (6,) of the base's centre of mass."""
        v = finite_vector(velocity, 6, f"velocity of '{self.name}'").tolist()
        self.model.client.change(bullet.resetBaseVelocity, self.model.uid, v[:3], v[3:])

    def link_pose(self, link: str) -> FloatArray:
        """Pose (7,) of the URDF frame of `link` in the world."""
        return self.model.link_pose(link)

    @property
    def links(self) -> tuple[str, ...]:
        """Names of all links, base first."""
        return tuple(self.model.links)

    # Shape -----------------------------------------------------------------------------------------------------------

    def bounds(self) -> FloatArray:
        """Corners [[min], [max]] (2, 3) of the bounding box in the frame of the body, at the present joint positions [m]."""
        if not self.joints:
            if self._rigid_bounds is None:
                alone = len(self.model.links) == 1
                model = self.model
                self._rigid_bounds = geometry.rigid_bounds(model.urdf, model.scale) if alone else self.bounds_from(self.pose)
            return self._rigid_bounds.copy()
        return self.bounds_from(self.pose)

    def bounds_from(self, frame: PoseLike) -> FloatArray:
        """Corners [[min], [max]] (2, 3) of the bounding box along the axes of a frame (7,), relative to its origin [m]."""
        boxes = []
        parts = geometry.solid_geometry(self.model.urdf, self.model.scale)
        for link in self.model.solid_links():
            T_base_link = pose_to_se3(relative(self.link_pose(link), frame))
            boxes.append(geometry.bounds((shape, T_base_link * local) for shape, local in parts[link]))
        if not boxes:
            return np.zeros((2, 3))
        return np.stack([np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)])

    def extent_along(self, directions: FloatArray) -> FloatArray:
        """Return the extent of the body along unit vectors (n, 3) of the world, [[min], [max]] (2, n), from its origin [m]."""
        directions = as_rows(directions, 3, "directions")
        parts = geometry.solid_geometry(self.model.urdf, self.model.scale)
        placed = ((parts[link], self.model.placement(self.model.links[link])) for link in self.model.solid_links())
        reaches = [geometry.extent_along(shapes, placement, directions) for shapes, placement in placed]
        if not reaches:
            return np.zeros((2, len(directions)))
        return np.stack([np.min([r[0] for r in reaches], axis=0), np.max([r[1] for r in reaches], axis=0)])

    def aabb_size(self) -> FloatArray:
        """Size (3,) of the bounding box in the frame of the body [m]."""
        low, high = self.bounds()
        return high - low

    # Appearance and contact ------------------------------------------------------------------------------------------

    @property
    def color(self) -> Color:
        """Colour rgba in 0..1: the last one set on the base, or the colour of its first visual."""
        for index in (BASE, *sorted(self._visuals)):
            if index in self._colors:
                return self._colors[index]
            if index in self._visuals:
                return self._visuals[index][0]
        return (1.0, 1.0, 1.0, 1.0)

    def set_color(self, color: Sequence[float], link: str | None = None) -> None:
        """Set the colour of all visuals of one link, or of all links.

        Args:
            color: rgb or rgba in 0..1.
            link: Name of the link; None means all links.

        Raises:
            InvalidNumbers: The colour is invalid (also a ValueError).
            UnknownName: The body has no such link.
        """
        red, green, blue, alpha = color_values(color)
        indices = list(self._visuals) if link is None else [self.model.link_index(link)]
        for index in indices:
            self._paint(index, (red, green, blue, alpha))

    def _paint(self, index: int, color: Color) -> None:
        if self._colors.get(index) == color or index not in self._visuals:
            return
        self._colors[index] = color
        self.model.client.change(bullet.changeVisualShape, self.model.uid, index, rgbaColor=color)

    def _unpaint(self, index: int) -> None:
        """Restore the URDF colours of the visuals of a link."""
        del self._colors[index]
        for shape, color in enumerate(self._visuals[index]):
            self.model.client.change(bullet.changeVisualShape, self.model.uid, index, shapeIndex=shape, rgbaColor=color)

    def repaint(self) -> None:
        """Restore the colours of the body."""
        for index in self._visuals:
            if index in self._colors:
                color = self._colors.pop(index)
                self._paint(index, color)
            else:
                self._colors[index] = (0.0, 0.0, 0.0, 0.0)
                self._unpaint(index)

    @property
    def visual_links(self) -> tuple[int, ...]:
        """Numbers of the links that have visuals."""
        return tuple(sorted(self._visuals))

    @property
    def colors(self) -> dict[int, Color]:
        """Colours that differ from the URDF, by link number."""
        return dict(self._colors)

    @property
    def mixed_colors(self) -> dict[int, tuple[Color, ...]]:
        """Colours of links whose visuals have several colours, by link number; PyBullet reports only one of them."""
        return {link: own for link, own in self._visuals.items() if link not in self._colors and len(set(own)) > 1}

    @property
    def finishes(self) -> dict[int, tuple[Finish, ...]]:
        """Finishes of the visuals of links that have some, by link number."""
        return self._finishes

    def set_colors(self, colors: dict[int, Color]) -> None:
        """Set `colors` and restore the URDF colours of all other links."""
        as_record(colors, dict, "colors")
        for index in [i for i in self._colors if i not in colors]:
            self._unpaint(index)
        for index, color in colors.items():
            self._paint(index, color)

    @property
    def collides(self) -> bool:
        """Whether the body collides with other objects."""
        return self._collides

    def set_collides(self, collides: bool) -> None:
        """Switch collisions with other objects on or off."""
        if (collides := as_flag(collides, "collides")) == self._collides:
            return
        self._collides = collides
        self._set_filters()

    def hold(self, fixed: bool) -> None:
        """Record whether the body is fixed, and set its velocity to zero. `DynamicsOverrides` changes its mass."""
        self.set_velocity(np.zeros(6))
        self.fixed = fixed
        self._set_filters()

    def _set_filters(self) -> None:
        """Set PyBullet's collision filters of the body."""
        for index in self.model.links.values():
            group, mask = (_STATIC if self.fixed and index == BASE else _DYNAMIC) if self._collides else (0, 0)
            self.model.client.change(bullet.setCollisionFilterGroupMask, self.model.uid, index, group, mask)

    def joint(self, name: str) -> ObjectJoint:
        """Return the joint called `name`."""
        if not isinstance(name, str) or name not in self.joints:
            raise UnknownName(f"joint of '{self.name}'", name, tuple(self.joints))
        return self.joints[name]

    def __repr__(self) -> str:
        return f"Body('{self.name}')"


def carried(pose: PoseLike, old: PoseLike, new: PoseLike) -> FloatArray:
    """Return the new pose of an object at `pose` whose parent moves from `old` to `new`."""
    return compose(new, relative(pose, old))


def visual_colors(model: LoadedModel) -> dict[int, tuple[Color, ...]]:
    """Colours of the URDF's visuals, by link number, in file order."""
    colors: dict[int, tuple[Color, ...]] = {}
    for entry in bullet.getVisualShapeData(model.uid, physicsClientId=model.client.id):
        colors[entry[1]] = (*colors.get(entry[1], ()), tuple(round(c, 6) for c in entry[7]))
    return colors


def visual_finishes(model: LoadedModel) -> dict[int, tuple[Finish, ...]]:
    """Finishes of the URDF's visuals, of links with at least one, by link number, in file order."""
    links = ((link.name, tuple(shape.finish for shape in link.visuals if shape.kind)) for link in read_urdf(model.urdf).links)
    return {model.link_index(name): finishes for name, finishes in links if any(finish != DULL for finish in finishes)}


TOUCH_DISTANCE = 5e-4
"""Surfaces closer than this touch [m]; the solver keeps resting objects apart by about as much."""


@dataclass(frozen=True, eq=False)
class Contact:
    """One contact point of the last physics step."""

    body: str
    link: str
    other: str
    other_link: str
    position: FloatArray
    """Point on `other` in the world (3,) [m]."""
    normal: FloatArray
    """Unit vector (3,) from `other` towards `body`."""
    distance: float
    """Gap between the surfaces [m]; negative when they overlap."""
    force: float
    """Normal force [N]."""


class ContactReader:
    """Reader of contact points with names in place of PyBullet's numbers.

    Args:
        client: The physics server.
    """

    def __init__(self, client: PhysicsClient) -> None:
        self._client = client
        self._names: dict[int, tuple[str, LoadedModel, dict[int, str]]] = {}

    def add(self, name: str, model: LoadedModel) -> None:
        """Register a body."""
        self._names[model.uid] = (name, model, {index: link for link, index in model.links.items()})

    def remove(self, uid: int) -> None:
        """Remove a body from the register."""
        del self._names[uid]

    def read(self, body: int | None = None, other: int | None = None) -> tuple[Contact, ...]:
        """Return the contact points of the last physics step, of one body, or between two."""
        return tuple(self._contact(p) for p in self._points(body, other))

    def touching(self, body: int) -> tuple[str, ...]:
        """Names of the bodies that touch `body`, sorted."""
        near = {p[2] for p in self._points(body, None) if p[8] < TOUCH_DISTANCE}
        return tuple(sorted(self._names[uid][0] for uid in near if uid != body))

    def forces(self, body: int) -> dict[tuple[str, str], float]:
        """Return (link of `body`, other body) -> sum of the normal forces of the last physics step [N]."""
        forces: dict[tuple[str, str], float] = {}
        links = self._names[body][2]
        for point in self._points(body, None):
            if point[2] != body and point[8] < TOUCH_DISTANCE:
                pair = links[point[3]], self._names[point[2]][0]
                forces[pair] = forces.get(pair, 0.0) + point[9]
        return forces

    def deepest(self) -> float:
        """Largest penetration depth of any contact [m]; 0 without contact."""
        return max(0.0, *(-p[8] for p in self._points(None, None)), 0.0)

    def _points(self, body: int | None, other: int | None) -> tuple:
        which = {key: uid for key, uid in (("bodyA", body), ("bodyB", other)) if uid is not None}
        return bullet.getContactPoints(physicsClientId=self._client.id, **which) or ()

    def _contact(self, point: tuple) -> Contact:
        name, _, links = self._names[point[1]]
        other, _, other_links = self._names[point[2]]
        return Contact(
            name, links[point[3]], other, other_links[point[4]], np.array(point[6]), np.array(point[7]), point[8], point[9]
        )


def touched_links(model: LoadedModel, link: int, other: LoadedModel) -> set[int]:
    """Return the indices of the links of `other` that a link of `model` touched in the last physics step."""
    where = {"bodyA": model.uid, "bodyB": other.uid, "linkIndexA": link, "physicsClientId": model.client.id}
    return {point[4] for point in bullet.getContactPoints(**where) or () if point[8] < TOUCH_DISTANCE}
