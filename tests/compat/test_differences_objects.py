"""What differs in objects of scenes under the known names; rows of `docs/compatibility.md`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pyrep import PyRep
from pyrep.const import JointMode, PrimitiveShape, TextureMappingMode
from pyrep.errors import UnsupportedCall
from pyrep.objects import Camera, CartesianPath, Dummy, ForceSensor, Joint, Shape, VisionSensor
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim import look_at
from rlbench_pin.tasks.library.open_drawer import OpenDrawer
from rlbench_pin.tasks.library.take_lid_off_saucepan import TakeLidOffSaucepan

TABLE = 0.752
TEXTURES = Path(__file__).parents[2] / "rlbench_pin" / "assets" / "textures"
CORNERS = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (0.0, 0.1)]
SIDES = [
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
]  # fmt: skip
"""An open box: four walls and a floor without thickness."""


@pytest.fixture(scope="module")
def launched() -> Iterator[PyRep]:
    """A launched simulator."""
    simulator = PyRep()
    simulator.launch(headless=True)
    yield simulator
    simulator.shutdown()


@pytest.fixture
def pyrep(launched: PyRep) -> PyRep:
    """With saucepan and lid, running."""
    Simulator.current().load(TakeLidOffSaucepan, ObservationConfig())
    launched.start()
    return launched


@pytest.fixture
def drawer(launched: PyRep) -> PyRep:
    """With the chest of drawers, running."""
    Simulator.current().load(OpenDrawer, ObservationConfig())
    launched.start()
    return launched


def steps(pyrep: PyRep, count: int) -> None:
    """Let time pass."""
    for _ in range(count):
        pyrep.step()


def cube(position: list[float], **settings: Any) -> Shape:
    """Make a cube of 5 cm."""
    return Shape.create(PrimitiveShape.CUBOID, [0.05] * 3, mass=0.1, position=position, **settings)


def test_parents_that_physics_moves(pyrep: PyRep) -> None:
    """When a cube falls, another one on it stays in the air, and a dummy falls with it; moved by a call, both come along."""
    parent, child, mark = cube([0.3, 0.3, 1.2]), cube([0.3, 0.3, 1.4], static=True), Dummy.create()
    mark.set_position([0.3, 0.3, 1.3])
    for item in (child, mark):
        item.set_parent(parent)
    steps(pyrep, 4)
    assert parent.get_position()[2] < 1.1 and child.get_position()[2] == pytest.approx(1.4)
    assert mark.get_position()[2] - parent.get_position()[2] == pytest.approx(0.1, abs=1e-3)
    before = child.get_position()
    parent.set_position(parent.get_position() + [0.0, 0.0, 0.1])
    assert child.get_position() - before == pytest.approx([0.0, 0.0, 0.1], abs=1e-6)


def test_bodies_do_not_hang_on_the_arm(pyrep: PyRep) -> None:
    """The error names `grasp`; a camera may."""
    camera = VisionSensor.create([16, 16])
    camera.set_parent(Dummy("Panda_tip"))
    assert camera.get_parent() == Dummy("Panda_tip")
    with pytest.raises(UnsupportedCall, match="gripper.grasp"):
        cube([0.3, 0.3, 1.2]).set_parent(Dummy("Panda_tip"))
    camera.remove()


def test_meshes_are_solid_as_their_hulls(pyrep: PyRep) -> None:
    """A ball that falls into an open box rests on its rim, where the hull is shut."""
    box = Shape.create_mesh(np.add(CORNERS, [0.4, 0.3, TABLE]).ravel().tolist(), np.ravel(SIDES).tolist())
    ball = Shape.create(PrimitiveShape.SPHERE, [0.04] * 3, position=[0.4, 0.3, TABLE + 0.15])
    steps(pyrep, 15)
    assert ball.get_position()[2] == pytest.approx(TABLE + 0.12, abs=5e-3)
    assert not box.is_dynamic()
    box.set_dynamic(True)
    assert box.is_dynamic()


def test_half_transparent_shapes_are_blended(pyrep: PyRep) -> None:
    """Half of the colour is that of what is behind; 1 hides."""
    shape = Shape.create(PrimitiveShape.CUBOID, [0.2] * 3, static=True, position=[0.3, 0.3, 1.2], color=[1.0, 0.0, 0.0])
    camera = VisionSensor.create([32, 32], view_angle=30.0)
    camera.set_pose(look_at((0.3, 1.0, 1.2), (0.3, 0.3, 1.2)))
    images = []
    for transparency in (0.0, 0.5, 1.0):
        shape.set_transparency(transparency)
        assert shape.get_transparency() == pytest.approx(transparency)
        images.append(camera.capture_rgb())
    opaque, half, hidden = (image[16, 16] for image in images)
    assert np.allclose(half, 0.5 * (opaque + hidden), atol=0.03) and not np.allclose(opaque, hidden, atol=0.1)
    camera.remove()


def test_planes_are_not_drawn(pyrep: PyRep) -> None:
    """The workspace is a shape in the middle of the table; the image from above does not change with its colour."""
    camera, plane = VisionSensor("cam_overhead"), Shape("workspace")
    before = camera.capture_rgb()
    plane.set_color([0.0, 1.0, 0.0])
    assert plane.get_color() == [0.0, 1.0, 0.0] and np.array_equal(camera.capture_rgb(), before)


def test_textures_have_one_mapping(pyrep: PyRep) -> None:
    """Every mode gives the same image; a texture is not read back."""
    texture = pyrep.create_texture(str(next(TEXTURES.glob("*.png"))))[1]
    shape = Shape.create(PrimitiveShape.CUBOID, [0.2] * 3, static=True, position=[0.3, 0.3, 1.2])
    camera = VisionSensor.create([32, 32], view_angle=30.0)
    camera.set_pose(look_at((0.3, 1.0, 1.3), (0.3, 0.3, 1.2)))
    plain, images = camera.capture_rgb(), []
    for mode in (TextureMappingMode.PLANE, TextureMappingMode.SPHERE):
        shape.set_texture(texture, mode)
        images.append(camera.capture_rgb())
    assert np.array_equal(*images) and not np.array_equal(plain, images[0])
    with pytest.raises(UnsupportedCall, match="create_texture"):
        shape.get_texture()
    camera.remove()


REFUSED: list[tuple[str, Callable[[PyRep, Shape], object]]] = [
    ("group_objects", lambda pyrep, shape: pyrep.group_objects([shape])),
    ("merge_objects", lambda pyrep, shape: pyrep.merge_objects([shape])),
    ("scale_object", lambda pyrep, shape: shape.scale_object(2.0, 2.0, 2.0)),
    ("save_model", lambda pyrep, shape: shape.save_model("lid.ttm")),
    ("copy", lambda pyrep, shape: Joint("Panda_joint1").copy()),
    ("Camera", lambda pyrep, shape: Camera("DefaultCamera")),
    ("set_entity_to_render", lambda pyrep, shape: VisionSensor("cam_front").set_entity_to_render(shape)),
    ("joint mode", lambda pyrep, shape: Joint("Panda_joint1").set_joint_mode(JointMode.IK)),
]


@pytest.mark.parametrize(("words", "call"), REFUSED, ids=[words for words, _ in REFUSED])
def test_what_cannot_be_is_refused(pyrep: PyRep, words: str, call: Callable[[PyRep, Shape], object]) -> None:
    """As a `NotImplementedError` that names the call."""
    with pytest.raises(NotImplementedError, match=words):
        call(pyrep, Shape("lid"))


def test_bodies_with_joints_stay_as_loaded(drawer: PyRep) -> None:
    """The chest is welded to the table and cannot be let go; the links share that."""
    with pytest.raises(RlbenchPinError, match="in the scene file"):
        Shape("chest").set_dynamic(True)
    with pytest.raises(UnsupportedCall):
        Shape("drawer_top_link").set_dynamic(True)


def test_everything_with_children_is_a_model(drawer: PyRep) -> None:
    """Until a program says otherwise, and its tree stays as it is."""
    chest, handle = Shape("chest"), Dummy("waypoint0")
    assert chest.is_model() and not handle.is_model()
    tree = chest.get_objects_in_tree()
    chest.set_model(False)
    handle.set_model(True)
    assert not chest.is_model() and handle.is_model()
    assert chest.get_objects_in_tree() == tree


def test_joints_of_objects_have_no_force(drawer: PyRep) -> None:
    """Their motors hold or drive to a position; PASSIVE lets go."""
    joint = Joint("drawer_top")
    joint.set_joint_target_position(0.1)
    joint.set_joint_mode(JointMode.PASSIVE)
    assert not joint.is_motor_enabled() and joint.get_joint_mode() == JointMode.FORCE
    with pytest.raises(UnsupportedCall, match="friction"):
        joint.set_joint_force(10.0)


def test_force_sensors_are_named_after_what_is_pressed(pyrep: PyRep) -> None:
    """What lies on the table presses with its weight; in the air nothing does."""
    shape = cube([0.3, 0.3, TABLE + 0.0255])
    steps(pyrep, 20)
    sensor = ForceSensor(shape.get_name())
    assert sensor.read()[0] == pytest.approx([0.0, 0.0, 0.1 * 9.81], abs=0.05)
    shape.set_position([0.3, 0.3, 1.5])
    steps(pyrep, 1)
    assert not np.any(sensor.read()[0])


def test_images_show_the_present_instant(pyrep: PyRep) -> None:
    """With explicit handling and without a call of `handle_explicitly`."""
    camera = VisionSensor.create([16, 16], explicit_handling=True, view_angle=30.0)
    camera.set_pose(look_at((0.3, 1.0, 1.2), (0.3, 0.3, 1.2)))
    before = camera.capture_depth(in_meters=True)[8, 8]
    Shape.create(PrimitiveShape.CUBOID, [0.2] * 3, static=True, position=[0.3, 0.3, 1.2])
    assert camera.capture_depth(in_meters=True)[8, 8] < before - 0.1
    camera.remove()


def test_orientations_of_paths_are_those_of_the_points(pyrep: PyRep) -> None:
    """`automatic_orientation` does not turn them along the path."""
    found = []
    for automatic in (True, False):
        path = CartesianPath.create(automatic_orientation=automatic, keep_x_up=automatic)
        path.insert_control_points([[0.0, 0.0, 1.0, 0.1, 0.2, 0.3], [0.2, 0.1, 1.0, 0.1, 0.2, 0.3]])
        found.append(path.get_pose_on_path(0.5))
        path.remove()
    assert np.allclose(found[0][1], [0.1, 0.2, 0.3]) and np.allclose(found[0][1], found[1][1])


def test_a_stopped_simulation_stays_as_it_is(pyrep: PyRep) -> None:
    """The lid is where it fell; a step runs the task's own step too."""
    runtime, calls = Simulator.current().runtime, []
    runtime.register_step_callback(lambda: calls.append(1))
    Shape("lid").set_position([0.3, 0.3, 1.2])
    steps(pyrep, 3)
    fallen = Shape("lid").get_position()
    pyrep.stop()
    assert np.array_equal(Shape("lid").get_position(), fallen) and fallen[2] < 1.19 and len(calls) == 3
    pyrep.start()
    assert np.array_equal(Shape("lid").get_position(), fallen)
