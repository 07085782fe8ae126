"""Objects of a scene, as views on the simulated world.

This module defines dummies and sensors. The classes of window cameras, lights and octrees raise errors, since scenes have none.
Programs import one module per class; the names of these modules are aliases of this module.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pyrep.const import ObjectType
from pyrep.errors import UnsupportedCall
from pyrep.objects.cartesian_path import CartesianPath
from pyrep.objects.joint import Joint
from pyrep.objects.object import Object, point_part
from pyrep.objects.shape import Shape, body_of
from pyrep.objects.vision_sensor import VisionSensor
from rlbench_pin.compat import add_aliases
from rlbench_pin.compat.objects import Element, Placed
from rlbench_pin.compat.objects import ObjectType as TypeName
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.robot import geometry
from rlbench_pin.sim import Sensor
from rlbench_pin.spatial import IDENTITY, FloatArray, pose_to_se3

__all__ = [
    "Camera",
    "CartesianPath",
    "Dummy",
    "ForceSensor",
    "Joint",
    "Light",
    "Object",
    "Octree",
    "ProximitySensor",
    "Shape",
    "VisionSensor",
]


class Dummy(Object):
    """A frame or waypoint of the scene, the root of the task, the tip of the arm, or a dummy that a program created."""

    kinds: ClassVar[tuple[TypeName, ...]] = ("dummy",)

    @classmethod
    def create(cls, size: float = 0.01) -> Dummy:
        """Create a dummy at the origin of the world.

        It exists until `remove()`. For descendants of a task, a reset restores the pose at the setup of the task, and removes
        dummies that were created later; unloading the task also removes them.

        Args:
            size: No effect: dummies are not drawn.
        """
        table = Simulator.current().objects
        name = table.free_name("Dummy")
        table.placed[name] = Placed("dummy", IDENTITY.copy(), extra={"size": size})
        return cls(Element("placed", name))

    def copy(self) -> Dummy:
        """Create a dummy at the same pose with the same parent."""
        made = Dummy.create()
        made.set_pose(self.get_pose())
        made.set_parent(self.get_parent())
        return made


class ForceSensor(Object):
    """Measures the contact forces on a body or link of the scene.

    Scene files have no force sensors: name the body, or `<body>/<link>`, that is pressed.
    """

    kinds: ClassVar[tuple[TypeName, ...]] = ("force_sensor", "shape")

    def get_type(self) -> ObjectType:
        """Return FORCE_SENSOR."""
        return ObjectType.FORCE_SENSOR

    def read(self) -> tuple[np.ndarray, np.ndarray]:
        """Return force (3,) [N] and torque (3,) [N m] of the normal contact forces, in the frame of the sensor at its origin."""
        body, link = body_of(self.table, self.element, "ForceSensor.read"), self.element.name.partition("/")[2]
        place = pose_to_se3(self.get_pose())
        force, torque = np.zeros(3), np.zeros(3)
        contacts = [c for c in self.table.world.contacts(body.name) if link in ("", c.link)]
        if contacts:
            forces = [c.force * np.asarray(c.normal) for c in contacts]
            force = np.sum(forces, axis=0)
            torque = np.sum([np.cross(c.position - place.translation, f) for c, f in zip(contacts, forces)], axis=0)
        return place.rotation.T @ force, place.rotation.T @ torque


@dataclass(frozen=True, eq=False)
class BoxVolume:
    """Volume of a sensor that is not part of the scene file."""

    size: tuple[float, ...]
    """Side lengths along x, y, z [m]."""
    pose: FloatArray
    """Pose (7,) of its centre in the world."""
    shape: geometry.VolumeShape = "box"
    """Kind of volume."""

    def contains(self, point: FloatArray) -> bool:
        """Return whether a world point (3,) [m] is inside."""
        return geometry.volume_contains(self.shape, self.size, pose_to_se3(self.pose), point)


class ProximitySensor(Object):
    """A box, cylinder or sphere of the scene file that detects objects inside; it is evaluated at each call."""

    kinds: ClassVar[tuple[TypeName, ...]] = ("proximity_sensor",)

    def read(self) -> float:
        """Return the distance [m] from the origin of the sensor to the nearest detectable body in its volume; -1 without one."""
        table, place, least = self.table, pose_to_se3(self._volume().pose), np.inf
        kinds = ("body",) if self.element.kind == "placed" else ("body", "robot")  # the gripper's sensor ignores the arm
        for element in table.elements():
            if element.kind in kinds and table.flags.get((element, "detectable"), True) and self._contains(element):
                for parts, pose in table.scene_object(element).solids():
                    least = min(least, geometry.gap((point_part(),), place, parts, pose_to_se3(pose)))
        return -1.0 if least == np.inf else float(least)

    def is_detected(self, obj: Object) -> bool:
        """Return whether an object is in the volume: any collision shape of a shape, or the origin of another object.

        Args:
            obj: The object; it is detected only if it is detectable.
        """
        return obj.is_detectable() and self._contains(obj.element)

    def _volume(self) -> Sensor | BoxVolume:
        """Return the volume of the sensor at its current pose."""
        if self.element.kind == "placed":
            return BoxVolume(self.table.placed[self.element.name].size, self.get_pose())
        return self.table.world.sensor(self.element.name)

    def _contains(self, element: Element) -> bool:
        """Return whether a collision shape of an object, or the origin of an object without shapes, is in the volume."""
        volume, found = self._volume(), self.table.scene_object(element)
        solids = found.solids()
        if not solids:
            return volume.contains(found.pose[:3])
        shape, placed = geometry.volume(volume.shape, volume.size), pose_to_se3(volume.pose)
        return any(geometry.overlaps(shape, placed, parts, pose_to_se3(pose)) for parts, pose in solids)


class Camera(Object):
    """Not available: there is no window. The constructor raises UnsupportedCall."""

    def __init__(self, name_or_handle: str | int) -> None:
        raise UnsupportedCall(
            f"Camera({name_or_handle!r})", "there is no window with a camera.", "Take images with a `VisionSensor`."
        )


class Light(Object):
    """Not available: lights are settings of images, not objects. The constructor raises UnsupportedCall."""

    def __init__(self, name_or_handle: str | int) -> None:
        raise UnsupportedCall(
            f"Light({name_or_handle!r})",
            "lights are settings, not objects.",
            "Set `ObservationConfig.lighting`, an `rlbench_pin.sim.Lighting`.",
        )


class Octree(Object):
    """Not available: scenes have no voxels. The constructor raises UnsupportedCall."""

    def __init__(self, name_or_handle: str | int) -> None:
        raise UnsupportedCall(
            f"Octree({name_or_handle!r})",
            "there are no voxels in the scene.",
            "Compute them from `VisionSensor.capture_pointcloud`.",
        )


add_aliases(__name__, ("camera", "dummy", "force_sensor", "light", "octree", "proximity_sensor"))
