"""An arm made of a URDF file: with the shared gripper, with its own, and what is refused."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import trimesh

from rlbench_pin.builder.custom_assets.arm_folder import MISSING, make_arm
from rlbench_pin.builder.custom_assets.arm_urdf import MAX_VISUAL_TRIANGLES, mesh_file, thinned
from rlbench_pin.builder.custom_assets.uploads import UploadRefused
from rlbench_pin.checking import arms
from rlbench_pin.errors import RobotModelError, TaskEnvironmentError
from rlbench_pin.robot import CollisionModel, RobotModel, robot_description
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.urdf import read_urdf
from tests.builder.custom_assets.arms_for_tests import UR5, Z1, cut_out_gripper


@pytest.fixture(scope="module")
def z1(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a Unitree Z1 with the shared gripper in place of its jaw."""
    return make_arm("z1", Z1, tmp_path_factory.mktemp("arms"), flange="link06").file


@pytest.mark.simulation
def test_the_folder_needs_no_other_file(z1: Path) -> None:
    """Meshes lie in it, small ones; its numbers are those of the source."""
    description = robot_description(z1)
    urdf = read_urdf(description.urdf)
    assert urdf.meshes
    assert all(mesh.is_file() and z1.parent in mesh.parents for mesh in urdf.meshes)
    for mesh in urdf.meshes:
        assert mesh.read_text().count("\nf ") <= MAX_VISUAL_TRIANGLES
    limits = RobotModel(description).limits
    assert limits.effort.tolist() == [30.0, 60.0, 30.0, 30.0, 30.0, 30.0]
    assert np.allclose(limits.velocity, np.pi, atol=1e-3)
    assert (limits.lower[1], round(limits.upper[1], 6)) == (0.0, 2.96706)
    assert [line for line in z1.read_text().splitlines() if line.endswith(MISSING)][0].startswith("acceleration")


@pytest.mark.simulation
def test_the_home_points_down_and_is_free(z1: Path) -> None:
    """The gripper goes on the flange, 51 mm along the axis of the last joint."""
    model = RobotModel(robot_description(z1))
    assert not CollisionModel(model).in_collision(model.home)
    assert model.tip_se3(model.home).rotation[2, 2] < -0.999
    assert model.limits.margin(model.home) > 0.2
    mount = next(joint for joint in read_urdf(robot_description(z1).urdf).joints if joint.name == "z1_mount")
    assert mount.origin is not None
    assert np.allclose(mount.origin.xyz, (0.051, 0.0, 0.0), atol=1e-6)


@pytest.mark.simulation
def test_it_passes_the_checks_and_demonstrates(z1: Path) -> None:
    """All of `rlbench-pin arm check`."""
    assert [check for check in arms.check_arm(robot_description(z1), 100) if check.passed is False] == []


@pytest.mark.simulation
@pytest.mark.parametrize(("robot", "hand"), [("panda", "panda_hand"), ("ur5e", "ur5e_hand")])
def test_a_gripper_of_ones_own(tmp_path: Path, robot: str, hand: str) -> None:
    """Fingers that slide, and fingers that turn, of which the second follows the first in the file of the maker."""
    gripper = cut_out_gripper(robot, hand, tmp_path / "gripper.urdf")
    description = make_arm("mine", UR5, tmp_path, gripper=gripper).description
    known = robot_description(robot)
    assert description.finger_links == tuple(f"mine_{link}" for link in known.finger_links)
    assert description.gripper_joints == tuple(f"mine_{joint}" for joint in known.gripper_joints)
    assert abs(description.gripper_open - known.gripper_open) < 1e-3
    assert len(fingers_of(description).followers) == len(fingers_of(known).followers)
    model = RobotModel(description)
    assert arms.gravity_deviation(model, arms.random_configurations(model, 20)) < 1e-6
    grip = arms.grip_of(description)
    assert grip.held
    assert grip.sunk < 0.005


def test_a_joint_beside_the_arm_is_named(tmp_path: Path) -> None:
    """The flange is above the jaw that moves."""
    text = Z1.read_text().replace('<parent link="gripperStator"/>', '<parent link="link05"/>')
    (tmp_path / "z1.urdf").write_text(text.replace("package://example-robot-data/robots/z1_description", str(Z1.parents[1])))
    with pytest.raises(UploadRefused, match="joint 'jointGripper' moves, but is not in the chain to 'link06'.*--flange"):
        make_arm("z1", tmp_path / "z1.urdf", tmp_path / "out", flange="link06")
    assert not (tmp_path / "out").exists()


@pytest.mark.simulation
def test_missing_numbers_are_listed(tmp_path: Path) -> None:
    """A joint without a torque gets a careful one, and a line says so in the file and in the report."""
    root = ET.parse(Z1).getroot()
    for limit in root.iterfind("joint[@name='joint3']/limit"):
        del limit.attrib["effort"]
    for element in [
        e for link in root.iterfind("link") for role in ("visual",) for e in [link, *link.findall(role)] if e.tag == role
    ]:
        next(link for link in root.iterfind("link") if element in list(link)).remove(element)
    ET.ElementTree(root).write(tmp_path / "z1.urdf")
    made = make_arm("bare", tmp_path / "z1.urdf", tmp_path, flange="link06")
    assert any(line.startswith("effort of joint joint3: 50 N m assumed") for line in made.missing)
    assert f"# effort of joint joint3: 50 N m assumed, in <limit> of the URDF: {MISSING}" in made.file.read_text()


@pytest.mark.parametrize(
    ("name", "flange", "error", "says"),
    [
        ("My Arm", "link06", TaskEnvironmentError, "is not a name of an arm"),
        ("panda", "link06", TaskEnvironmentError, "an arm of the catalogue"),
        ("z1", "link99", UploadRefused, "it has no link 'link99'. Links: "),
        ("z1", "world", RobotModelError, "No joint of 'z1.urdf' moves"),
    ],
)
def test_wrong_arguments_write_nothing(tmp_path: Path, name: str, flange: str, error: type[Exception], says: str) -> None:
    """The error says what was possible."""
    with pytest.raises(error, match=says):
        make_arm(name, Z1, tmp_path / "out", flange=flange)
    assert not (tmp_path / "out").exists()


def test_an_existing_folder_stays(tmp_path: Path) -> None:
    """It is named."""
    (tmp_path / "z1").mkdir()
    with pytest.raises(TaskEnvironmentError, match="exists"):
        make_arm("z1", Z1, tmp_path, flange="link06")


def test_meshes_are_found_and_thinned() -> None:
    """`package://` leads from one of the folders above; what is missing is named; a ball keeps its size."""
    assert mesh_file(Z1, "package://any/z1_description/meshes/visual/z1_Link00.dae").is_file()
    with pytest.raises(UploadRefused, match="none.stl"):
        mesh_file(Z1, "package://any/none.stl")
    ball = trimesh.creation.icosphere(5, 0.1)
    small = thinned(ball, 1000)
    assert len(small.faces) <= 1000
    assert np.allclose(small.extents, 0.2, atol=0.01)
