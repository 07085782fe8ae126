"""URDF files of unknown origin: bounded XML without entities, finite numbers, one tree of links with valid names."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.parsers import expat

from rlbench_pin.builder.custom_assets.uploads import UploadRefused

MAX_TEXT_SIZE = 4 * 1024 * 1024
"""Size of a URDF file at most [bytes]."""
JOINTS = ("fixed", "revolute", "continuous", "prismatic")
"""Accepted joint types."""
_MAX_ELEMENTS = 20_000
_MAX_DEPTH = 32
_MAX_LINKS = 200
_OTHER = re.compile(r"[^A-Za-z0-9_]+")


class _Limits:
    """Handlers of an XML parser that bound depth and number of elements."""

    def __init__(self, name: str) -> None:
        self._name, self._depth, self._count = name, 0, 0

    def start(self, tag: str, attributes: object) -> None:
        self._depth, self._count = self._depth + 1, self._count + 1
        if self._depth > _MAX_DEPTH or self._count > _MAX_ELEMENTS:
            problem = f"it has more than {_MAX_ELEMENTS} elements, or more than {_MAX_DEPTH} nested ones"
            raise UploadRefused(self._name, problem, "Reduce them.")

    def end(self, tag: str) -> None:
        self._depth -= 1

    def declare(self, *declaration: object) -> None:
        hint = "Remove <!DOCTYPE ...>: a URDF file needs none."
        raise UploadRefused(self._name, "it declares a document type or entities", hint)


def parse_xml(name: str, data: bytes) -> ElementTree.Element:
    """Return the root element of a document.

    Raises:
        UploadRefused: It is not XML, is too large or nested too deeply, or declares entities.
    """
    if len(data) > MAX_TEXT_SIZE:
        raise UploadRefused(
            name, f"it has {len(data) / 2**20:.0f} MB of XML, the limit is {MAX_TEXT_SIZE // 2**20} MB", "Reduce it."
        )
    limits, parser = _Limits(name), expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = limits.start, limits.end
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = limits.declare
    try:
        parser.Parse(data, True)
        return ElementTree.fromstring(data)
    except (expat.ExpatError, ElementTree.ParseError, LookupError, ValueError) as error:
        raise UploadRefused(name, f"it is not valid XML: {error}", "Correct the file.") from error


class Numbers:
    """Reads numbers of attributes; the name of the file is for errors."""

    def __init__(self, name: str) -> None:
        self._name = name

    def several(self, element: ElementTree.Element | None, key: str, count: int, default: str) -> tuple[float, ...]:
        """Return `count` finite numbers of an attribute."""
        if element is None:
            return tuple(float(word) for word in default.split())
        given = element.get(key, default)
        try:
            numbers = tuple(float(word) for word in given.split())
        except ValueError:
            numbers = ()
        if len(numbers) != count or not all(math.isfinite(number) and abs(number) < 1e6 for number in numbers):
            wanted = "a finite number" if count == 1 else f"{count} finite numbers"
            raise UploadRefused(self._name, f"'{key}' of a <{element.tag}> has to be {wanted}, not '{given[:60]}'", "Correct it.")
        return numbers

    def one(self, element: ElementTree.Element | None, key: str, default: str, least: float = -math.inf) -> float:
        """Return one finite number of an attribute that is at least `least`."""
        number = self.several(element, key, 1, default)[0]
        if number < least:
            tag = "" if element is None else element.tag
            raise UploadRefused(self._name, f"'{key}' of a <{tag}> is {number:g}, and has to be {least:g} or more", "Correct it.")
        return number

    def positive(self, element: ElementTree.Element, key: str, count: int, default: str, most: float) -> tuple[float, ...]:
        """Return numbers of an attribute that are above 0."""
        numbers = self.several(element, key, count, default)
        if not all(0.0 < number <= most for number in numbers):
            given = " ".join(f"{number:g}" for number in numbers)
            problem = f"'{key}' of a <{element.tag}> is {given}, and has to be above 0, at most {most:g}"
            raise UploadRefused(self._name, problem, "Correct it.")
        return numbers


def checked_model(name: str, data: bytes) -> tuple[Element, dict[str, str], dict[str, str]]:
    """Return the root element of a URDF file, and valid names of its links and joints by their given names.

    Raises:
        UploadRefused: It is not a URDF file, or its links and joints do not form a tree.
    """
    root = parse_xml(name, data)
    if root.tag != "robot":
        raise UploadRefused(name, f"its first element is <{root.tag}>, not <robot>", "Send a URDF file.")
    joints = root.findall("joint")
    links, joint_names = clean_names(name, root.findall("link")), clean_names(name, joints)
    check_tree(name, links, joints)
    return root, links, joint_names


def clean_names(urdf: str, elements: Sequence[Element]) -> dict[str, str]:
    """Return a valid name for each element, of letters, digits and `_`, by its given name.

    Raises:
        UploadRefused: One has no name, or the name of another.
    """
    names: dict[str, str] = {}
    for element in elements:
        given = element.get("name", "").strip()
        if not given or given in names:
            problem = f"two <{element.tag}> are called '{given[:60]}'" if given else f"a <{element.tag}> has no name"
            raise UploadRefused(urdf, problem, "Give each its own name.")
        stem = _OTHER.sub("_", given)[:60].strip("_") or element.tag
        clean, number = stem, 2
        while clean in names.values():
            clean, number = f"{stem}_{number}", number + 1
        names[given] = clean
    return names


def check_tree(urdf: str, links: Mapping[str, str], joints: Sequence[Element]) -> None:
    """Check that links and joints form one tree.

    Raises:
        UploadRefused: They do not, or a joint has an unknown type.
    """
    if not links or len(links) > _MAX_LINKS:
        raise UploadRefused(urdf, f"it has {len(links)} links; 1 to {_MAX_LINKS} are possible", "Change it.")
    parents: dict[str, str] = {}
    for joint in joints:
        name, kind = joint.get("name", ""), joint.get("type", "")
        parent, child = joint_end(joint, "parent"), joint_end(joint, "child")
        if kind not in JOINTS:
            raise UploadRefused(urdf, f"joint '{name}' is of type '{kind}'", f"Joints are {', '.join(JOINTS)}.")
        for link in (parent, child):
            if link not in links:
                raise UploadRefused(urdf, f"joint '{name}' names the link '{link}', which does not exist", "Correct it.")
        if child in parents:
            raise UploadRefused(urdf, f"the link '{child}' is the child of two joints", "Remove one of them.")
        parents[child] = parent
    roots = [link for link in links if link not in parents]
    if len(roots) > 1:
        raise UploadRefused(urdf, f"it has {len(roots)} roots: {', '.join(roots[:4])}", "Connect them by joints.")
    for link in links:
        _check_path(urdf, link, parents)


def joint_end(joint: Element, end: str) -> str:
    """Return the link at the `parent` or `child` end of a joint."""
    element = joint.find(end)
    return "" if element is None else element.get("link", "").strip()


def _check_path(urdf: str, link: str, parents: Mapping[str, str]) -> None:
    """Check that a path leads from a link to the root."""
    path = [link]
    while (parent := parents.get(path[-1])) is not None:
        if parent in path:
            cycle = " -> ".join([*path[path.index(parent) :], parent][:8])
            raise UploadRefused(urdf, f"its joints form a cycle: {cycle}", "Remove one of these joints.")
        path.append(parent)


def one_link_urdf(name: str, inertial: Sequence[str], visual: str, collisions: Sequence[str], color: Sequence[float]) -> str:
    """Return a URDF file of one link.

    Args:
        name: Name of model, link and material.
        inertial: Elements of its inertia.
        visual: Shape that cameras see.
        collisions: Shapes that touch.
        color: Red, green, blue from 0 to 1.
    """
    rgba = " ".join(f"{share:g}" for share in (*color[:3], 1.0))
    lines = (
        '<?xml version="1.0"?>',
        f'<robot name="{name}">',
        f'  <link name="{name}">',
        '    <contact><lateral_friction value="0.8"/></contact>',
        "    <inertial>",
        *(f"      {element}" for element in inertial),
        "    </inertial>",
        "    <visual>",
        f"      <geometry>{visual}</geometry>",
        f'      <material name="{name}"><color rgba="{rgba}"/></material>',
        "    </visual>",
        *(f"    <collision>\n      <geometry>{shape}</geometry>\n    </collision>" for shape in collisions),
        "  </link>",
        "</robot>",
    )
    return "\n".join(lines) + "\n"
