"""Files to upload."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import trimesh

from rlbench_pin.builder.custom_assets.conversion import Job, convert
from rlbench_pin.builder.custom_assets.mesh_asset import CustomAsset, obj_text

LINK = '<link name="{}"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>'
CABINET = """<?xml version="1.0"?>
<robot name="cabinet">
  <material name="oak"><color rgba="0.6 0.4 0.2 1"/></material>
  <link name="case">
    <inertial><mass value="2.0"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
    <visual><geometry><mesh filename="package://furniture/meshes/case.obj"/></geometry><material name="oak"/></visual>
    <collision><geometry><mesh filename="package://furniture/meshes/case.obj"/></geometry></collision>
  </link>
  <link name="door-1">
    <visual><origin xyz="0 0.05 0"/><geometry><box size="0.01 0.1 0.2"/></geometry></visual>
    <collision><origin xyz="0 0.05 0"/><geometry><box size="0.01 0.1 0.2"/></geometry></collision>
  </link>
  <link name="drawer">
    <visual><geometry><mesh filename="../meshes/knob.stl" scale="0.001 0.001 0.001"/></geometry></visual>
    <collision><geometry><sphere radius="0.01"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="case"/><child link="door-1"/><origin xyz="0.1 -0.05 0.1"/><axis xyz="0 0 2"/><limit lower="0" upper="1.5"/>
  </joint>
  <joint name="rail" type="prismatic">
    <parent link="case"/><child link="drawer"/><axis xyz="1 0 0"/><limit lower="0" upper="0.2" effort="5" velocity="1"/>
  </joint>
  <transmission name="ignored"/><gazebo reference="case"/>
</robot>
"""


def angle() -> trimesh.Trimesh:
    """Return an L, which is not convex [m]."""
    bars = [trimesh.creation.box((0.2, 0.04, 0.04)), trimesh.creation.box((0.04, 0.04, 0.2))]
    bars[1].apply_translation((0.08, 0.0, 0.1))
    return trimesh.boolean.union(bars)


def obj(mesh: trimesh.Trimesh) -> bytes:
    """Return a mesh as an OBJ file."""
    return obj_text(mesh).encode()


def stl(mesh: trimesh.Trimesh) -> bytes:
    """Return a mesh as a binary STL file."""
    content = mesh.export(file_type="stl")
    assert isinstance(content, bytes)
    return content


def zipped(files: dict[str, bytes | str]) -> bytes:
    """Return an archive."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return stream.getvalue()


def cabinet() -> bytes:
    """Return an archive with a cabinet: a door that turns, a drawer that slides."""
    knob = trimesh.creation.icosphere(1, 10.0)
    return zipped({
        "furniture/urdf/Cabinet.urdf": CABINET, "furniture/meshes/case.obj": obj(angle()),
        "furniture/meshes/knob.stl": stl(knob), "furniture/readme.txt": "hello", "__MACOSX/._Cabinet.urdf": "x",
    })  # fmt: skip


def make(name: str, data: bytes | str, folder: Path, scale: float = 1.0, mass: float = 0.0) -> CustomAsset:
    """Convert a file in this process."""
    content = data.encode() if isinstance(data, str) else data
    return convert(Job(name, str(folder), scale, mass, (1.0, 0.0, 0.0)), content, lambda text: None)


def put(asset: CustomAsset, folder: Path) -> Path:
    """Write the files of an asset, and return its URDF file."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in asset.files.items():
        (folder / name).write_bytes(content)
    return folder / asset.urdf
