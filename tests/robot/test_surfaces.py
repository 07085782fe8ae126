"""Surfaces of solids: corners, triangles and volumes; flat meshes are no trap."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import AssetInvalid, AssetNotFound
from rlbench_pin.robot import geometry, surfaces
from rlbench_pin.scene.snapshot import Shape

POSE = (0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0)


def _enclosed(surface: surfaces.Surface) -> float:
    """Volume inside a closed surface whose triangles look outwards [m^3]."""
    corners, triangles = surface
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    return float(np.sum(np.einsum("ij,ij->i", a, np.cross(b, c))) / 6.0)


@pytest.mark.parametrize(
    "shape",
    [
        Shape("box", (0.1, 0.2, 0.3), POSE),
        Shape("sphere", (0.1,), POSE),
        Shape("cylinder", (0.1, 0.2), POSE),
        Shape("capsule", (0.1, 0.2), POSE),
    ],
)
def test_surfaces_enclose_their_solid(shape: Shape) -> None:
    """Within what a polyhedron of 24 sides loses of a round solid, at the right place."""
    part = geometry.primitive(shape)
    surface = surfaces.part_surface(part)
    assert 0.95 * surfaces.part_volume(part) < abs(_enclosed(surface)) <= 1.0001 * surfaces.part_volume(part)
    assert np.allclose(0.5 * (surface[0].min(axis=0) + surface[0].max(axis=0)), POSE[:3], atol=1e-6)


def test_mesh_files(tmp_path: Path) -> None:
    """A mesh is read as it stands, scaled; what is no mesh is refused."""
    file = tmp_path / "corner.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    corners, triangles = surfaces.mesh_surface(file, 0.5)
    assert triangles.shape == (4, 3) and np.isclose(_enclosed((corners, triangles)), 0.125 / 6.0)
    with pytest.raises(AssetNotFound):
        surfaces.mesh_surface(tmp_path / "none.obj")
    (tmp_path / "text.obj").write_text("hello")
    with pytest.raises(AssetInvalid):
        surfaces.mesh_surface(tmp_path / "text.obj")


def test_flat_meshes_become_thin_plates() -> None:
    """The ceiling is one rectangle; distances to it are those to the rectangle."""
    (parts,) = geometry.solid_geometry(asset_path("room/ceiling.urdf")).values()
    low, high = geometry.bounds(parts)
    assert 0.0 < (high - low)[2] < 2e-4 and (high - low)[:2].min() > 1.0
    ball = (geometry.primitive(Shape("sphere", (0.1,), (0.0, 0.0, float(low[2]) - 0.5, 0.0, 0.0, 0.0, 1.0))),)
    identity = geometry.to_placement(None)
    assert np.isclose(geometry.gap(ball, identity, parts, identity), 0.4, atol=1e-3)
