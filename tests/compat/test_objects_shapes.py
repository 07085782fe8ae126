"""Shapes: making them, how they move, touch and look, and how long they stay."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pyrep import PyRep
from pyrep.const import PrimitiveShape
from pyrep.errors import UnsupportedCall
from pyrep.objects.force_sensor import ForceSensor
from pyrep.objects.joint import Joint
from pyrep.objects.shape import Shape
from pyrep.objects.vision_sensor import VisionSensor
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim import look_at
from rlbench_pin.tasks.library.open_drawer import OpenDrawer
from rlbench_pin.tasks.library.take_lid_off_saucepan import TakeLidOffSaucepan

TABLE = 0.752


@pytest.fixture
def pyrep() -> Iterator[PyRep]:
    """A running simulation of the saucepan."""
    simulator = PyRep()
    simulator.launch(headless=True)
    Simulator.current().load(TakeLidOffSaucepan, ObservationConfig())
    simulator.start()
    yield simulator
    simulator.shutdown()


def steps(pyrep: PyRep, count: int) -> None:
    """Let time pass."""
    for _ in range(count):
        pyrep.step()


@pytest.mark.parametrize("kind", list(PrimitiveShape))
@pytest.mark.parametrize("size", [(0.06, 0.06, 0.06), (0.08, 0.08, 0.05), (0.05, 0.09, 0.07)])
def test_primitives_have_their_size(pyrep: PyRep, kind: PrimitiveShape, size: tuple[float, float, float]) -> None:
    """Round or not; they fall to the table and rest on it."""
    shape = Shape.create(kind, list(size), mass=0.2, position=[0.3, 0.3, TABLE + 0.5 * size[2] + 0.02])
    box = np.array(shape.get_bounding_box())
    assert np.allclose(box[1::2] - box[::2], size, atol=2e-3) and np.allclose(box[1::2] + box[::2], 0.0, atol=1e-6)
    assert np.isclose(shape.get_mass(), 0.2)
    steps(pyrep, 30)
    lowest = shape.get_position()[2]
    assert shape.get_position()[2] < TABLE + 0.5 * max(size) + 0.005 and lowest > TABLE + 0.4 * min(size)
    assert any(Shape("table").get_handle() in c["contact_handles"] for c in shape.get_contact())


def test_wrong_sizes_are_refused(pyrep: PyRep) -> None:
    """Before anything is made."""
    for size, mass in (([0.1, 0.1], 1.0), ([0.1, 0.0, 0.1], 1.0), ([0.1] * 3, 0.0), ([0.1, np.nan, 0.1], 1.0)):
        with pytest.raises(ValueError):
            Shape.create(PrimitiveShape.CUBOID, size, mass)


def test_static_and_dynamic(pyrep: PyRep) -> None:
    """What is held stays in the air and comes to rest; let go it falls; a reset brings back how it began."""
    shape = Shape.create(PrimitiveShape.CUBOID, [0.05] * 3, static=True, position=[0.3, 0.3, 1.2])
    other = Shape.create(PrimitiveShape.SPHERE, [0.05] * 3, position=[0.3, 0.3, 1.3])
    steps(pyrep, 20)
    assert not shape.is_dynamic() and np.allclose(shape.get_position(), [0.3, 0.3, 1.2])
    assert other.get_position()[2] > 1.24
    shape.set_dynamic(True)
    steps(pyrep, 5)
    assert shape.get_position()[2] < 1.0
    shape.set_dynamic(False)
    held = shape.get_position()
    steps(pyrep, 5)
    assert np.allclose(shape.get_position(), held)
    lid = Shape("lid")
    lid.set_dynamic(False)
    lid.set_position([0.3, -0.3, 1.2])
    steps(pyrep, 5)
    assert np.allclose(lid.get_position(), [0.3, -0.3, 1.2])
    Simulator.current().world.build_again()
    assert lid.is_dynamic() and not shape.still_exists()
    with pytest.raises(UnsupportedCall):
        Shape("Floor").set_dynamic(True)


def test_a_held_body_is_saved(pyrep: PyRep) -> None:
    """In memory and as arrays."""
    world, lid = Simulator.current().world, Shape("lid")
    lid.set_dynamic(False)
    lid.set_position([0.3, -0.3, 1.2])
    saved, arrays = world.save(), world.arrays()
    for back in (lambda: world.restore(saved), lambda: world.set_arrays(arrays)):
        world.build_again()
        assert lid.is_dynamic()
        back()
        steps(pyrep, 3)
        assert not lid.is_dynamic() and np.allclose(lid.get_position(), [0.3, -0.3, 1.2])


def test_mass_and_friction(pyrep: PyRep) -> None:
    """A heavier body presses more; a slippery one slides."""
    shape = Shape.create(PrimitiveShape.CUBOID, [0.1, 0.1, 0.05], mass=0.2, position=[0.3, 0.3, TABLE + 0.026])
    steps(pyrep, 20)
    force, torque = ForceSensor(shape.get_name()).read()
    assert np.allclose(force, [0.0, 0.0, 0.2 * 9.81], atol=0.05) and np.abs(torque).max() < 0.02
    shape.set_mass(0.8)
    steps(pyrep, 10)
    assert np.isclose(ForceSensor(shape.get_name()).read()[0][2], 0.8 * 9.81, atol=0.1)
    shape.compute_mass_and_inertia(1000.0)
    assert np.isclose(shape.get_mass(), 0.5)
    distances = []
    for friction in (0.8, 0.0):
        shape.set_position([0.2, 0.3, TABLE + 0.026])
        shape.set_bullet_friction(friction)
        assert np.isclose(shape.get_bullet_friction(), friction)
        shape.set_velocity([0.5, 0.0, 0.0])
        steps(pyrep, 10)
        distances.append(shape.get_position()[0] - 0.2)
    assert distances[0] < 0.1 < 0.2 < distances[1]


def test_forces_push_and_turn(pyrep: PyRep) -> None:
    """A force of one step changes the momentum by force times step; off the centre it turns as well; it can carry the weight."""
    shape = Shape.create(
        PrimitiveShape.CUBOID, [0.1, 0.1, 0.1], mass=0.5, position=[0.3, 0.3, 1.2], orientation=[0, 0, np.pi / 2]
    )
    shape.add_force([0.0, 0.0, 0.0], [2.0, 0.0, 0.0])
    linear, angular = shape.get_velocity()
    assert np.allclose(linear, [0.0, 2.0 * 0.05 / 0.5, 0.0], atol=1e-6) and np.allclose(angular, 0.0, atol=1e-6)
    shape.set_velocity([0.0, 0.0, 0.0])
    shape.add_force(np.array([0.05, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    inertia = 0.5 * (0.1**2 + 0.1**2) / 12
    assert np.allclose(shape.get_velocity()[1], [0.0, 0.0, 0.05 * 0.05 / inertia], rtol=1e-6, atol=1e-9)
    shape.set_velocity([0.0, 0.0, 0.0])
    for _ in range(10):
        shape.add_force_and_torque([0.0, 0.0, 0.5 * 9.81], [0.0, 0.0, 0.0])
        pyrep.step()
    assert np.isclose(shape.get_position()[2], 1.2, atol=0.15) and np.abs(shape.get_velocity()[0][2]) < 0.05
    shape.set_dynamic(False)
    shape.add_force([0.0, 0.0, 0.0], [9.0, 0.0, 0.0])
    pyrep.step()
    assert np.abs(shape.get_velocity()[0]).max() < 1e-6
    with pytest.raises(ValueError, match="3 finite"):
        shape.add_force([0.0, 0.0], [1.0, 0.0, 0.0])
    with pytest.raises(UnsupportedCall):
        Shape("Panda_link3" if Shape.exists("Panda_link3") else "panda_link3").add_force([0.0] * 3, [1.0, 0.0, 0.0])


def test_respondable_and_collidable(pyrep: PyRep) -> None:
    """One passes through the table, the other is only left out of checks."""
    ghost = Shape.create(PrimitiveShape.CUBOID, [0.05] * 3, respondable=False, position=[0.3, 0.3, 0.9])
    shape = Shape.create(PrimitiveShape.CUBOID, [0.05] * 3, position=[0.3, -0.3, TABLE + 0.024])
    assert shape.check_collision() and shape.check_collision(Shape("table"))
    shape.set_collidable(False)
    assert not shape.check_collision()
    steps(pyrep, 15)
    assert ghost.get_position()[2] < 0.7 and not ghost.is_respondable()
    assert shape.get_position()[2] > TABLE + 0.02
    assert not shape.is_model()
    shape.set_model(True)
    assert shape.is_model()


def test_distance_and_velocity(pyrep: PyRep) -> None:
    """Between surfaces, 0 where they touch; velocities are those of physics."""
    first = Shape.create(PrimitiveShape.CUBOID, [0.1] * 3, static=True, position=[0.2, 0.3, 1.2])
    second = Shape.create(PrimitiveShape.SPHERE, [0.1] * 3, position=[0.5, 0.3, 1.2])
    assert np.isclose(first.check_distance(second), 0.2, atol=1e-6)
    second.set_velocity([0.1, 0.0, 0.3], [0.0, 0.0, 2.0])
    linear, angular = second.get_velocity()
    assert np.allclose(linear, [0.1, 0.0, 0.3]) and np.allclose(angular, [0.0, 0.0, 2.0])
    second.set_pose(second.get_pose(), reset_dynamics=False)
    assert np.allclose(second.get_velocity()[0], linear)
    second.set_position([0.25, 0.3, 1.2])
    assert first.check_distance(second) == 0.0 and np.allclose(second.get_velocity()[0], 0.0)


def test_meshes_keep_their_place(pyrep: PyRep, tmp_path: Path) -> None:
    """A tetrahedron from numbers and from a file: corners stay, the frame is in the middle of the box."""
    corners = np.array([[0.2, 0.2, 1.0], [0.4, 0.2, 1.0], [0.2, 0.4, 1.0], [0.2, 0.2, 1.2]])
    triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    file = tmp_path / "corner.obj"
    file.write_text(
        "".join("v {} {} {}\n".format(*c) for c in corners) + "".join("f {} {} {}\n".format(*np.add(t, 1)) for t in triangles)
    )
    for shape in (Shape.create_mesh(corners.ravel().tolist(), np.ravel(triangles).tolist()), Shape.import_mesh(str(file))):
        assert np.allclose(shape.get_position(), [0.3, 0.3, 1.1]) and not shape.is_dynamic()
        vertices, faces, normals = shape.get_mesh_data()
        assert {tuple(v) for v in np.round(vertices + shape.get_position(), 6)} == {tuple(c) for c in corners}
        assert faces.shape == (4, 3) and normals.shape == (12, 3)
        shape.remove()
    with pytest.raises(RlbenchPinError, match="plane"):
        Shape.create_mesh([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0], [0, 1, 2, 1, 3, 2])
    with pytest.raises(RlbenchPinError, match="other simulator|another simulator"):
        Shape.import_mesh("lid.ttm")


def test_colours(pyrep: PyRep) -> None:
    """Bodies, links and the room; hidden objects leave the image and the mask."""
    camera = VisionSensor.create([64, 64], view_angle=30.0)
    camera.set_pose(look_at((0.3, 1.0, 1.2), (0.3, 0.3, 1.2)))
    eye = VisionSensor.create([64, 64], view_angle=30.0, position=[0, 0, 0])
    eye.set_pose(camera.get_pose())
    shape = Shape.create(PrimitiveShape.CUBOID, [0.2] * 3, static=True, position=[0.3, 0.3, 1.2], color=[1.0, 0.0, 0.0])
    red, green, blue = camera.capture_rgb()[32, 32]
    assert red > 0.3 and max(green, blue) < 0.2
    shape.set_color([0.0, 0.0, 1.0])
    assert shape.get_color() == [0.0, 0.0, 1.0] and camera.capture_rgb()[32, 32, 2] > 0.3
    near = camera.capture_depth(in_meters=True)[32, 32]
    for hide, show in (
        (lambda: shape.set_renderable(False), lambda: shape.set_renderable(True)),
        (lambda: shape.set_transparency(1.0), lambda: shape.set_transparency(0.0)),
    ):
        hide()
        assert camera.capture_depth(in_meters=True)[32, 32] > near + 0.5
        show()
        assert np.isclose(camera.capture_depth(in_meters=True)[32, 32], near)
    assert shape.get_color() == [0.0, 0.0, 1.0]


def test_links_of_a_body(pyrep: PyRep) -> None:
    """A link has a colour and a box of its own; joints move it, `set_position` does not."""
    Simulator.current().load(OpenDrawer, ObservationConfig())
    chest, link = Shape("chest"), Shape("drawer_top_link")
    link.set_color([0.0, 1.0, 0.0])
    assert link.get_color() == [0.0, 1.0, 0.0] and chest.get_color() != [0.0, 1.0, 0.0]
    before = link.get_position()
    Joint("chest/drawer_top").set_joint_position(0.15)
    assert np.isclose(np.linalg.norm(link.get_position() - before), 0.15)
    with pytest.raises(UnsupportedCall, match="joint"):
        link.set_position([0.0, 0.0, 1.0])
    alone, whole = np.array(chest.get_bounding_box()), np.array(chest.get_model_bounding_box())
    assert whole[0] < alone[0] - 0.1 and np.all(whole[1::2] >= alone[1::2])


def test_copies(pyrep: PyRep) -> None:
    """Another body at the same place, with a name and a handle of its own."""
    lid = Shape("lid")
    copy = lid.copy()
    assert copy != lid and np.allclose(copy.get_pose(), lid.get_pose()) and copy.get_name() == "lid0"
    assert copy.get_bounding_box() == lid.get_bounding_box() and copy.get_handle() != lid.get_handle()
    copy.remove()
    assert not Shape.exists("lid0")


def test_how_long_shapes_stay(pyrep: PyRep) -> None:
    """Through resets when made before the first step, through tasks when made without one, else until the next reset."""
    simulator = Simulator.current()
    simulator.unload()
    permanent = Shape.create(PrimitiveShape.CUBOID, [0.05] * 3, static=True, position=[0.1, 0.4, 1.0], color=[0.0, 1.0, 0.0])
    camera = VisionSensor.create([32, 32], position=[0.0, 0.0, 2.0])
    simulator.load(TakeLidOffSaucepan, ObservationConfig())
    early = Shape.create(PrimitiveShape.CUBOID, [0.05] * 3, position=[0.3, 0.3, TABLE + 0.026])
    steps(pyrep, 5)
    late = Shape.create(PrimitiveShape.CUBOID, [0.05] * 3, position=[0.3, -0.3, TABLE + 0.026])
    early.set_position([0.4, 0.3, 0.9])
    handle = early.get_handle()
    simulator.world.build_again()
    assert early.still_exists() and early.get_handle() == handle and np.allclose(early.get_position()[:2], [0.3, 0.3], atol=1e-3)
    assert not late.still_exists() and permanent.still_exists() and permanent.get_color() == [0.0, 1.0, 0.0]
    assert np.allclose(permanent.get_position(), [0.1, 0.4, 1.0]) and camera.still_exists()
    simulator.load(OpenDrawer, ObservationConfig())
    assert not early.still_exists() and permanent.still_exists() and permanent.get_name() == "Cuboid"
