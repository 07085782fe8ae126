"""Objects of a world with one interface: pose, type and collision shapes. Some of them are not part of the physics."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from rlbench_pin.compat.objects.elements import (
    GRIP_SENSOR,
    Element,
    ObjectType,
    UnsupportedCall,
    camera_of,
    robot_names,
)
from rlbench_pin.environment import CameraConfig, ObservationConfig
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.robot import geometry
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.scene.snapshot import Shape
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import Body, CameraView, Frame, ObjectJoint, Region, Sensor, SimRobot, look_at
from rlbench_pin.spatial import IDENTITY, TABLE_HEIGHT, FloatArray, compose, relative
from rlbench_pin.urdf import read_urdf

if TYPE_CHECKING:
    from rlbench_pin.compat.objects.table import ObjectTable

Solid = tuple[tuple[geometry.Part, ...], FloatArray]
"""Collision shapes in the frame of their link, and the pose (7,) of that frame in the world."""


class SceneObject(ABC):
    """An object with a pose in the world."""

    type: ObjectType = "dummy"

    @property
    @abstractmethod
    def pose(self) -> FloatArray:
        """Pose (7,) in the world."""

    @abstractmethod
    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move the object to a pose in the world.

        Args:
            pose: New pose (7,).
            zero_velocity: Set the velocity to 0.
        """

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,): linear [m/s], angular [rad/s], in world axes."""
        return np.zeros(6)

    def solids(self) -> list[Solid]:
        """Return the shapes that other objects can touch or detect."""
        return []

    def box(self) -> FloatArray:
        """Return the bounding box [[min], [max]] (2, 3) [m] in the frame of the object, without its descendants."""
        return np.zeros((2, 3))


class BodyObject(SceneObject):
    """A body of the scene or the room; its box is that of its base link."""

    type: ObjectType = "shape"

    def __init__(self, body: Body) -> None:
        self.body = body

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) of the base link."""
        return self.body.pose

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move the body and its descendants."""
        self.body.set_pose(pose, zero_velocity=zero_velocity)

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,) of the base."""
        return self.body.velocity

    def solids(self) -> list[Solid]:
        """Return the shapes of all links."""
        parts = geometry.solid_geometry(self.body.model.urdf, self.body.model.scale)
        return [(parts[link], self.body.link_pose(link)) for link in self.body.model.solid_links()]

    def box(self) -> FloatArray:
        return link_box(self.body, self.body.links[0])


class LinkObject(SceneObject):
    """A link of a body that a joint moves."""

    type: ObjectType = "shape"

    def __init__(self, body: Body, link: str) -> None:
        self.body, self.link = body, link

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) of the link's frame."""
        return self.body.link_pose(self.link)

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        raise UnsupportedCall(
            f"set_pose of '{self.body.name}/{self.link}'", "a joint determines its pose.", "Move the joint, or the whole body."
        )

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,) of the centre of mass of the link."""
        return self.body.model.link_velocity(self.link)

    def solids(self) -> list[Solid]:
        """Return the shapes of this link."""
        parts = geometry.solid_geometry(self.body.model.urdf, self.body.model.scale)
        return [(parts[self.link], self.pose)] if self.link in parts else []

    def box(self) -> FloatArray:
        return link_box(self.body, self.link)


class JointObject(SceneObject):
    """A joint of a body; its pose is that of the frame of its child link."""

    type: ObjectType = "joint"

    def __init__(self, body: Body, joint: ObjectJoint) -> None:
        self.body, self.joint = body, joint
        self.child = child_link(body, joint.name.partition("/")[2])

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) of the child link's frame."""
        return self.body.link_pose(self.child)

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        raise UnsupportedCall(
            f"set_pose of joint '{self.joint.name}'", "its pose is part of the model.", "Use `set_joint_position`."
        )


