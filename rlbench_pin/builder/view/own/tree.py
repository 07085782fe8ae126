"""Links and joints of a URDF file of unknown origin: one tree, of known kinds, with names that a scene can say."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

from rlbench_pin.builder.server import UploadRefused
from rlbench_pin.builder.view.own.xml_text import parse_xml

JOINTS = ("fixed", "revolute", "continuous", "prismatic")
"""Kinds of joints that are taken."""
_MOST_LINKS = 200
_OTHER = re.compile(r"[^A-Za-z0-9_]+")


def checked_model(name: str, data: bytes) -> tuple[Element, dict[str, str], dict[str, str]]:
    """Return the first element of a URDF file, and what its links and joints are called from now on.

    Raises:
        UploadRefused: It is no XML, or its joints do not connect its links to one tree.
    """
    root = parse_xml(name, data)
    if root.tag != "robot":
        raise UploadRefused(name, f"its first element is <{root.tag}>, not <robot>", "It is no URDF file.")
    joints = root.findall("joint")
    links, joint_names = clean_names(name, root.findall("link")), clean_names(name, joints)
    check_tree(name, links, joints)
    return root, links, joint_names


def clean_names(urdf: str, elements: Sequence[Element]) -> dict[str, str]:
    """Return what each element is called from now on: letters, digits and `_`.

    Raises:
        UploadRefused: One has no name, or the name of another.
    """
    names: dict[str, str] = {}
    for element in elements:
        said = element.get("name", "").strip()
        if not said or said in names:
            problem = f"two <{element.tag}> are called '{said[:60]}'" if said else f"a <{element.tag}> has no name"
            raise UploadRefused(urdf, problem, "Names are unique.")
        stem = _OTHER.sub("_", said)[:60].strip("_") or element.tag
        clean, number = stem, 2
        while clean in names.values():
            clean, number = f"{stem}_{number}", number + 1
        names[said] = clean
    return names


def check_tree(urdf: str, links: Mapping[str, str], joints: Sequence[Element]) -> None:
    """Check that joints connect all links to one tree.

    Raises:
        UploadRefused: They do not, or one is of a kind that is not taken.
    """
    if not links or len(links) > _MOST_LINKS:
        raise UploadRefused(urdf, f"it has {len(links)} links; 1 to {_MOST_LINKS} are taken")
    parents: dict[str, str] = {}
    for joint in joints:
        name, kind = joint.get("name", ""), joint.get("type", "")
        parent, child = end_of(joint, "parent"), end_of(joint, "child")
        if kind not in JOINTS:
            raise UploadRefused(urdf, f"joint '{name}' is of type '{kind}'", f"Joints are {', '.join(JOINTS)}.")
        for link in (parent, child):
            if link not in links:
                raise UploadRefused(urdf, f"joint '{name}' names the link '{link}', which does not exist")
        if child in parents:
            raise UploadRefused(urdf, f"the link '{child}' is the child of two joints")
        parents[child] = parent
    roots = [link for link in links if link not in parents]
    if len(roots) > 1:
        raise UploadRefused(urdf, f"it has {len(roots)} roots: {', '.join(roots[:4])}", "Connect them by joints.")
    for link in links:
        _check_way(urdf, link, parents)


def end_of(joint: Element, end: str) -> str:
    """Return the link at the `parent` or `child` end of a joint."""
    element = joint.find(end)
    return "" if element is None else element.get("link", "").strip()


def _check_way(urdf: str, link: str, parents: Mapping[str, str]) -> None:
    """Check that one gets from a link to the root."""
    way = [link]
    while (parent := parents.get(way[-1])) is not None:
        if parent in way:
            raise UploadRefused(urdf, f"its joints form a circle: {' -> '.join([*way[way.index(parent) :], parent][:8])}")
        way.append(parent)
