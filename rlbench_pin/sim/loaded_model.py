"""What PyBullet says about one loaded URDF and never changes: numbers of links and joints, limits, inertial offsets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import UnknownName
from rlbench_pin.robot.geometry import Ball, Part, link_geometry, solid_balls, solid_geometry
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3, se3_to_pose

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
        """Names of the links that sensors see: with collision geometry, or with visuals when there is none."""
        shapes = solid_geometry(self.urdf, self.scale)
        return tuple(name for name in self.links if name in shapes)

    @cached_property
    def solids(self) -> tuple[tuple[int, Ball, tuple[Part, ...]], ...]:
        """Number, surrounding ball and shapes of every link that sensors see."""
        balls = solid_balls(self.urdf, self.scale)
        return tuple((self.links[link], balls[link], parts) for link, parts in solid_geometry(self.urdf, self.scale).items())

    def placement(self, index: int = BASE) -> pin.SE3:
        """T_world_link of the URDF frame of the link with number `index`; read once, until something moves."""
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
        """Put the base link frame at a pose (7,)."""
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
        """Pose (7,) of the URDF frame of the link with number `index`, which is not the base."""
        return se3_to_pose(self.placement(index))


def _read_se3(numbers: tuple[float, ...]) -> pin.SE3:
    """Convert seven numbers of PyBullet as `pose_to_se3` does, which is asked where they are no pose."""
    pose = np.array(numbers)
    turn = pose[3:]
    norm = math.sqrt(turn @ turn)
    if not 0.0 < norm < math.inf:
        return pose_to_se3(numbers)
    turn /= norm
    return pin.XYZQUATToSE3(pose)


def inspect(client: PhysicsClient, uid: int, urdf: Path, scale: float) -> LoadedModel:
    """Read what PyBullet says about a body that was just loaded."""
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