class FrameObject(SceneObject):
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
        return self.frame.pose

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move the frame and its descendants."""
        self.frame.set_pose(pose)

    def solids(self) -> list[Solid]:
        """Return the box of a region; other frames have no shapes."""
        return [((box_part(self.frame.size),), self.pose)] if isinstance(self.frame, Region) else []

    def box(self) -> FloatArray:
        """Return the box of a region, or of the volume of a sensor."""
        if isinstance(self.frame, Region):
            half = 0.5 * self.frame.size
        elif isinstance(self.frame, Sensor):
            size = self.frame.size
            full = {"box": size[:3], "cylinder": (size[0], size[0], size[-1]), "sphere": (size[0],) * 3}
            half = 0.5 * np.array(full[self.frame.shape])
        else:
            half = np.zeros(3)
        return np.stack([-half, half])


class RobotObject(SceneObject):
    """A link of the arm, or its tip."""

    def __init__(self, robot: SimRobot, type_: ObjectType, link: str | None, call: str) -> None:
        self.robot, self.type, self._link, self._call = robot, type_, link, call

    @property
    def pose(self) -> FloatArray:
        return self.robot.tip_pose() if self._link is None else self.robot.link_pose(self._link)

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        raise UnsupportedCall(
            f"set_pose of '{self._call}'", "it follows the joints.", "Use `arm.set_joint_positions(q, disable_dynamics=True)`."
        )

    @property
    def velocity(self) -> FloatArray:
        """Velocity (6,) of the centre of mass of the link, or of the tip."""
        return self.robot.model.link_velocity(self._link or self.robot.description.tip_frame)

    def solids(self) -> list[Solid]:
        parts = geometry.solid_geometry(self.robot.model.urdf, 1.0)
        if self.type != "shape" or self._link not in parts:
            return []
        return [(parts[self._link or ""], self.pose)]

    def box(self) -> FloatArray:
        return geometry.bounds(geometry.solid_geometry(self.robot.model.urdf, 1.0).get(self._link or "", ()))


class WholeRobotObject(RobotObject):
    """The whole arm, at its base."""

    def __init__(self, robot: SimRobot, call: str) -> None:
        super().__init__(robot, "shape", next(iter(robot.model.links)), call)

    def solids(self) -> list[Solid]:
        """Return the shapes of all links."""
        parts = geometry.solid_geometry(self.robot.model.urdf, 1.0)
        return [(parts[link], self.robot.link_pose(link)) for link in self.robot.model.links if link in parts]


def box_part(size: FloatArray) -> geometry.Part:
    """Return a box of side lengths (3,) [m] at the origin; each side is at least 0.1 mm long."""
    thick = tuple(max(float(s), 1e-4) for s in size)
    return geometry.primitive(Shape("box", thick, tuple(IDENTITY.tolist())))


def link_box(body: Body, link: str) -> FloatArray:
    """Return the bounding box (2, 3) [m] of one link in the frame of the link."""
    return geometry.bounds(geometry.solid_geometry(body.model.urdf, body.model.scale).get(link, ()))


def child_link(body: Body, joint: str) -> str:
    """Return the link that a joint of a body moves."""
    return next(j.child for j in read_urdf(body.model.urdf).joints if j.name == joint)


def joint_of_link(body: Body, link: str) -> tuple[str, str]:
    """Return the parent joint of a link ("" for a fixed joint), and the parent link of this joint."""
    joint = next(j for j in read_urdf(body.model.urdf).joints if j.child == link)
    return (joint.name if joint.name in body.joints else ""), joint.parent


PlacedKind = Literal["dummy", "vision_sensor", "path", "shape", "proximity_sensor"]


@dataclass(frozen=True)
class CameraSettings:
    """Settings of a camera."""

    size: tuple[int, int] = (128, 128)
    """Width and height [px]."""
    angle: float = 60.0
    """Field of view of the longer side [deg]."""
    near: float = 0.01
    """Near plane [m]."""
    far: float = 10.0
    """Far plane [m]."""
    render_mode: str = "OPENGL3"
    """Name of a render mode."""
    explicit_handling: bool = False
    """Whether `handle_explicitly` may be called."""


@dataclass(frozen=True, eq=False)
class Placed:
    """An object that is not part of the physics, and its pose."""

    kind: PlacedKind
    local: FloatArray
    """Pose (7,) in the frame of the parent."""
    parent: Element | None = None
    """Parent; None is the world."""
    camera: CameraSettings | None = None
    """Settings of a vision sensor."""
    points: tuple[FloatArray, ...] = ()
    """Control points (7,) of a path, in the frame of the path."""
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Side lengths of a plane or sensor [m]."""
    extra: dict[str, object] = field(default_factory=dict)
    """Other settings that a program can read back."""


_TASK_KINDS = ("root", "body", "link", "joint", "frame")
_MIDDLE = np.array([0.25, 0.0, TABLE_HEIGHT, 0.0, 0.0, 0.0, 1.0])
_BASE = np.array([0.25, 0.0, TABLE_HEIGHT + 0.25, 0.0, 0.0, 0.0, 1.0])
_PLACEHOLDER = look_at((1.35, -0.95, TABLE_HEIGHT + 0.85), (0.2, 0.0, TABLE_HEIGHT + 0.2))
WORKSPACE_SIZE = (0.648, 0.91, 0.0)
"""Size of the plane of the workspace [m]; the tip may be up to 0.2 m outside at each side, and up to 1 m above."""


def hangs_in_task(placed: dict[str, Placed], name: str) -> bool:
    """Return whether a placed object is a descendant of an object of the task."""
    parent = placed[name].parent
    while parent is not None and parent.kind == "placed":
        parent = placed[parent.name].parent if parent.name in placed else None
    return parent is not None and parent.kind in _TASK_KINDS


