"""Shapes of URDF files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import AssetInvalid, AssetNotFound
from rlbench_pin.robot import geometry
from rlbench_pin.scene.snapshot import Shape
from rlbench_pin.urdf import read_urdf

URDF = """<robot name="thing">
  <link name="base">
    <visual><origin xyz="0 0 1"/><geometry><sphere radius="0.5"/></geometry></visual>
    <collision><origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/><geometry><box size="0.2 0.4 0.6"/></geometry></collision>
    <collision><origin xyz="0 0 1" rpy="1.5707963267948966 0 0"/>
      <geometry><cylinder radius="0.1" length="0.8"/></geometry></collision>
  </link>
  <link name="ghost"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <joint name="j" type="fixed"><parent link="base"/><child link="ghost"/></joint>
</robot>"""


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    """A model of primitives."""
    file = tmp_path / "thing.urdf"
    file.write_text(URDF)
    return file


def at(x: float, y: float, z: float) -> pin.SE3:
    """A placement without rotation."""
    return pin.SE3(np.eye(3), np.array([x, y, z]))


def test_links_have_their_collision_shapes(urdf: Path) -> None:
    """Links without collision shapes are left out; a marker counts with what is seen of it."""
    assert list(geometry.link_geometry(urdf)) == ["base"]
    assert len(geometry.link_geometry(urdf)["base"]) == 2
    assert list(geometry.visual_geometry(urdf)) == ["base", "ghost"]
    assert geometry.solid_geometry(urdf) == geometry.link_geometry(urdf)
    assert read_urdf(urdf).base_link == "base"


def test_bounds_are_tight_and_scale(urdf: Path) -> None:
    """Turned boxes and cylinders have exact bounds, and a scale stretches sizes and origins."""
    box = geometry.bounds(geometry.link_geometry(urdf)["base"])
    np.testing.assert_allclose(box, [[-0.1, -0.4, -0.3], [0.3, 0.4, 1.1]], atol=1e-12)
    np.testing.assert_allclose(geometry.bounds(geometry.link_geometry(urdf, 2.0)["base"]), 2.0 * box, atol=1e-12)
    np.testing.assert_allclose(
        geometry.bounds(geometry.visual_geometry(urdf)["base"]), [[-0.5, -0.5, 0.5], [0.5, 0.5, 1.5]], atol=1e-12
    )


def test_meshes_become_convex_hulls() -> None:
    """The mesh of the hand is one hull of the hand's size."""
    ((hull, _),) = geometry.link_geometry(asset_path("robots/panda/panda.urdf"))["panda_hand"]
    size = np.ptp(np.array(hull.points()), axis=0)
    np.testing.assert_allclose(size, [0.064, 0.205, 0.093], atol=5e-3)


def test_volumes_meet_links(urdf: Path) -> None:
    """A volume overlaps a link exactly when it reaches one of its shapes."""
    parts = geometry.link_geometry(urdf)["base"]
    sphere = geometry.volume("sphere", (0.2,))
    link = at(0.0, 0.0, 0.0)
    assert geometry.overlaps(sphere, at(0.39, 0.0, 0.0), parts, link)
    assert not geometry.overlaps(sphere, at(0.41, 0.0, 0.0), parts, link)
    assert geometry.overlaps(sphere, at(0.39, 0.0, 5.0), parts, at(0.0, 0.0, 5.0))
    box = geometry.volume("box", (0.2, 0.2, 0.2))
    assert geometry.overlaps(box, at(0.0, 0.49, 1.0), parts, link)
    assert not geometry.overlaps(box, at(0.0, 0.51, 1.0), parts, link)


@pytest.mark.parametrize(
    ("shape", "size", "inside", "outside"),
    [
        ("box", (0.2, 0.4, 0.6), (0.09, 0.19, 0.29), (0.11, 0.0, 0.0)),
        ("cylinder", (0.2, 0.6), (0.07, 0.07, 0.29), (0.08, 0.08, 0.0)),
        ("sphere", (0.2,), (0.05, 0.05, 0.05), (0.06, 0.06, 0.06)),
    ],
)
def test_volumes_contain_points(
    shape: geometry.VolumeShape, size: tuple[float, ...], inside: tuple[float, ...], outside: tuple[float, ...]
) -> None:
    """Sizes are diameters and full lengths; the volume may stand anywhere."""
    T = pin.SE3(pin.rpy.rpyToMatrix(0.3, 0.2, 0.1), np.array([1.0, 2.0, 3.0]))
    assert geometry.volume_contains(shape, size, T, T.act(np.array(inside)))
    assert not geometry.volume_contains(shape, size, T, T.act(np.array(outside)))


def test_missing_and_broken_files_are_named(tmp_path: Path) -> None:
    """The error says which file is missing or wrong."""
    with pytest.raises(AssetNotFound, match=r"nowhere\.urdf"):
        geometry.link_geometry(tmp_path / "nowhere.urdf")
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot>")
    with pytest.raises(AssetInvalid, match=r"broken\.urdf"):
        geometry.link_geometry(broken)
    lost = tmp_path / "lost.urdf"
    lost.write_text(
        '<robot><link name="a"><collision><geometry><mesh filename="gone.obj"/></geometry></collision></link></robot>'
    )
    with pytest.raises(AssetNotFound, match=r"gone\.obj"):
        geometry.link_geometry(lost)


POSE = (0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0)


def _enclosed(surface: geometry.Surface) -> float:
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
    surface = geometry.part_surface(part)
    assert 0.95 * geometry.part_volume(part) < abs(_enclosed(surface)) <= 1.0001 * geometry.part_volume(part)
    assert np.allclose(0.5 * (surface[0].min(axis=0) + surface[0].max(axis=0)), POSE[:3], atol=1e-6)


def test_mesh_files(tmp_path: Path) -> None:
    """A mesh is read as it stands, scaled; what is no mesh is refused."""
    file = tmp_path / "corner.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    corners, triangles = geometry.mesh_surface(file, 0.5)
    assert triangles.shape == (4, 3) and np.isclose(_enclosed((corners, triangles)), 0.125 / 6.0)
    with pytest.raises(AssetNotFound):
        geometry.mesh_surface(tmp_path / "none.obj")
    (tmp_path / "text.obj").write_text("hello")
    with pytest.raises(AssetInvalid):
        geometry.mesh_surface(tmp_path / "text.obj")


def test_flat_meshes_become_thin_plates() -> None:
    """The ceiling is one rectangle; distances to it are those to the rectangle."""
    (parts,) = geometry.solid_geometry(asset_path("room/ceiling.urdf")).values()
    low, high = geometry.bounds(parts)
    assert 0.0 < (high - low)[2] < 2e-4 and (high - low)[:2].min() > 1.0
    ball = (geometry.primitive(Shape("sphere", (0.1,), (0.0, 0.0, float(low[2]) - 0.5, 0.0, 0.0, 0.0, 1.0))),)
    identity = geometry.to_placement(None)
    assert np.isclose(geometry.gap(ball, identity, parts, identity), 0.4, atol=1e-3)
