"""Where things are, remembered by a program to go back there."""

from __future__ import annotations

from dataclasses import dataclass

from rlbench_pin.compat.devices.joints import drive_of
from rlbench_pin.compat.things import Element, ObjectTable
from rlbench_pin.spatial import FloatArray


@dataclass(frozen=True, eq=False)
class ConfigurationTree:
    """Poses and joint values of a thing and all that hangs on it, at one instant."""

    poses: dict[Element, FloatArray]
    """Poses (7,) in the world, parents first."""
    joints: dict[Element, float]
    """Joint values [rad] or [m]."""


_POSED = ("root", "body", "frame", "placed")


def read(table: ObjectTable, root: Element) -> ConfigurationTree:
    """Return where a thing and all that hangs on it are."""
    tree = table.family.tree(table.elements(), root)
    members = [root, *sorted(tree, key=lambda element: len(table.family.ancestors(element)))]
    poses = {e: table.thing(e).pose for e in members if e.kind in _POSED}
    return ConfigurationTree(poses, {e: drive_of(table, e).position for e in members if e.kind in ("joint", "robot_joint")})


def write(table: ObjectTable, configuration: ConfigurationTree) -> None:
    """Put everything back, at rest; what does not exist any more is left out."""
    for element, pose in configuration.poses.items():
        if table.exists(element):
            table.thing(element).set_pose(pose, True)
    for element, position in configuration.joints.items():
        if table.exists(element):
            drive_of(table, element).put(position)
