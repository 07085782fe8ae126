"""Things of the world behind one small interface: place, type, solid parts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np

from rlbench_pin.compat.things.element import ObjectType, UnsupportedCall
from rlbench_pin.robot import geometry
from rlbench_pin.scene.snapshot import Shape
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import Body, Frame, ObjectJoint, Region, Sensor, SimRobot, World
from rlbench_pin.spatial import IDENTITY, FloatArray
from rlbench_pin.urdf import read_urdf

Solid = tuple[tuple[geometry.Part, ...], FloatArray]
"""Shapes in the frame of their link, and the pose (7,) of that frame in the world."""


class Thing(ABC):
    """Something with a place in the world."""

    type: ObjectType = "dummy"

    @property
    @abstractmethod
    def pose(self) -> FloatArray:
        """Pose (7,) in the world."""

    @abstractmethod
    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move to a pose (7,) in the world.

        Args:
            pose: Where to.
            zero_velocity: Bring it to rest as well.
        """

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,): linear [m/s], angular [rad/s], in world axes."""
        return np.zeros(6)

    def solids(self) -> list[Solid]:
        """What others can touch or detect."""
        return []

    def box(self) -> FloatArray:
        """Corners [[min], [max]] (2, 3) of the box around it alone, in its own frame [m]."""
        return np.zeros((2, 3))


class BodyThing(Thing):
    """A body of the scene or the room; its box is that of its base link."""

    type: ObjectType = "shape"

    def __init__(self, body: Body) -> None:
        self.body = body

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) of the base link."""
        return self.body.pose

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move the body and what hangs on it."""
        self.body.set_pose(pose, zero_velocity=zero_velocity)

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,) of the base."""
        return self.body.velocity

    def solids(self) -> list[Solid]:
        """Parts of all its links."""
        parts = geometry.solid_geometry(self.body.model.urdf, self.body.model.scale)
        return [(parts[link], self.body.link_pose(link)) for link in self.body.model.solid_links()]

    def box(self) -> FloatArray:
        """Box around the base link."""
        return link_box(self.body, self.body.links[0])


class LinkThing(Thing):
    """A link of a body that a joint moves."""

    type: ObjectType = "shape"

    def __init__(self, body: Body, link: str) -> None:
        self.body, self.link = body, link

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) of the link's frame."""
        return self.body.link_pose(self.link)

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Refused."""
        raise UnsupportedCall(
            f"set_pose of '{self.body.name}/{self.link}'", "a joint holds it.", "Move the joint, or the whole body."
        )

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,) of its centre of mass."""
        return self.body.model.link_velocity(self.link)

    def solids(self) -> list[Solid]:
        """Parts of this link alone."""
        parts = geometry.solid_geometry(self.body.model.urdf, self.body.model.scale)
        return [(parts[self.link], self.pose)] if self.link in parts else []

    def box(self) -> FloatArray:
        """Box around the link."""
        return link_box(self.body, self.link)


class JointThing(Thing):
    """A joint of a body; it stands where the link that it moves has its frame."""

    type: ObjectType = "joint"

    def __init__(self, body: Body, joint: ObjectJoint) -> None:
        self.body, self.joint = body, joint
        self.child = child_link(body, joint.name.partition("/")[2])

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) of the child link's frame."""
        return self.body.link_pose(self.child)

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Refused."""
        raise UnsupportedCall(
            f"set_pose of joint '{self.joint.name}'", "its place is part of the model.", "Use `set_joint_position`."
        )


class FrameThing(Thing):
    """A frame, region, sensor or waypoint of the scene file, or the root."""

    def __init__(self, frame: Frame, spec: SceneSpec) -> None:
        self.frame = frame
        if isinstance(frame, Region):
            self.type = "shape"
        elif isinstance(frame, Sensor):
            self.type = "proximity_sensor"
        elif any(w.name == frame.name and w.path == "curve" for w in spec.waypoint):
            self.type = "path"

    @property
    def pose(self) -> FloatArray:
        """Pose (7,)."""
        return self.frame.pose

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move the frame and what hangs on it."""
        self.frame.set_pose(pose)

    def solids(self) -> list[Solid]:
        """The box of a region; volumes of sensors are no solids."""
        return [((box_part(self.frame.size),), self.pose)] if isinstance(self.frame, Region) else []

    def box(self) -> FloatArray:
        """The box of a region, or of a sensor's volume."""
        if isinstance(self.frame, Region):
            half = 0.5 * self.frame.size
        elif isinstance(self.frame, Sensor):
            size = self.frame.size
            full = {"box": size[:3], "cylinder": (size[0], size[0], size[-1]), "sphere": (size[0],) * 3}
            half = 0.5 * np.array(full[self.frame.shape])
        else:
            half = np.zeros(3)
        return np.stack([-half, half])


class RobotThing(Thing):
    """A link of the arm, or its tip."""

    def __init__(self, robot: SimRobot, type_: ObjectType, link: str | None, call: str) -> None:
        self.robot, self.type, self._link, self._call = robot, type_, link, call

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) in the world."""
        return self.robot.tip_pose() if self._link is None else self.robot.link_pose(self._link)

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Refused."""
        raise UnsupportedCall(
            f"set_pose of '{self._call}'", "the arm's joints hold it.", "Use `arm.set_joint_positions(q, disable_dynamics=True)`."
        )

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,) of its centre of mass; the tip has none but itself."""
        return self.robot.model.link_velocity(self._link or self.robot.description.tip_frame)

    def solids(self) -> list[Solid]:
        """Parts of the link."""
        parts = geometry.solid_geometry(self.robot.model.urdf, 1.0)
        if self.type != "shape" or self._link not in parts:
            return []
        return [(parts[self._link or ""], self.pose)]

    def box(self) -> FloatArray:
        """Box around the link's shapes."""
        return geometry.bounds(geometry.solid_geometry(self.robot.model.urdf, 1.0).get(self._link or "", ()))


class WholeRobotThing(RobotThing):
    """The whole arm, at its base."""

    def __init__(self, robot: SimRobot, call: str) -> None:
        super().__init__(robot, "shape", next(iter(robot.model.links)), call)

    def solids(self) -> list[Solid]:
        """Parts of all links."""
        parts = geometry.solid_geometry(self.robot.model.urdf, 1.0)
        return [(parts[link], self.robot.link_pose(link)) for link in self.robot.model.links if link in parts]


def box_part(size: FloatArray) -> geometry.Part:
    """Return a solid box of lengths (3,) [m] at the origin; what is flat becomes 0.1 mm thick."""
    thick = tuple(max(float(s), 1e-4) for s in size)
    return geometry.primitive(Shape("box", thick, tuple(IDENTITY.tolist())))


def link_box(body: Body, link: str) -> FloatArray:
    """Return the box (2, 3) around one link in its own frame [m]."""
    return geometry.bounds(geometry.solid_geometry(body.model.urdf, body.model.scale).get(link, ()))


def child_link(body: Body, joint: str) -> str:
    """Return the link that a joint of a body moves."""
    return next(j.child for j in read_urdf(body.model.urdf).joints if j.name == joint)


def joint_of_link(body: Body, link: str) -> tuple[str, str]:
    """Return the joint that holds a link, or "" for a weld, and the link that the joint sits on."""
    joint = next(j for j in read_urdf(body.model.urdf).joints if j.child == link)
    return (joint.name if joint.name in body.joints else ""), joint.parent


def mask_ids(world: World) -> Mapping[str, int]:
    """Return mask ids by name: `<body>`, or `<body>/<link>` where there are several."""
    return {name: identifier for identifier, name in world.masks.items()}
