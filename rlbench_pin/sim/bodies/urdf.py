"""Checks of a URDF before PyBullet reads it, because PyBullet ends the process on some broken ones."""

from __future__ import annotations

from pathlib import Path

from rlbench_pin.errors import AssetInvalid, AssetNotFound
from rlbench_pin.urdf import Urdf, read_urdf


def check_urdf(file: Path) -> None:
    """Check that links and joints form one tree, and that all meshes are there.

    Raises:
        AssetNotFound: A mesh does not exist.
        AssetInvalid: The file is not XML, or its joints do not connect its links to one tree.
    """
    urdf = read_urdf(file)
    links = urdf.link_names
    if not links or len(set(links)) < len(links):
        raise AssetInvalid(file, "it has no link" if not links else "two links have the same name")
    _check_joints(urdf, links)
    for mesh in urdf.meshes:
        if not mesh.is_file():
            raise AssetNotFound(mesh, file.name)


def _check_joints(urdf: Urdf, links: tuple[str, ...]) -> None:
    parents: dict[str, str] = {}
    for joint in urdf.joints:
        for link in (joint.parent, joint.child):
            if link not in links:
                raise AssetInvalid(urdf.path, f"joint '{joint.name}' names the link '{link}', which does not exist")
        if joint.child in parents:
            raise AssetInvalid(urdf.path, f"the link '{joint.child}' is the child of two joints")
        parents[joint.child] = joint.parent
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        raise AssetInvalid(urdf.path, f"it needs one link that is no joint's child, but has {', '.join(roots) or 'none'}")
    for link in links:
        if not _reaches(link, roots[0], parents):
            raise AssetInvalid(urdf.path, f"the link '{link}' is not connected to '{roots[0]}'")


def _reaches(link: str, root: str, parents: dict[str, str]) -> bool:
    for _ in range(len(parents) + 1):
        if link == root:
            return True
        link = parents.get(link, root)
    return False
