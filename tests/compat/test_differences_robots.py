"""What differs in robots under the known names; rows of `docs/compatibility.md`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pyrep import PyRep
from pyrep.const import ConfigurationPathAlgorithms as Algorithms
from pyrep.const import PrimitiveShape
from pyrep.errors import UnsupportedCall
from pyrep.objects import Shape
from pyrep.robots.arms.panda import Panda
from pyrep.robots.end_effectors.panda_gripper import PandaGripper
from rlbench.action_modes.gripper_action_modes import Discrete, GripperJointPosition
from rlbench_pin.compat import arm_planning
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.tasks.library.open_drawer import OpenDrawer
from rlbench_pin.tasks.library.take_lid_off_saucepan import TakeLidOffSaucepan


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


def steps(pyrep: PyRep, count: int) -> None:
    """Let time pass."""
    for _ in range(count):
        pyrep.step()


def test_arguments_of_planning_have_no_effect(pyrep: PyRep) -> None:
    """No trials and no time still give a path; the number of steps is not that of its points."""
    arm = Panda()
    tip = arm.get_tip().get_pose()
    goal = tip[:3] + [0.0, 0.1, -0.1]
    none = arm.get_path(goal, quaternion=tip[3:], trials=0, max_configs=0, trials_per_goal=0, max_time_ms=0, distance_threshold=0)
    assert np.array_equal(none[:], arm.get_path(goal, quaternion=tip[3:])[:])
    lines = [arm.get_linear_path(goal, quaternion=tip[3:], steps=n) for n in (5, 500)]
    assert len(lines[0]) == len(lines[1]) and none.visualize() is None


def test_six_names_of_algorithms_are_searches(pyrep: PyRep) -> None:
    """Around a screen: the others take the path of our RRT-Connect, those six take their own."""
    known = {algorithm.name for algorithm in Algorithms}
    assert set(arm_planning.ALGORITHMS) < known and len(arm_planning.ALGORITHMS) == 6
    arm, down = Panda(), [0.0, 1.0, 0.0, 0.0]
    Shape.create(PrimitiveShape.CUBOID, [0.4, 0.04, 0.5], static=True, position=[0.35, 0.0, 1.0])
    arm.set_joint_positions(arm.solve_ik_via_sampling([0.35, -0.2, 1.0], quaternion=down)[0])
    names = (Algorithms.SBL, Algorithms.EST, Algorithms.KPIECE1)
    sbl, est, kpiece = (arm.get_nonlinear_path([0.4, 0.2, 0.9], quaternion=down, algorithm=name)[:] for name in names)
    assert np.array_equal(sbl, est) and not np.array_equal(sbl, kpiece)


def test_joint_intervals_cannot_be_set(pyrep: PyRep) -> None:
    """Neither of the arm nor of the hand."""
    for component in (Panda(), PandaGripper()):
        with pytest.raises(UnsupportedCall, match="URDF"):
            component.set_joint_intervals(*component.get_joint_intervals())


def test_motors_at_zero_velocity_always_hold(pyrep: PyRep) -> None:
    """Unlocked, the arm does not sink."""
    arm = Panda()
    arm.set_control_loop_enabled(False)
    arm.set_motor_locked_at_zero_velocity(False)
    before = arm.get_joint_positions()
    steps(pyrep, 5)
    assert arm.get_joint_positions() == pytest.approx(before, abs=2e-3)


def test_positions_are_put_without_physics_either_way(pyrep: PyRep) -> None:
    """With dynamics asked for, too, no step is needed."""
    arm = Panda()
    for disable, first in ((True, 0.2), (False, 0.4)):
        arm.set_joint_positions([first, 0.175, 0.0, -0.873, 0.0, 1.222, 0.785], disable_dynamics=disable)
        assert arm.get_joint_positions()[0] == pytest.approx(first)


def test_fingers_get_the_mean(pyrep: PyRep) -> None:
    """Of two targets."""
    hand = PandaGripper()
    hand.set_joint_target_positions([0.01, 0.03])
    steps(pyrep, 10)
    assert hand.get_joint_positions() == pytest.approx([0.02, 0.02], abs=1e-3)


def test_links_cannot_be_grasped(launched: PyRep) -> None:
    """A drawer between the fingers is not taken, by its link or by the whole chest."""
    runtime = Simulator.current().load(OpenDrawer, ObservationConfig())
    hand = reach_around(runtime.world.frame("waypoint1").pose)
    links = [Shape(f"chest/{name}") for name in runtime.world.body("chest").links[1:]]
    assert not any(hand.grasp(item) for item in (Shape("chest"), *links)) and hand.get_grasped_objects() == []


def test_the_arm_collides_with_itself_too(pyrep: PyRep) -> None:
    """The hand touches the first link, and nothing else is near."""
    arm = Panda()
    assert not arm.check_arm_collision()
    arm.set_joint_positions([-0.29, 1.04, -1.56, -2.92, -0.55, 0.73, -2.37])
    assert arm.check_arm_collision() and not arm.check_arm_collision(Shape("diningTable_visible"))


# Closing the hand -------------------------------------------------------------------------------------------------------


def reach_around(place: np.ndarray) -> PandaGripper:
    """Put the open hand at a tip pose (7,), and return it."""
    arm = Panda()
    arm.set_joint_positions(arm.solve_ik_via_sampling(place[:3], quaternion=place[3:], ignore_collisions=True)[0])
    Simulator.current().runtime.step()
    return PandaGripper()


def test_the_hand_takes_what_stops_its_fingers(pyrep: PyRep) -> None:
    """Nothing is held before the fingers have closed, slowly, on the knob; into empty air they close fast."""
    runtime, held = Simulator.current().runtime, []
    hand = reach_around(runtime.world.frame("waypoint1").pose)
    Shape("lid").body("graspable").graspable = True
    runtime.register_step_callback(lambda: held.append(len(hand.get_grasped_objects())))
    Discrete(attach_grasped_objects=True).action(runtime, [0.0])
    assert not any(held) and hand.get_grasped_objects() == [Shape("lid")] and min(hand.get_open_amount()) > 0.1
    slow = len(held)
    Discrete().action(runtime, [1.0])
    assert hand.get_grasped_objects() == []
    Panda().set_joint_positions(Simulator.current().model.home)
    held.clear()
    Discrete().action(runtime, [0.0])
    assert len(held) <= 8 < slow and hand.get_grasped_objects() == []


def test_finger_positions_take_it_as_well(pyrep: PyRep) -> None:
    """Tick by tick, and they let go when they open."""
    runtime = Simulator.current().runtime
    hand = reach_around(runtime.world.frame("waypoint1").pose)
    Shape("lid").body("graspable").graspable = True
    for _ in range(30):
        GripperJointPosition(attach_grasped_objects=True).action(runtime, [0.0])
    assert hand.get_grasped_objects() == [Shape("lid")]
    GripperJointPosition().action(runtime, [0.04])
    assert hand.get_grasped_objects() == []
