"""Checks of a URDF before PyBullet reads it, because PyBullet ends the process on some broken ones."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import lru_cache
from pathlib import Path

from rlbench_pin.errors import AssetInvalid, AssetNotFound


@lru_cache(maxsize=256)
def check_urdf(urdf: Path) -> None:
    """Check that links and joints form one tree, and that all meshes are there.

    Raises:
        AssetNotFound: A mesh does not exist.
        AssetInvalid: The file is not XML, or its joints do not connect its links to one tree.
    """
    try:
        robot = ET.parse(urdf).getroot()
    except ET.ParseError as error:
        raise AssetInvalid(urdf, f"it is not XML: {error}") from error
    links = [link.get("name", "") for link in robot.findall("link")]
    if not links or len(set(links)) < len(links):
        raise AssetInvalid(urdf, "it has no link" if not links else "two links have the same name")
    _check_joints(urdf, robot, links)
    for mesh in robot.iter("mesh"):
        file = urdf.parent / mesh.get("filename", "")
        if not file.is_file():
            raise AssetNotFound(file, urdf.name)


def _check_joints(urdf: Path, robot: ET.Element, links: list[str]) -> None:
    parents: dict[str, str] = {}
    for joint in robot.findall("joint"):
        parent, child = (_link_of(joint, role) for role in ("parent", "child"))
        for link in (parent, child):
            if link not in links:
                raise AssetInvalid(urdf, f"joint '{joint.get('name')}' names the link '{link}', which does not exist")
        if child in parents:
            raise AssetInvalid(urdf, f"the link '{child}' is the child of two joints")
        parents[child] = parent
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        raise AssetInvalid(urdf, f"it needs one link that is no joint's child, but has {', '.join(roots) or 'none'}")
    for link in links:
        if not _reaches(link, roots[0], parents):
            raise AssetInvalid(urdf, f"the link '{link}' is not connected to '{roots[0]}'")


def _link_of(joint: ET.Element, role: str) -> str:
    element = joint.find(role)
    return "" if element is None else element.get("link", "")


def _reaches(link: str, root: str, parents: dict[str, str]) -> bool:
    for _ in range(len(parents) + 1):
        if link == root:
            return True
        link = parents.get(link, root)
    return False
