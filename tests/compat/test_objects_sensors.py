"""Proximity sensors and joints of scene objects, and the simulator itself."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pyrep import PyRep
from pyrep.const import JointType, PrimitiveShape
from pyrep.errors import PyRepError, UnsupportedCall
from pyrep.objects import Dummy, Joint, Light, Octree, ProximitySensor, Shape
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.tasks import OpenDrawer, ReachTarget

TEXTURES = Path(__file__).parents[2] / "rlbench_pin" / "assets" / "textures"


@pytest.fixture
def pyrep() -> Iterator[PyRep]:
    """A running simulation of the reach task."""
    simulator = PyRep()
    simulator.launch(headless=True)
    Simulator.current().load(ReachTarget, ObservationConfig())
    simulator.start()
    yield simulator
    simulator.shutdown()


def box(size: float, position: list[float]) -> Shape:
    """Make a red cube that stays in the air."""
    return Shape.create(PrimitiveShape.CUBOID, [size] * 3, static=True, position=position, color=[1.0, 0.0, 0.0])


def test_proximity_sensors(pyrep: PyRep) -> None:
    """Shapes by any solid part, dummies by their origin, none that is not detectable."""
    goal = ProximitySensor("goal")
    low = np.array(goal.get_bounding_box())
    radius = 0.5 * (low[1] - low[0])
    cube, marker = box(0.04, [0.0, 0.0, 1.8]), Dummy.create()
    assert not goal.is_detected(cube) and not goal.is_detected(marker)
    cube.set_position(goal.get_position() + [0.0, 0.0, radius + 0.015])
    marker.set_position(goal.get_position() + [0.0, 0.0, 0.5 * radius])
    assert goal.is_detected(cube) and goal.is_detected(marker)
    Shape("target").set_detectable(False)
    assert np.isclose(goal.read(), radius - 0.005, atol=1e-3)
    cube.set_detectable(False)
    assert not goal.is_detected(cube) and goal.read() == -1.0


# Joints -----------------------------------------------------------------------------------------------------------------


def test_joints_of_objects(pyrep: PyRep) -> None:
    """Values, limits, a motor that drives them to a value and holds them."""
    Simulator.current().load(OpenDrawer, ObservationConfig())
    joint = Joint("drawer_middle")
    assert joint.get_joint_type() == JointType.PRISMATIC and joint == Joint("chest/drawer_middle")
    cyclic, (low, length) = joint.get_joint_interval()
    assert not cyclic and low == 0.0 and 0.1 < length < 0.4
    joint.set_joint_position(0.05)
    assert np.isclose(joint.get_joint_position(), 0.05) and joint.get_joint_velocity() == 0.0
    joint.set_joint_target_position(0.15)
    for _ in range(20):
        pyrep.step()
    assert np.isclose(joint.get_joint_position(), 0.15, atol=2e-3) and joint.is_motor_enabled()
    joint.set_motor_enabled(False)
    assert not joint.is_motor_enabled() and not joint.is_control_loop_enabled()
    joint.set_joint_target_velocity(0.0)
    assert joint.is_motor_locked_at_zero_velocity()
    with pytest.raises(UnsupportedCall, match="set_joint_target_position"):
        joint.set_joint_target_velocity(0.3)
    with pytest.raises(UnsupportedCall, match="URDF"):
        joint.set_joint_interval(False, [0.0, 1.0])


def test_joints_of_the_arm(pyrep: PyRep) -> None:
    """One joint moves, the others stay; fingers too."""
    joints = [Joint(f"Panda_joint{k}") for k in range(1, 8)]
    before = np.array([j.get_joint_position() for j in joints])
    joints[3].set_joint_target_position(before[3] - 0.2)
    for _ in range(40):
        pyrep.step()
    after = np.array([j.get_joint_position() for j in joints])
    assert np.allclose(after - before, [0, 0, 0, -0.2, 0, 0, 0], atol=0.01)
    assert joints[0].get_joint_type() == JointType.REVOLUTE and joints[0].get_joint_upper_velocity_limit() > 1.0
    assert abs(joints[1].get_joint_force()) > 1.0
    finger = Joint("Panda_gripper_joint1")
    assert finger.get_joint_type() == JointType.PRISMATIC and np.isclose(finger.get_joint_position(), 0.04, atol=1e-3)


def test_velocities_of_links(pyrep: PyRep) -> None:
    """A turning arm moves its tip across the radius, a drawer slides."""
    pyrep.step()
    turn = Joint("Panda_joint1")
    turn.set_joint_target_velocity(0.5)
    for _ in range(20):
        pyrep.step()
    linear, angular = Dummy("Panda_tip").get_velocity()
    assert np.allclose(angular, [0.0, 0.0, turn.get_joint_velocity()], atol=0.02)
    arm = Dummy("Panda_tip").get_position() - Shape("panda_link0").get_position()
    assert np.allclose(linear, np.cross(angular, arm), atol=0.02)


# The simulator ----------------------------------------------------------------------------------------------------------


def test_the_simulator_starts_steps_and_ends() -> None:
    """In this order only, and again; scenes of other simulators are refused before anything starts."""
    pyrep = PyRep()
    with pytest.raises(PyRepError, match="launch"):
        pyrep.step()
    with pytest.raises(UnsupportedCall, match="TOML"):
        pyrep.launch("my_scene.ttt", headless=True)
    pyrep.launch("task_design.ttt", headless=True)
    with pytest.raises(PyRepError, match="start"):
        pyrep.step()
    pyrep.start()
    assert pyrep.running and pyrep.get_simulation_timestep() == 0.05
    before = Simulator.current().world.time
    pyrep.step()
    assert np.isclose(Simulator.current().world.time - before, 0.05)
    pyrep.set_simulation_timestep(0.05)
    with pytest.warns(UserWarning, match="stays 0.05 s"):
        pyrep.set_simulation_timestep(0.005)
    assert pyrep.get_simulation_timestep() == 0.05
    for call in (
        lambda: pyrep.script_call("f@g", 1),
        lambda: pyrep.export_scene("a.ttt"),
        lambda: Light("l"),
        lambda: Octree("o"),
    ):
        with pytest.raises(UnsupportedCall):
            call()
    with pytest.raises(PyRepError):
        pyrep.launch()
    pyrep.stop()
    pyrep.shutdown()
    pyrep.shutdown()
    assert not pyrep.running
    with pytest.raises(RuntimeError, match="launch"):
        Shape("Floor")
    pyrep.launch()
    assert Shape("Floor").still_exists()
    pyrep.shutdown()


def test_plans_ignore_what_is_not_collidable(pyrep: PyRep) -> None:
    """Physics goes on as before."""
    tip = Dummy("Panda_tip").get_position()
    cube, planner = box(0.1, tip.tolist()), Simulator.current().runtime.planner
    for collidable in (True, False):
        cube.set_collidable(collidable)
        Simulator.current().runtime.refresh_planner()
        touching = planner.collision.colliding_pairs(Simulator.current().world.robot.joint_positions)
        assert bool(touching) is collidable and cube.is_respondable()
