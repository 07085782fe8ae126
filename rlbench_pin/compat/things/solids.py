"""Boxes, contacts and distances of things."""

from __future__ import annotations

from typing import Any

import numpy as np

from rlbench_pin.compat.things.element import Element
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.robot import geometry
from rlbench_pin.sim import Contact
from rlbench_pin.spatial import FloatArray, pose_to_se3, relative

_OWNERS = {"link": "body", "robot_link": "robot", "gripper": "robot", "tip": "robot", "robot_joint": "robot"}


def tree_box(table: ObjectTable, element: Element) -> FloatArray:
    """Return the box (2, 3) around a thing and all that hangs on it, in its own frame [m]."""
    root = table.thing(element)
    frame, boxes = root.pose, [root.box()]
    for member in table.family.tree(table.elements(), element):
        thing = table.thing(member)
        if thing.type == "shape":
            corners = geometry.box_corners(thing.box(), relative(thing.pose, frame))
            boxes.append(np.stack([corners.min(axis=0), corners.max(axis=0)]))
    solid = [b for b in boxes if np.any(b[1] > b[0])] or boxes
    return np.stack([np.min([b[0] for b in solid], axis=0), np.max([b[1] for b in solid], axis=0)])


def collides(table: ObjectTable, element: Element, other: Element | None) -> bool:
    """Say whether a thing touches another one, or any collidable one outside its own tree."""
    if not table.flags.get((element, "collidable"), True):
        return False
    others = _obstacles(table, element) if other is None else [other]
    return any(_touch(table, element, o) for o in others if table.flags.get((o, "collidable"), True))


def _obstacles(table: ObjectTable, element: Element) -> list[Element]:
    """Bodies, room and robot, without what belongs to the thing itself."""
    own = {element, *table.family.ancestors(element), *table.family.tree(table.elements(), element)}
    return [e for e in table.elements() if e.kind in ("body", "room", "robot") and e not in own]


def _touch(table: ObjectTable, first: Element, second: Element) -> bool:
    for parts, pose in table.thing(first).solids():
        for others, there in table.thing(second).solids():
            for shape, placement in parts:
                if geometry.overlaps(shape, pose_to_se3(pose) * placement, others, pose_to_se3(there)):
                    return True
    return False


def distance(table: ObjectTable, first: Element, second: Element) -> float:
    """Return the smallest distance between two things [m]; things without solids count as points."""
    a, b = (table.thing(e).solids() or [((point_part(),), table.thing(e).pose)] for e in (first, second))
    return min(geometry.gap(p, pose_to_se3(pose), q, pose_to_se3(there)) for p, pose in a for q, there in b)


def point_part() -> geometry.Part:
    """Return a ball of a micrometre, to measure distances from."""
    ball = geometry.volume("sphere", (1e-6,))
    return ball, pose_to_se3((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))


def _owner_and_link(table: ObjectTable, element: Element) -> tuple[str, str | None]:
    """Name of the body of a contact, and of its link when only that link is meant."""
    if element.kind == "link":
        body, _, link = element.name.partition("/")
        return body, link
    if _OWNERS.get(element.kind, element.kind) == "robot":
        description = table.runtime.description
        links = {"robot_link": element.name, "gripper": description.hand_link}
        return description.name, links.get(element.kind)
    return element.name, None


def contacts(table: ObjectTable, element: Element, other: Element | None) -> list[dict[str, Any]]:
    """Return the contact points of the last physics step, as dicts of handles and six numbers."""
    if element.kind in ("frame", "root", "placed", "camera") or (other is not None and other.kind in ("frame", "placed")):
        return []
    body, link = _owner_and_link(table, element)
    second, second_link = (None, None) if other is None else _owner_and_link(table, other)
    found = [c for c in table.world.contacts(body, second) if link in (None, c.link) and second_link in (None, c.other_link)]
    return [
        {
            "contact_handles": [_link_handle(table, c.body, c.link), _link_handle(table, c.other, c.other_link)],
            "contact": np.concatenate([c.position, c.force * np.asarray(c.normal)]),
        }
        for c in found
    ]


def contact_force(table: ObjectTable, points: tuple[Contact, ...]) -> FloatArray:
    """Return the sum (3,) of the normal forces of contact points [N], in world axes."""
    return np.sum([c.force * np.asarray(c.normal) for c in points], axis=0) if points else np.zeros(3)


def _link_handle(table: ObjectTable, body: str, link: str) -> int:
    ids = {name: identifier for identifier, name in table.world.masks.items()}
    return ids.get(f"{body}/{link}", ids.get(body, -1))


def extension_string(table: ObjectTable, element: Element) -> str:
    """Return what a waypoint asks for, in known words; empty for other things."""
    found = [w for w in table.world.spec.waypoint if element == Element("frame", w.name)]
    if not found:
        return ""
    waypoint = found[0]
    words = ["ignore_collision"] if waypoint.ignore_collisions else []
    words += ["linear"] if waypoint.path == "straight" else []
    if waypoint.gripper in ("open", "close"):
        words.append(f"{waypoint.gripper}_gripper()")
    elif waypoint.gripper is not None:
        words.append(f"open_gripper({waypoint.gripper})")
    return ";".join(words)
