"""A URDF file is written anew with its meshes; collision geometry is convex, lengths and mass are as requested."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from rlbench_pin.builder.custom_assets.uploads import UploadRefused
from rlbench_pin.sim.bodies.urdf import check_urdf
from rlbench_pin.urdf import Urdf, read_urdf
from tests.builder.custom_assets.files import CABINET, LINK, angle, cabinet, make, obj, put, stl, zipped


def _cabinet(folder: Path, scale: float = 1.0, mass: float = 0.0) -> Urdf:
    file = put(make("cabinet.zip", cabinet(), folder, scale, mass), folder / "made")
    check_urdf(file)
    return read_urdf(file)


def test_an_archive_becomes_a_model(tmp_path: Path) -> None:
    """Packages and relative paths are found, names cleaned, joints kept, the hollow case taken apart, colours in place."""
    urdf = _cabinet(tmp_path)
    assert urdf.path.name == "cabinet.urdf"
    assert urdf.link_names == ("case", "door_1", "drawer")
    assert urdf.joint_limits == {"hinge": (0.0, 1.5), "rail": (0.0, 0.2)}
    assert [joint.axis for joint in urdf.joints] == [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)]
    case, door, drawer = urdf.links
    assert len(case.collisions) >= 2
    assert case.visuals[0].color == (0.6, 0.4, 0.2, 1.0)
    assert all(mesh.parent == urdf.path.parent for mesh in urdf.meshes)
    assert case.inertial is not None
    assert door.inertial is not None
    assert (case.inertial.mass, door.inertial.mass) == (2.0, pytest.approx(0.01 * 0.1 * 0.2 * 500.0))
    assert drawer.visuals[0].mesh is not None
    knob = trimesh.load(drawer.visuals[0].mesh, force="mesh")
    assert np.ptp(np.asarray(knob.vertices), axis=0) == pytest.approx([0.02, 0.02, 0.02], abs=1e-3)


def test_scale_and_mass(tmp_path: Path) -> None:
    """Lengths double, places and rails with them; the mass is that of all links; moments follow both."""
    small, large = _cabinet(tmp_path / "a"), _cabinet(tmp_path / "b", 2.0, 8.0)
    assert large.joint_limits == {"hinge": (0.0, 1.5), "rail": (0.0, 0.4)}
    assert large.joints[0].origin is not None
    assert large.joints[0].origin.xyz == (0.2, -0.1, 0.2)
    assert large.links[1].visuals[0].size == (0.02, 0.2, 0.4)
    masses = [link.inertial.mass for link in large.links if link.inertial is not None]
    assert sum(masses) == pytest.approx(8.0)
    first, second = small.links[0].inertial, large.links[0].inertial
    assert first is not None
    assert second is not None
    assert second.inertia[0] / first.inertia[0] == pytest.approx(4.0 * masses[0] / 2.0, rel=1e-3)


def test_meshes_in_the_folder_are_found(tmp_path: Path) -> None:
    """A URDF file that comes alone names meshes beside the task; a link out of the folder is not followed."""
    (tmp_path / "task" / "parts").mkdir(parents=True)
    (tmp_path / "task" / "parts" / "angle.obj").write_bytes(obj(angle()))
    shape = '<collision><geometry><mesh filename="parts/angle.obj"/></geometry></collision>'
    text = f'<robot name="a"><link name="a">{shape}</link></robot>'
    assert "angle_part.obj" in make("a.urdf", text, tmp_path / "task").files
    (tmp_path / "secret.obj").write_bytes(obj(angle()))
    (tmp_path / "task" / "parts" / "way.obj").symlink_to(tmp_path / "secret.obj")
    with pytest.raises(Exception, match="leads out"):
        make("a.urdf", text.replace("angle.obj", "way.obj"), tmp_path / "task")


def test_a_mesh_of_two_sizes_is_two_files(tmp_path: Path) -> None:
    """And one that is named twice with one size is one."""
    shape = '<visual><geometry><mesh filename="k.stl" scale="{0} {0} {0}"/></geometry></visual>'
    text = f'<robot name="a"><link name="a">{shape.format(0.1)}{shape.format(0.2)}{shape.format(0.1)}</link></robot>'
    asset = make("a.zip", zipped({"a.urdf": text, "k.stl": stl(angle())}), tmp_path)
    assert sorted(asset.files) == ["a.urdf", "k.obj", "k1.obj"]


def test_several_urdf_files_are_listed(tmp_path: Path) -> None:
    """And none is said."""
    text = f'<robot name="a">{LINK.format("a")}</robot>'
    with pytest.raises(UploadRefused, match=r"2 URDF files: one/a.urdf, two/b.urdf"):
        make("a.zip", zipped({"one/a.urdf": text, "two/b.urdf": text}), tmp_path)
    with pytest.raises(UploadRefused, match="no URDF file"):
        make("a.zip", zipped({"a.obj": obj(angle())}), tmp_path)


def test_a_missing_mesh_is_named_with_those_there(tmp_path: Path) -> None:
    """So that one sees what is spelt otherwise."""
    with pytest.raises(UploadRefused, match=r"meshes/case.obj' is not in the archive.*knob.stl"):
        make("c.zip", zipped({"c.urdf": CABINET, "knob.stl": stl(angle())}), tmp_path)
    with pytest.raises(UploadRefused, match="could be a/case.obj or b/case.obj"):
        make("c.zip", zipped({"c.urdf": CABINET, "a/case.obj": obj(angle()), "b/case.obj": obj(angle())}), tmp_path)
