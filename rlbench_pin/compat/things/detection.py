"""What sensors of a scene see and feel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.compat.things.element import Element
from rlbench_pin.compat.things.physics import body_of
from rlbench_pin.compat.things.solids import point_part
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.robot import geometry
from rlbench_pin.sim import Sensor
from rlbench_pin.spatial import FloatArray, pose_to_se3

_SEEN = ("body", "robot")
"""Kinds of things that `nearest` looks for; the sensor of the hand does not look for the arm."""


@dataclass(frozen=True, eq=False)
class BoxVolume:
    """A box that is not part of the scene file, as a volume of a sensor."""

    size: tuple[float, ...]
    """Lengths along x, y, z [m]."""
    pose: FloatArray
    """Of its middle, (7,) in the world."""
    shape: geometry.VolumeShape = "box"
    """Kind of volume."""

    def contains(self, point: FloatArray) -> bool:
        """Say whether a world point (3,) [m] lies in it."""
        return geometry.volume_contains(self.shape, self.size, pose_to_se3(self.pose), point)


def sensor_of(table: ObjectTable, element: Element) -> Sensor | BoxVolume:
    """Return the volume that an element stands for."""
    if element.kind == "placed":
        return BoxVolume(table.placed[element.name].size, table.thing(element).pose)
    return table.world.sensor(element.name)


def detects(table: ObjectTable, sensor: Element, element: Element) -> bool:
    """Say whether a solid part of a thing, or the origin of one without parts, lies in the volume of a sensor."""
    volume, thing = sensor_of(table, sensor), table.thing(element)
    solids = thing.solids()
    if not solids:
        return volume.contains(thing.pose[:3])
    shape, placed = geometry.volume(volume.shape, volume.size), pose_to_se3(volume.pose)
    return any(geometry.overlaps(shape, placed, parts, pose_to_se3(pose)) for parts, pose in solids)


def nearest(table: ObjectTable, sensor: Element) -> float:
    """Return the distance from the origin of a sensor to the nearest detectable thing in its volume [m], or -1."""
    place, least = pose_to_se3(sensor_of(table, sensor).pose), np.inf
    seen = _SEEN[:1] if sensor.kind == "placed" else _SEEN
    for element in table.elements():
        if element.kind in seen and table.flags.get((element, "detectable"), True) and detects(table, sensor, element):
            for parts, pose in table.thing(element).solids():
                least = min(least, geometry.gap((point_part(),), place, parts, pose_to_se3(pose)))
    return -1.0 if least == np.inf else float(least)


def contact_wrench(table: ObjectTable, element: Element) -> tuple[FloatArray, FloatArray]:
    """Return force (3,) [N] and torque (3,) [N m] of the normal contact forces on a body or link, in its frame."""
    body, link = body_of(table, element, "ForceSensor.read"), element.name.partition("/")[2]
    points = [c for c in table.world.contacts(body.name) if link in ("", c.link)]
    place = pose_to_se3(table.thing(element).pose)
    forces = [c.force * np.asarray(c.normal) for c in points]
    force = np.sum(forces, axis=0) if points else np.zeros(3)
    torque = (
        np.sum([np.cross(c.position - place.translation, f) for c, f in zip(points, forces)], axis=0) if points else np.zeros(3)
    )
    return place.rotation.T @ force, place.rotation.T @ torque
