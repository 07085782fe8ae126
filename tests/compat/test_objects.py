"""Names, handles, places and families of scene objects."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pyrep import PyRep
from pyrep.const import ObjectType
from pyrep.errors import ObjectAlreadyRemovedError, UnsupportedCall, WrongObjectTypeError
from pyrep.objects import Dummy, Joint, Object, ProximitySensor, Shape, VisionSensor
from pyrep.objects.cartesian_path import CartesianPath
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.tasks.library.open_drawer import OpenDrawer
from rlbench_pin.tasks.library.reach_target import ReachTarget
from rlbench_pin.tasks.library.take_lid_off_saucepan import TakeLidOffSaucepan


@pytest.fixture(scope="module")
def pyrep() -> Iterator[PyRep]:
    """A launched simulator."""
    simulator = PyRep()
    simulator.launch(headless=True)
    yield simulator
    simulator.shutdown()


@pytest.fixture
def drawer(pyrep: PyRep) -> PyRep:
    """With the chest of drawers."""
    Simulator.current().load(OpenDrawer, ObservationConfig())
    return pyrep


@pytest.fixture
def saucepan(pyrep: PyRep) -> PyRep:
    """With saucepan and lid."""
    Simulator.current().load(TakeLidOffSaucepan, ObservationConfig())
    return pyrep


def test_handles_are_the_numbers_in_masks(drawer: PyRep) -> None:
    """Body, links, room and robot; other objects have numbers of their own, and every number leads back."""
    ids = {name: identifier for identifier, name in Simulator.current().world.masks.items()}
    assert Shape("chest").get_handle() == ids["chest/chest"]
    assert Shape("chest/drawer_top_link").get_handle() == Shape("drawer_top_link").get_handle() == ids["chest/drawer_top_link"]
    assert Shape("diningTable_visible").get_handle() == Shape("table").get_handle() == ids["table"]
    assert Object.get_object("panda_hand").get_handle() == ids["panda/panda_hand"]
    handles = [item.get_handle() for item in drawer.get_objects_in_tree()]
    assert len(set(handles)) == len(handles)
    for item in drawer.get_objects_in_tree():
        again = Object.get_object(item.get_handle())
        assert again == item and type(again) is type(item) and hash(again) == hash(item)
        assert Object.get_object_name(item.get_handle()) == item.get_name()


def test_classes_fit_types(drawer: PyRep) -> None:
    """`get_object` makes the class for the type; the wrong class is refused, an unknown name guessed at."""
    expected = {"chest": Shape, "chest/drawer_top": Joint, "waypoint0": Dummy, "cam_front": VisionSensor, "open_drawer": Dummy}
    assert {name: type(Object.get_object(name)) for name in expected} == expected
    assert Object.get_object_type("chest/drawer_top") == ObjectType.JOINT
    with pytest.raises(WrongObjectTypeError, match="dummy"):
        Shape("waypoint0")
    with pytest.raises(RuntimeError, match="Did you mean 'chest'"):
        Shape("chst")
    assert Object.exists("chest") and not Object.exists("chst")


def test_regions_are_planes_and_sensors_sensors(pyrep: PyRep) -> None:
    """What a task author reads from a scene file."""
    Simulator.current().load(ReachTarget, ObservationConfig())
    box = Shape("boundary").get_bounding_box()
    size = Simulator.current().world.region("boundary").size
    assert np.allclose(np.array(box[1::2]) - box[::2], size)
    goal = ProximitySensor("goal")
    assert goal.get_type() == ObjectType.PROXIMITY_SENSOR
    assert np.allclose(goal.get_position(), Shape("target").get_position())
    workspace = Shape("workspace")
    low_x, high_x, low_y, high_y, low_z, high_z = workspace.get_bounding_box()
    assert low_z == high_z == 0.0
    x, y, z = workspace.get_position()
    assert np.allclose([x + low_x - 0.2, x + high_x + 0.2, y + high_y + 0.2, z], [-0.274, 0.774, 0.655, 0.752])


def test_euler_angles_turn_x_then_y_then_z(saucepan: PyRep) -> None:
    """R = Rx(a) Ry(b) Rz(c), there and back, for any frame."""
    dummy = Dummy.create()
    dummy.set_orientation([0.3, 0.0, 0.0])
    assert np.allclose(dummy.get_quaternion(), [np.sin(0.15), 0.0, 0.0, np.cos(0.15)])
    dummy.set_orientation([0.3, -0.7, 1.9])
    sa, ca, sb, cb, sc, cc = (f(v) for v in (0.3, -0.7, 1.9) for f in (np.sin, np.cos))
    x, y, z = (
        [[1, 0, 0], [0, ca, -sa], [0, sa, ca]],
        [[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]],
        [[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]],
    )
    assert np.allclose(dummy.get_matrix()[:3, :3], np.array(x) @ np.array(y) @ np.array(z))
    assert np.allclose(dummy.get_orientation(), [0.3, -0.7, 1.9])
    for angles in ([0.4, np.pi / 2, 0.9], [0.4, -np.pi / 2, 0.9]):
        dummy.set_orientation(angles)
        before = dummy.get_matrix()
        dummy.set_orientation(dummy.get_orientation())
        assert np.allclose(dummy.get_matrix(), before, atol=1e-6)
    dummy.remove()


def test_places_in_the_frame_of_another_thing(saucepan: PyRep) -> None:
    """Setting what was read changes nothing; matrices and poses agree; bad numbers are refused."""
    lid, pan = Shape("lid"), Shape("saucepan")
    pan.set_orientation([0.0, 0.0, 0.7])
    relative = lid.get_pose(relative_to=pan)
    before = lid.get_pose()
    lid.set_pose([0.3, 0.2, 1.0, 0.0, 0.0, 0.0, 1.0])
    lid.set_pose(relative, relative_to=pan)
    assert np.allclose(lid.get_pose(), before)
    assert np.allclose(pan.get_matrix() @ lid.get_matrix(relative_to=pan), lid.get_matrix())
    lid.set_position([0.0, 0.0, 0.3], relative_to=pan)
    assert np.allclose(lid.get_position(), pan.get_position() + [0.0, 0.0, 0.3])
    assert np.allclose(lid.get_quaternion(), before[3:])
    with pytest.raises(ValueError, match="length"):
        lid.set_pose([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    with pytest.raises(ValueError, match="7 finite"):
        lid.set_pose([0.0, 0.0, np.nan, 0.0, 0.0, 0.0, 1.0])


def test_rotation_is_about_the_own_axes(saucepan: PyRep) -> None:
    """An object that lies on its side turns about its own z."""
    dummy = Dummy.create()
    dummy.set_orientation([np.pi / 2, 0.0, 0.0])
    dummy.rotate([0.0, 0.0, 0.5])
    expected = np.eye(3)[:, [0, 2, 1]] * [1, 1, -1]  # x, z, -y
    axes = dummy.get_matrix()[:3, :3]
    assert np.allclose(axes[:, 2], expected[:, 2]) and np.isclose(axes[0, 0], np.cos(0.5))
    dummy.remove()


def test_families(drawer: PyRep) -> None:
    """Trees follow the scene file, links and joints; an object moves with its parent."""
    chest, base = Shape("chest"), Dummy("open_drawer")
    assert chest.get_parent() == base and base.get_parent() is None
    assert Joint("drawer_top").get_parent() == chest and Shape("drawer_top_link").get_parent() == Joint("drawer_top")
    assert {j.get_name() for j in base.get_objects_in_tree(ObjectType.JOINT)} == {
        f"chest/drawer_{level}" for level in ("bottom", "middle", "top")
    }
    children = chest.get_objects_in_tree(first_generation_only=True)
    assert [type(c) for c in children] == [Joint, Joint, Joint]
    assert base in base.get_objects_in_tree(exclude_base=False) and base not in base.get_objects_in_tree()
    before = chest.get_position()
    base.set_position(base.get_position() + [0.0, 0.1, 0.0])
    assert np.allclose(chest.get_position() - before, [0.0, 0.1, 0.0])


def test_set_parent(saucepan: PyRep) -> None:
    """In place or not, on bodies, dummies and the arm; a circle is refused, and so is a body on the arm."""
    lid, marker = Shape("lid"), Dummy.create()
    marker.set_position([0.4, 0.0, 1.0])
    before = lid.get_pose()
    lid.set_parent(marker)
    assert np.allclose(lid.get_pose(), before) and lid.get_parent() == marker
    marker.set_position([0.4, 0.1, 1.0])
    assert np.allclose(lid.get_position(), before[:3] + [0.0, 0.1, 0.0])
    with pytest.raises(RlbenchPinError, match="is its descendant"):
        marker.set_parent(lid)
    lid.set_parent(None)
    marker.set_position([0.4, 0.3, 1.0])
    assert np.allclose(lid.get_position(), before[:3] + [0.0, 0.1, 0.0])
    marker.set_parent(lid, keep_in_place=False)
    assert np.allclose(marker.get_position(relative_to=lid), [0.4, 0.3, 1.0])
    with pytest.raises(UnsupportedCall, match="gripper.grasp"):
        lid.set_parent(Object.get_object("Panda_tip"))
    marker.set_parent(Dummy("Panda_tip"), keep_in_place=False)
    marker.set_pose([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], relative_to=Dummy("Panda_tip"))
    Joint("Panda_joint1").set_joint_position(0.5)
    assert np.allclose(marker.get_pose(), Dummy("Panda_tip").get_pose())
    Joint("Panda_joint1").set_joint_position(0.0)
    marker.remove()


def test_the_fixed_scene(saucepan: PyRep) -> None:
    """Names that programs fetch; what cannot be moved or removed says so."""
    names = ["workspace", "cam_cinematic_placeholder", "cam_cinematic_base", "Floor", "Roof", "diningTable_visible", "Panda"]
    cameras = [f"cam_{name}" for name in ("over_shoulder_left", "over_shoulder_right", "overhead", "wrist", "front")]
    walls = [f"Wall{k}" for k in range(1, 5)]
    for name in (*names, "Panda_tip", "Panda_gripper", *walls, *cameras, *(f"{c}_mask" for c in cameras)):
        assert Object.get_object(name).get_name() == name
    for call in (lambda: Shape("lid").remove(), lambda: Dummy("waypoint0").remove()):
        with pytest.raises(RlbenchPinError, match="scene file"):
            call()
    with pytest.raises(UnsupportedCall, match="set_joint_positions"):
        Dummy("Panda_tip").set_position([0.3, 0.0, 1.0])
    with pytest.raises(UnsupportedCall, match="URDF"):
        saucepan.import_model("lid.ttm")


def test_names_can_be_changed_and_removed_things_are_gone(saucepan: PyRep) -> None:
    """The new name finds it; a removed object is never mistaken for another one."""
    first, second = Dummy.create(), Dummy.create()
    assert first.get_name() != second.get_name()
    second.set_name("marker")
    assert Dummy("marker") == second and Object.get_object("marker").get_name() == "marker"
    second.remove()
    assert not second.still_exists() and not Object.exists("marker") and first.still_exists()
    with pytest.raises(ObjectAlreadyRemovedError):
        second.get_pose()
    first.remove()


def test_what_hung_on_a_removed_thing_stays(saucepan: PyRep) -> None:
    """Where it was, on the world."""
    marker, other, lid = Dummy.create(), Dummy.create(), Shape("lid")
    marker.set_position([0.3, 0.1, 1.0])
    other.set_position([0.3, 0.2, 1.0])
    other.set_parent(marker)
    lid.set_parent(marker)
    before = lid.get_pose()
    marker.remove()
    assert other.get_parent() is None and np.allclose(other.get_position(), [0.3, 0.2, 1.0])
    assert lid.get_parent() is None and np.allclose(lid.get_pose(), before)
    other.remove()


def test_cartesian_paths(saucepan: PyRep) -> None:
    """Half of the length of a corner lies in its corner; points hang on the path."""
    path = CartesianPath.create()
    path.insert_control_points([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.2, 0.0, 1.0, 0.0, 0.0, 0.4], [0.2, 0.2, 1.0, 0.0, 0.0, 0.8]])
    for share, position, yaw in (
        (0.0, [0, 0, 1], 0.0),
        (0.25, [0.1, 0, 1], 0.2),
        (0.5, [0.2, 0, 1], 0.4),
        (1.0, [0.2, 0.2, 1], 0.8),
    ):
        place, angles = path.get_pose_on_path(share)
        assert np.allclose(place, position) and np.allclose(angles, [0.0, 0.0, yaw])
    path.set_position([0.0, 0.0, 0.5])
    assert np.allclose(path.get_pose_on_path(1.0)[0], [0.2, 0.2, 1.5])
    path.remove()
    assert not path.still_exists()


def test_remembered_places(drawer: PyRep) -> None:
    """A configuration tree brings poses and joints back."""
    base, joint = Dummy("open_drawer"), Joint("drawer_top")
    remembered = base.get_configuration_tree()
    before = Shape("chest").get_pose()
    joint.set_joint_position(0.1)
    base.set_position([0.4, 0.1, 0.8])
    drawer.set_configuration_tree(remembered)
    assert np.allclose(Shape("chest").get_pose(), before) and np.isclose(joint.get_joint_position(), 0.0)
