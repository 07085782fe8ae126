"""The files of the assets are small, complete, convex where they must be, and licensed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from rlbench_pin.assets import ASSETS
from tests.assets.support import OBJECTS, ROBOTS, URDFS, label, meshes_of, read_obj

OBJECT_TRIANGLES, FURNITURE_TRIANGLES = 1100, 1400
FURNITURE = 0.3
"""Length of a mesh of furniture, on whose large faces the light changes [m]."""
ARM_TRIANGLES, ARM_BYTES = 5000, 500_000
HULL_VERTICES = 64


def _triangles(path: Path) -> int:
    return sum(len(read_obj(mesh)[1]) for mesh in meshes_of(path, "visual"))


@pytest.mark.parametrize("path", OBJECTS, ids=label)
def test_objects_have_few_triangles(path: Path) -> None:
    """An object costs the renderer little."""
    longest = max((float(np.ptp(read_obj(mesh)[0], axis=0).max()) for mesh in meshes_of(path, "visual")), default=0.0)
    assert _triangles(path) <= (FURNITURE_TRIANGLES if longest >= FURNITURE else OBJECT_TRIANGLES)


@pytest.mark.parametrize("path", ROBOTS, ids=label)
def test_robots_have_few_triangles(path: Path) -> None:
    """An arm with its gripper stays cheap to draw, too, and its files are small."""
    assert _triangles(path) <= ARM_TRIANGLES
    assert sum(file.stat().st_size for file in path.parent.rglob("*") if file.is_file()) <= ARM_BYTES


@pytest.mark.parametrize("path", URDFS, ids=label)
def test_collision_meshes_are_small_and_convex(path: Path) -> None:
    """Every vertex of a collision mesh lies on its convex hull (to the rounding of the files), and there are few."""
    for mesh in meshes_of(path, "collision"):
        vertices, faces = read_obj(mesh)
        hull = ConvexHull(vertices)
        depth = -(vertices @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
        assert depth.max() < 5e-5
        assert len(np.unique(hull.simplices)) <= HULL_VERTICES * 4
        assert _volume(vertices, faces) == pytest.approx(hull.volume, rel=2e-3)


@pytest.mark.parametrize("path", (*OBJECTS, *ROBOTS), ids=label)
def test_robot_hulls_are_small(path: Path) -> None:
    """No collision mesh has more than a few dozen vertices."""
    for mesh in meshes_of(path, "collision"):
        assert len(read_obj(mesh)[0]) <= (HULL_VERTICES if path in ROBOTS else 130)


@pytest.mark.parametrize("path", OBJECTS, ids=label)
def test_surfaces_face_outwards(path: Path) -> None:
    """Closed visual meshes enclose a positive volume."""
    for mesh in meshes_of(path, "visual"):
        if mesh.stem != "liner":
            assert _volume(*read_obj(mesh)) > 0.0, mesh.name


def _volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def test_nothing_is_missing_and_nothing_is_left_over() -> None:
    """Every mesh that a URDF names exists, and every mesh that exists is named."""
    named = {mesh for path in URDFS for kind in ("visual", "collision") for mesh in meshes_of(path, kind)}
    assert all(mesh.is_file() for mesh in named)
    assert {path for folder in ("objects", "robots", "room") for path in (ASSETS / folder).rglob("*.obj")} == named


def test_all_files_together_are_small() -> None:
    """The assets of the wheel stay below 12 MB."""
    assert sum(path.stat().st_size for path in ASSETS.rglob("*") if path.is_file()) < 12e6


@pytest.mark.parametrize("path", URDFS, ids=label)
def test_every_asset_has_a_licence_and_a_catalogue_entry(path: Path) -> None:
    """LICENSES.md and CATALOGUE.md name every asset."""
    folder = path.parent.relative_to(ASSETS).as_posix()
    name = f"room/{path.stem}" if folder == "room" else folder
    assert f"| {name} |" in (ASSETS / "LICENSES.md").read_text()
    assert f"## {path.stem}\n" in (ASSETS / "CATALOGUE.md").read_text()
