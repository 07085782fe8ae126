"""Shapes become closed surfaces with normals outwards; what cannot be read is left to PyBullet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pybullet
import pytest

from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import CameraView, look_at
from rlbench_pin.sim.render.raster.meshes import Triangles, triangles_of
from rlbench_pin.sim.render.raster.stage import Appearance, Stage
from tests.sim.support import BodySpec, build

SHAPES = [
    (pybullet.GEOM_BOX, (0.1, 0.2, 0.3), 0.006),
    (pybullet.GEOM_SPHERE, (0.1, 0.0, 0.0), 4.0 / 3.0 * np.pi * 1e-3),
    (pybullet.GEOM_CYLINDER, (0.3, 0.1, 0.0), 0.3 * np.pi * 1e-2),
    (pybullet.GEOM_CAPSULE, (0.3, 0.1, 0.0), 0.3 * np.pi * 1e-2 + 4.0 / 3.0 * np.pi * 1e-3),
]


def volume(triangles: Triangles) -> float:
    """Volume [m^3] inside triangles that turn counter-clockwise seen from outside."""
    a, b, c = triangles.corners.transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


@pytest.mark.parametrize(("kind", "size", "expected"), SHAPES)
def test_primitives_have_their_volume_and_normals_outwards(kind: int, size: tuple[float, ...], expected: float) -> None:
    """Within the 8 % that flat facets cost, so that no facet is missing or turned."""
    triangles = triangles_of(kind, size, "")
    assert triangles is not None
    assert 0.92 * expected < volume(triangles) <= 1.0001 * expected
    np.testing.assert_allclose(np.linalg.norm(triangles.normals, axis=2), 1.0, atol=1e-9)
    assert (np.einsum("ijk,ijk->ij", triangles.normals, triangles.corners) > 0.0).all()


def test_obj_files_with_polygons_and_without_normals(tmp_path: Path) -> None:
    """A square as one polygon is two triangles with a flat normal; negative indices count from the end."""
    file = tmp_path / "square.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n", encoding="utf-8")
    triangles = triangles_of(pybullet.GEOM_MESH, (2.0, 2.0, 1.0), str(file))
    assert triangles is not None and triangles.corners.shape == (2, 3, 3)
    np.testing.assert_allclose(triangles.normals, np.broadcast_to([0.0, 0.0, 1.0], (2, 3, 3)))
    np.testing.assert_allclose(triangles.corners.max(axis=(0, 1)), [2.0, 2.0, 0.0])


def without_normals(folder: Path, kind: int, size: tuple[float, ...]) -> Triangles:
    """A primitive, read back from an OBJ file that has its corners alone."""
    primitive = triangles_of(kind, size, "")
    assert primitive is not None
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in primitive.corners.reshape(-1, 3)]
    lines += [f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}" for i in range(len(primitive.corners))]
    (folder / f"shape{kind}.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    triangles = triangles_of(pybullet.GEOM_MESH, (1.0, 1.0, 1.0), str(folder / f"shape{kind}.obj"))
    assert triangles is not None
    np.testing.assert_allclose(np.linalg.norm(triangles.normals, axis=2), 1.0, atol=1e-9)
    return triangles


def test_meshes_without_normals_are_smooth_but_for_their_edges(tmp_path: Path) -> None:
    """A sphere gets normals within two degrees of its own; a box keeps flat faces; a cylinder is round and has flat ends."""
    ball = without_normals(tmp_path, pybullet.GEOM_SPHERE, (0.1, 0.0, 0.0))
    assert np.einsum("ijk,ijk->ij", ball.normals, ball.corners / 0.1).min() > np.cos(np.radians(2.0))
    box = without_normals(tmp_path, pybullet.GEOM_BOX, (0.1, 0.2, 0.3))
    assert (np.abs(box.normals).max(axis=2) > 1.0 - 1e-9).all()
    rod = without_normals(tmp_path, pybullet.GEOM_CYLINDER, (0.3, 0.1, 0.0))
    ends, sides = np.abs(rod.normals[..., 2]) > 0.999, np.abs(rod.normals[..., 2]) < 1e-6
    assert (ends | sides).all()
    radial = (rod.normals * rod.corners)[..., :2].sum(axis=2) / 0.1
    assert radial[sides].min() > np.cos(np.radians(1.0))


def test_colours_of_vertices_are_shades(tmp_path: Path) -> None:
    """Their brightness; a file without them, or with white ones, has none."""
    text = "v 0 0 0{0}\nv 1 0 0 1 1 1\nv 0 1 0{1}\nf 1 2 3\n"
    for name, ends, shades in (("dark", (" 0.5 0.5 0.5", " 0.2 0.4 0.6"), [[0.5, 1.0, 0.4]]), ("white", ("", " 1 1 1"), None)):
        (tmp_path / f"{name}.obj").write_text(text.format(*ends))
        triangles = triangles_of(pybullet.GEOM_MESH, (1.0, 1.0, 1.0), str(tmp_path / f"{name}.obj"))
        assert triangles is not None
        if shades is None:
            assert triangles.shades is None
        else:
            np.testing.assert_allclose(triangles.shades, shades)


def test_other_files_are_not_drawn_here() -> None:
    """STL and DAE meshes, and planes."""
    assert triangles_of(pybullet.GEOM_MESH, (1.0, 1.0, 1.0), "thing.stl") is None
    assert triangles_of(pybullet.GEOM_PLANE, (1.0, 1.0, 1.0), "") is None


def test_a_world_with_such_a_mesh_is_left_to_tinyrenderer(tmp_path: Path) -> None:
    """The stage says so, and images still show the thing."""
    corners = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]], dtype=np.float32)
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    facets = b"".join(bytes(12) + corners[list(face)].tobytes() + bytes(2) for face in faces)
    (tmp_path / "thing.stl").write_bytes(bytes(80) + np.uint32(len(faces)).tobytes() + facets)
    (tmp_path / "thing.urdf").write_text(
        '<robot name="thing"><link name="thing"><inertial><mass value="0.1"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0"'
        ' ixz="0" iyz="0"/></inertial><visual><geometry><mesh filename="thing.stl"/></geometry></visual></link></robot>',
        encoding="utf-8",
    )
    body = BodySpec(
        name="thing", asset=str(tmp_path / "thing.urdf"), parent="world", pose=(0.3, 0.0, 1.2, 0, 0, 0, 1), fixed=True
    )
    with build(SceneSpec(format=1, body=(body,))) as world:
        assert Stage(world.client, frozenset(), Appearance()).update() is None
        view = CameraView(pose=look_at((1.3, 0.3, 1.6), (0.3, 0.0, 1.2)), fov=0.7, size=(64, 64), near=0.01, far=4.0)
        assert (world.render(view, shadows=True).mask == 61).sum() > 50
