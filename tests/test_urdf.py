"""URDF and SRDF files as records."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import pytest

from rlbench_pin.errors import AssetInvalid, AssetNotFound
from rlbench_pin.urdf import UNBOUNDED, UrdfOrigin, disabled_pairs, kinematic_urdf, read_urdf

URDF = """<robot name="thing">
  <material name="paint"><texture filename="paint.png"/></material>
  <link name="base">
    <inertial><mass value="2"/><origin xyz="0 0 0.1"/><inertia ixx="1" iyy="2" izz="3" ixy="0.1"/></inertial>
    <visual><origin xyz="0 0 1"/><geometry><sphere radius="0.5"/></geometry><material><color rgba="1 0 0 1"/></material></visual>
    <collision><origin xyz="0.1 0 0" rpy="0 0 1.5"/><geometry><box size="0.2 0.4 0.6"/></geometry></collision>
    <collision><geometry><cylinder radius="0.1" length="0.8"/></geometry></collision>
  </link>
  <link name="lid"><collision><geometry><mesh filename="lid.obj" scale="2 2 2"/></geometry></collision></link>
  <link name="knob"/>
  <joint name="hinge" type="revolute"><parent link="base"/><child link="lid"/><limit lower="-1" upper="2"/></joint>
  <joint name="turn" type="continuous"><parent link="lid"/><child link="knob"/><limit lower="0" upper="1"/></joint>
</robot>"""


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    """A model with one of everything."""
    file = tmp_path / "thing.urdf"
    file.write_text(URDF)
    return file


def test_a_record_holds_what_the_file_says(urdf: Path) -> None:
    """Links with shapes and inertia, joints with limits, and the files that are needed."""
    record = read_urdf(urdf)
    base, lid, knob = record.links
    assert record.link_names == ("base", "lid", "knob")
    assert record.base_link == "base"
    assert base.visuals[0].size == (0.5,)
    assert base.visuals[0].color == (1.0, 0.0, 0.0, 1.0)
    assert base.collisions[0].origin == UrdfOrigin((0.1, 0.0, 0.0), (0.0, 0.0, 1.5))
    assert [(shape.kind, shape.size) for shape in base.collisions] == [("box", (0.2, 0.4, 0.6)), ("cylinder", (0.1, 0.8))]
    assert base.inertial is not None
    assert base.inertial.mass == 2.0
    assert base.inertial.inertia == (1.0, 0.1, 0.0, 2.0, 0.0, 3.0)
    assert lid.collisions[0].mesh == urdf.parent / "lid.obj"
    assert (knob.visuals, knob.collisions, knob.inertial) == ((), (), None)
    assert record.joint_limits == {"hinge": (-1.0, 2.0), "turn": UNBOUNDED}
    assert (record.meshes, record.textures) == ((urdf.parent / "lid.obj",), (urdf.parent / "paint.png",))


def test_a_file_is_read_once_until_it_changes(urdf: Path) -> None:
    """The same record comes back, which nobody can change; a file that was written again is read again."""
    first = read_urdf(urdf)
    assert read_urdf(urdf) is first
    with pytest.raises(dataclasses.FrozenInstanceError):
        first.links = ()  # type: ignore[misc]
    urdf.write_text('<robot><link name="other"/></robot>')
    os.utime(urdf, ns=(0, 1))
    assert read_urdf(urdf).link_names == ("other",)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("<robot>", "not valid XML"),
        ('<robot><link name="a"><visual><geometry><box size="1 2"/></geometry></visual></link></robot>', "3 numbers, not 2"),
        ('<robot><link name="a"><visual><geometry><sphere radius="r"/></geometry></visual></link></robot>', "float"),
        ('<robot><link name="a"><visual><geometry><mesh/></geometry></visual></link></robot>', "<mesh> has no filename"),
    ],
)
def test_broken_files_are_named(urdf: Path, text: str, problem: str) -> None:
    """The error says which file is wrong and why."""
    urdf.write_text(text)
    os.utime(urdf, ns=(0, 2))
    with pytest.raises(AssetInvalid, match=rf"thing\.urdf.*{problem}"):
        read_urdf(urdf)


def test_missing_files_are_named_with_who_needs_them(tmp_path: Path) -> None:
    """The error says which file is missing and who asked."""
    with pytest.raises(AssetNotFound, match=r"none\.urdf.* needed by body 'a'"):
        read_urdf(tmp_path / "none.urdf", "body 'a'")
    with pytest.raises(AssetNotFound, match=r"none\.srdf"):
        disabled_pairs(tmp_path / "none.srdf")


def test_a_kinematic_urdf_has_no_shapes(urdf: Path, tmp_path: Path) -> None:
    """Shapes are gone, masses stay, named joints are fixed, and a continuous one has a range."""
    bare = tmp_path / "bare.urdf"
    bare.write_text(kinematic_urdf(urdf, fixed=("hinge",)))
    record = read_urdf(bare)
    assert [(link.visuals, link.collisions) for link in record.links] == [((), ())] * 3
    assert record.links[0].inertial == read_urdf(urdf).links[0].inertial
    assert [joint.kind for joint in record.joints] == ["fixed", "revolute"]


def test_an_srdf_names_pairs_of_links(tmp_path: Path) -> None:
    """The order of the two links does not matter."""
    file = tmp_path / "thing.srdf"
    file.write_text('<robot><disable_collisions link1="a" link2="b" reason="Never"/></robot>')
    assert disabled_pairs(file) == {frozenset(("b", "a"))}


@pytest.mark.parametrize("said", ['<sphere radius="inf"/>', '<box size="1 nan 1"/>', '<cylinder radius="1" length="-inf"/>'])
def test_numbers_are_finite(tmp_path: Path, said: str) -> None:
    """No shape is endless, and none of no number."""
    file = tmp_path / "thing.urdf"
    file.write_text(f'<robot name="a"><link name="a"><visual><geometry>{said}</geometry></visual></link></robot>')
    with pytest.raises(AssetInvalid, match="finite"):
        read_urdf(file)


def test_an_unknown_encoding_is_no_xml(tmp_path: Path) -> None:
    """Whatever the parser calls that."""
    file = tmp_path / "thing.urdf"
    file.write_text('<?xml version="1.0" encoding="no-such"?><robot name="a"/>')
    with pytest.raises(AssetInvalid, match="not valid XML"):
        read_urdf(file)