def fixed_objects(robot: RobotDescription) -> dict[str, Placed]:
    """Return the objects of every scene: the workspace, pose and pivot of the video camera, and the sensor of the gripper.

    Args:
        robot: The robot; the sensor covers half of the space between the open fingertips.
    """
    base, names = Element("placed", "cam_cinematic_base"), robot_names(robot)
    width, height = robot.pad_size
    return {
        "workspace": Placed("shape", _MIDDLE, size=WORKSPACE_SIZE),
        "cam_cinematic_base": Placed("dummy", _BASE),
        "cam_cinematic_placeholder": Placed("dummy", relative(_PLACEHOLDER, _BASE), parent=base),
        names.gripper + GRIP_SENSOR: Placed(
            "proximity_sensor", IDENTITY.copy(), Element("tip", f"{names.arm}_tip"), size=(width, robot.gripper_open, height)
        ),
    }


class PlacedObject(SceneObject):
    """A dummy, camera, path or plane that a program or the fixed scene placed."""

    def __init__(self, table: ObjectTable, name: str) -> None:
        self._table, self._name = table, name
        self.type = table.placed[name].kind

    @property
    def placed(self) -> Placed:
        """The stored data of the object."""
        return self._table.placed[self._name]

    @property
    def pose(self) -> FloatArray:
        placed = self.placed
        return (
            placed.local.copy() if placed.parent is None else compose(self._table.scene_object(placed.parent).pose, placed.local)
        )

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move the object and its descendants."""
        old, placed = self.pose, self.placed
        local = pose if placed.parent is None else relative(pose, self._table.scene_object(placed.parent).pose)
        self._table.placed[self._name] = replace(placed, local=np.array(local))
        if not np.array_equal(old, pose):
            self._table.carry(Element("placed", self._name), old, pose)

    def solids(self) -> list[Solid]:
        """Return the plane of a shape; other objects have no shapes."""
        return [((box_part(np.array(self.placed.size)),), self.pose)] if self.type == "shape" else []

    def box(self) -> FloatArray:
        half = 0.5 * np.array(self.placed.size)
        return np.stack([-half, half])


COLOR_CODED = "OPENGL_COLOR_CODED"
"""Render mode of cameras whose images encode handles as colours."""


class Cameras:
    """The five cameras of one world.

    Args:
        runtime: The world.
        config: Contents of observations, with the sizes and shadows of the images.
    """

    def __init__(self, runtime: Runtime, config: ObservationConfig) -> None:
        self._runtime, self.config = runtime, config

    def settings_of(self, name: str) -> CameraConfig:
        """Return the settings of a camera; `name` is our name."""
        config: CameraConfig = getattr(self.config, f"{name}_camera")
        return config

    def view(self, name: str) -> CameraView:
        """Return the current view of a camera."""
        return self._runtime.observer.appearance.moved(name, self._runtime.cameras[name].view())

    def place(self, name: str, pose: FloatArray) -> None:
        """Move a camera to a pose (7,) in the world, also for observations; the wrist camera stays fixed to the gripper."""
        self._runtime.cameras[name].set_pose(pose)


class CameraObject(SceneObject):
    """One of the five cameras, or the mask camera at the same pose."""

    type: ObjectType = "vision_sensor"

    def __init__(self, cameras: Cameras, known_name: str) -> None:
        self._cameras = cameras
        self.name, self.is_mask = camera_of(known_name)

    @property
    def pose(self) -> FloatArray:
        return self._cameras.view(self.name).pose.copy()

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move the camera and its mask camera."""
        self._cameras.place(self.name, pose)

    @property
    def camera(self) -> CameraSettings:
        """Settings of the camera."""
        view, config = self._cameras.view(self.name), self._cameras.settings_of(self.name)
        mode = COLOR_CODED if self.is_mask else str(config.render_mode).rpartition(".")[2].upper()
        return CameraSettings(view.size, float(view.fov * 180.0 / 3.141592653589793), view.near, view.far, mode, True)

    def set_camera(self, camera: CameraSettings) -> None:
        """Change the size of the images, or whether they have shadows.

        Raises:
            UnsupportedCall: Another setting differs.
        """
        before = self.camera
        if replace(before, size=camera.size, render_mode=camera.render_mode) != camera:
            raise UnsupportedCall(
                f"changing angle or planes of camera '{self.name}'",
                "they are the same for all observations.",
                "Create another camera with `VisionSensor.create`.",
            )
        config = self._cameras.settings_of(self.name)
        config.image_size = camera.size
        if not self.is_mask:
            config.render_mode = "opengl3" if camera.render_mode.startswith("OPENGL3") else "opengl"
