"""The gripper closes on things, holds them, and lets them go."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import InvalidActionError
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.spatial import above_table, relative, rotation_distance
from tests.sim.support import ABOVE, AROUND, UPRIGHT, build, close_on_cube, cube, cube_scene, digest, fingers, move, steps

RAISED = np.array([0.0, 0.534744, 0.0, -2.118635, 0.0, 2.65338, 0.785398])
"""As `AROUND`, 0.052 m above the table: around the glass of a bulb that stands there."""


@pytest.fixture
def world():
    """A world with one cube that may be grasped."""
    with build() as world:
        world.body("cube").graspable = True
        yield world


def in_hand(world) -> np.ndarray:
    """Pose of the cube in the gripper."""
    return relative(world.body("cube").pose, world.robot.link_pose("panda_hand"))


def test_fingers_travel_at_the_given_speed(world):
    """A stroke of 0.04 m takes 20 ticks at 0.04 m/s and 4 at 0.2 m/s, and ends where it should."""
    slow = fingers(world, 0.0, 0.04)
    assert 20 <= slow <= 22
    np.testing.assert_allclose(world.gripper.opening, 0.0, atol=0.01)
    fast = fingers(world, 1.0, 0.2)
    assert 4 <= fast <= 6
    np.testing.assert_allclose(world.gripper.opening, 1.0, atol=0.01)
    assert world.gripper.is_open


def test_fingers_stop_at_an_object(world):
    """Closing on a cube stalls at its width, both fingers alike, with a force on each pad."""
    close_on_cube(world)
    np.testing.assert_allclose(world.robot.fingers, 0.025, atol=5e-4)
    left, right = world.robot.touch_forces().reshape(2, 3)
    assert 5.0 < left[1] < 45.0
    assert -45.0 < right[1] < -5.0
    assert world.gripper.between_fingers() == ("cube",)


def test_an_off_centre_object_is_moved_to_the_middle():
    """The fingers stay symmetric: a cube 12 mm off is pushed between them."""
    with build(cube_scene(cube("cube", 0.3, 0.012))) as world:
        close_on_cube(world)
        assert abs(world.body("cube").position[1]) < 1.5e-3
        assert abs(np.diff(world.robot.fingers)[0]) < 1.5e-3


def test_only_graspable_bodies_that_both_fingers_touch_count(world):
    """Not one that is not declared graspable, not one that is elsewhere, and not one that no finger or one alone touches."""
    world.robot.reset_configuration(ABOVE)
    assert world.gripper.between_fingers() == ()
    move(world, AROUND)
    fingers(world, 0.75)  # 10 mm wider than the cube
    assert world.gripper.reaches_between_fingers("cube")
    assert world.gripper.between_fingers() == ()
    beside = world.body("cube").pose
    beside[1] += world.robot.fingers[0] - 0.025
    world.body("cube").set_pose(beside)
    world.step()
    assert world.robot.touching() == ("cube",)
    assert world.gripper.between_fingers() == ()
    close_on_cube(world)
    assert world.gripper.between_fingers() == ("cube",)
    world.body("cube").graspable = False
    assert world.gripper.between_fingers() == ()
    assert world.gripper.reaches_between_fingers("cube")
    world.robot.reset_configuration(ABOVE)
    assert not world.gripper.reaches_between_fingers("cube")


@pytest.mark.parametrize(("links", "held"), [((), True), (("glass",), True), (("thread",), False)])
def test_a_body_may_be_held_by_some_links_alone(links, held):
    """Fingers on the glass of a bulb hold it, unless it may be held by its thread alone."""
    place = (0.3, 0.0, above_table(0.052), *UPRIGHT)
    asset = "objects/light_bulb/light_bulb.urdf"
    with build(cube_scene(BodySpec(name="bulb", asset=asset, parent="world", pose=place))) as world:
        world.robot.reset_configuration(RAISED)
        bulb = world.body("bulb")
        bulb.graspable, bulb.grasp_links = True, links
        fingers(world, 0.0)
        assert world.gripper.between_fingers() == (("bulb",) if held else ())


def test_an_attached_body_neither_sags_nor_shakes(world):
    """Lifted and swung, the cube stays within 0.2 mm of its place in the gripper; at rest within 5 um, and it does not move."""
    close_on_cube(world)
    assert world.gripper.grasp("cube")
    assert not world.gripper.grasp("cube")
    assert world.gripper.grasped == ("cube",)
    start, poses = in_hand(world), []
    world.on_physics.append(lambda: poses.append(in_hand(world)))
    move(world, ABOVE)
    move(world, ABOVE + [0.8, 0, 0, 0, 0, 0, 0.5])
    assert max(np.abs(p - start)[:3].max() for p in poses) < 2e-4
    assert max(rotation_distance(p, start) for p in poses) < 2e-3
    steps(world, 20)
    assert np.abs(in_hand(world) - start)[:3].max() < 5e-6
    assert np.abs(world.body("cube").velocity).max() < 1e-6
    assert np.abs(world.robot.joint_velocities).max() < 0.01


def test_release_lets_go_without_a_kick(world):
    """Put down and released the cube stays; it is not pushed, and can be grasped again."""
    close_on_cube(world)
    world.gripper.grasp("cube")
    move(world, ABOVE)
    move(world, AROUND)
    before = world.body("cube").pose
    world.gripper.release()
    assert world.gripper.grasped == ()
    fingers(world, 1.0)
    assert np.abs(world.body("cube").pose - before)[:3].max() < 1e-3
    assert world.body("cube").position[2] == pytest.approx(above_table(0.025), abs=1e-3)
    fingers(world, 0.0)
    assert world.gripper.grasp("cube")


def test_a_released_body_falls(world):
    """Let go in the air the cube falls to the table."""
    close_on_cube(world)
    world.gripper.grasp("cube")
    move(world, ABOVE)
    world.gripper.release()
    world.gripper.set_target(1.0, 0.2)
    steps(world, 20)
    assert world.body("cube").position[2] == pytest.approx(above_table(0.025), abs=2e-3)


def test_friction_alone_holds(world):
    """Without attachment the fingers lift the cube and do not lose it."""
    close_on_cube(world)
    start = in_hand(world)
    move(world, ABOVE, 1.5)
    steps(world, 40)
    assert world.gripper.grasped == ()
    assert np.abs(in_hand(world) - start)[:3].max() < 2e-3
    assert world.body("cube").position[2] > above_table(0.128)


def test_fingers_that_rely_on_friction_press_with_their_force():
    """The pads press on the cube with the 40 N of the fingers, also while it is swung, and do not sink into it."""
    with build() as world:
        world.gripper.rely_on_friction()
        close_on_cube(world)
        move(world, ABOVE)
        move(world, ABOVE + [0.8, 0, 0, 0, 0, 0, 0.5])
        steps(world, 5)
        assert world.gripper.squeezes
        left, right = world.robot.touch_forces().reshape(2, 3)
        assert left[1] == pytest.approx(40.0, rel=0.05)
        assert right[1] == pytest.approx(-40.0, rel=0.05)
        np.testing.assert_allclose(world.robot.fingers, 0.025, atol=2e-4)


def test_a_friction_grip_outlasts_commands_of_one_tick():
    """Commanded to close anew in every tick, and to hold in between, the fingers go on pressing."""
    with build() as world:
        world.gripper.rely_on_friction()
        close_on_cube(world)
        for _ in range(10):
            world.gripper.set_target(0.0, 0.2)
            world.step()
            world.gripper.hold()
            world.step()
        assert world.robot.touch_forces().reshape(2, 3)[0, 1] == pytest.approx(40.0, rel=0.05)


def test_a_friction_grip_is_restored_exactly():
    """Lifting and letting go from a saved state in the middle of a squeeze is the same to the last bit each time."""
    with build() as world:
        world.gripper.rely_on_friction()
        close_on_cube(world)
        saved, ends = world.save(), []
        for _ in range(3):
            world.restore(saved)
            move(world, ABOVE)
            lifted = digest(world)
            fingers(world, 1.0)
            steps(world, 20)
            ends.append((lifted, digest(world)))
        assert ends[0] == ends[1] == ends[2]
        assert world.body("cube").position[2] == pytest.approx(above_table(0.025), abs=2e-3)


def test_fixed_bodies_are_not_grasped():
    """Something welded to the world is refused."""
    with build(cube_scene(cube("cube", 0.3, 0.0, fixed=True))) as world:
        assert not world.gripper.grasp("cube")


@pytest.mark.parametrize(
    ("amount", "speed", "force"), [(1.1, 0.04, None), (np.nan, 0.04, None), (0.5, 0.0, None), (0.5, 0.04, -1.0)]
)
def test_a_bad_command_is_refused(world, amount, speed, force):
    """Fractions outside 0..1 and speeds or forces that are not positive raise InvalidActionError."""
    with pytest.raises(InvalidActionError):
        world.gripper.set_target(amount, speed, force)
