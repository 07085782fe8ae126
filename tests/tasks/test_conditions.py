"""Conditions, one by one."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import TaskError
from rlbench_pin.spatial import compose, pose_at
from rlbench_pin.tasks import (
    Aligned,
    AllOf,
    AnyOf,
    Condition,
    Detected,
    DetectedSeveral,
    FollowPath,
    Grasped,
    HasColor,
    InOrder,
    JointMoved,
    ListEmpty,
    NothingGrasped,
    TipInside,
)
from tests.tasks.stand_ins import FakeBody, FakeFrame, FakeGripper, FakeJoint, FakeRobot, FakeSensor


class Switch(Condition):
    """Holds while it is on; counts how often it was asked and reset."""

    def __init__(self, on: bool = False) -> None:
        self.on, self.asked, self.resets = on, 0, 0

    def met(self) -> bool:
        self.asked += 1
        return self.on

    def reset(self) -> None:
        self.resets += 1


def test_joint_moved_counts_both_ways_from_the_start_strictly_and_does_not_latch() -> None:
    """Travel is measured from the value at reset; exactly the distance is not enough; going back undoes it."""
    joint = FakeJoint(0.5)
    condition = JointMoved(joint, 0.25)
    assert not condition.met()
    joint.position = 0.75
    assert not condition.met()
    joint.position = 0.76
    assert condition.met()
    joint.position = 0.24
    assert condition.met()
    joint.position = 0.5
    assert not condition.met()
    joint.position = 0.76
    condition.reset()
    assert not condition.met()
    state = condition.state()
    condition.start = 0.0
    condition.set_state(state)
    assert condition.start == 0.76


def test_detected_asks_the_sensor_about_that_body_and_can_be_negated() -> None:
    """Bodies are asked by name, frames by their point."""
    sensor = FakeSensor({"cup"})
    assert Detected(FakeBody("cup"), sensor).met()
    assert not Detected(FakeBody("plate"), sensor).met()
    assert Detected(FakeBody("plate"), sensor, negated=True).met()
    frame = FakeFrame(pose=np.array([0.05, 0, 0, 0, 0, 0, 1.0]))
    assert Detected(frame, sensor).met()
    frame.pose[0] = 0.2
    assert not Detected(frame, sensor).met()


def test_detected_several_wants_at_least_so_many() -> None:
    """More is fine; which ones does not matter; asking for more than there are is a mistake."""
    bodies = [FakeBody(f"b{i}") for i in range(3)]
    for seen, expected in ((set(), False), ({"b1"}, False), ({"b0", "b2"}, True), ({"b0", "b1", "b2"}, True)):
        assert DetectedSeveral(bodies, FakeSensor(seen), 2).met() is expected
    with pytest.raises(TaskError, match="has 3 elements, but count=4"):
        DetectedSeveral(bodies, FakeSensor(), 4)


def test_aligned_compares_roll_pitch_and_yaw_in_the_frame_of_the_reference() -> None:
    """Each angle may be as large as asked, in either direction; how the reference is turned in the world does not matter."""
    turned = pose_at((0.3, 0.2, 0.1), 0.4, -1.2, 2.5)
    chairs = [FakeBody("first"), FakeBody("second")]
    condition = Aligned(chairs, FakeFrame(pose=turned), 0.25)
    assert not condition.met()
    for chair in chairs:
        chair.set_pose(compose(turned, pose_at((1.0, 0.0, 0.0))))
    assert condition.met()
    for axis in np.eye(3):
        for side in (-1.0, 1.0):
            chairs[1].set_pose(compose(turned, pose_at((0.0, 0.0, 0.0), *(side * 0.249 * axis))))
            assert condition.met()
            chairs[1].set_pose(compose(turned, pose_at((0.0, 0.0, 0.0), *(side * 0.251 * axis))))
            assert not condition.met()
        for turn in (np.pi / 2.0, np.pi):  # on a side, or upside down
            chairs[1].set_pose(compose(turned, pose_at((0.0, 0.0, 0.0), *(turn * axis))))
            assert not condition.met()
    with pytest.raises(TaskError, match="Aligned needs at least one"):
        Aligned([], FakeFrame(), 0.25)


def test_tip_inside_asks_about_the_tip_point() -> None:
    """Only the point between the pads counts."""
    robot = FakeRobot()
    condition = TipInside(robot, FakeSensor())
    assert condition.met()
    robot.tip = np.array([0.0, 0.0, 0.11, 0, 0, 0, 1])
    assert not condition.met()


def test_grasping_means_held_now() -> None:
    """Grasped and NothingGrasped look at what the gripper holds."""
    gripper = FakeGripper()
    grasped, nothing = Grasped(gripper, FakeBody("cup")), NothingGrasped(gripper)
    assert (grasped.met(), nothing.met()) == (False, True)
    gripper.held = ("plate",)
    assert (grasped.met(), nothing.met()) == (False, False)
    gripper.held = ("plate", "cup")
    assert (grasped.met(), nothing.met()) == (True, False)


def test_list_empty_sees_the_list_of_the_task() -> None:
    """The list itself is watched, not a copy."""
    items = [1]
    condition = ListEmpty(items)
    assert not condition.met()
    items.clear()
    assert condition.met()


def test_has_color_is_exact_and_ignores_opacity() -> None:
    """Another shade is another colour."""
    body = FakeBody(color=(1.0, 0.0, 0.0, 0.5))
    assert HasColor(body, (1.0, 0.0, 0.0)).met()
    body.color = (1.0, 0.001, 0.0, 1.0)
    assert not HasColor(body, (1.0, 0.0, 0.0)).met()


def test_all_of_and_any_of_look_at_this_instant_and_ask_everyone() -> None:
    """Members that keep count must see every evaluation, so none is left out."""
    a, b = Switch(True), Switch(False)
    assert not AllOf([b, a]).met()
    assert AnyOf([a, b]).met()
    assert (a.asked, b.asked) == (2, 2)
    b.on = True
    assert AllOf([a, b]).met()
    a.on = b.on = False
    assert not AnyOf([a, b]).met()
    with pytest.raises(TaskError, match="AllOf needs at least one"):
        AllOf([])


class TestInOrder:
    """The pointer of `InOrder`."""

    def test_members_are_passed_one_after_the_other_and_need_not_hold_together(self) -> None:
        """A member that was passed may let go again."""
        first, second = Switch(), Switch()
        condition = InOrder([first, second])
        assert not condition.met()
        first.on = True
        assert not condition.met()
        first.on, second.on = False, True
        assert condition.met()

    def test_the_wrong_order_does_not_count(self) -> None:
        """The second is not looked at before the first was passed."""
        first, second = Switch(), Switch(True)
        condition = InOrder([first, second])
        assert not condition.met()
        assert second.asked == 0
        first.on, second.on = True, False
        assert not condition.met()

    def test_several_may_be_passed_in_one_evaluation(self) -> None:
        """The pointer moves over all consecutive members that hold, and stops at the first that does not."""
        switches = [Switch(True), Switch(True), Switch(False), Switch(True)]
        condition = InOrder(switches)
        assert not condition.met()
        assert condition.passed == 2
        assert switches[3].asked == 0
        switches[2].on = True
        assert condition.met()

    def test_once_met_it_stays_so_until_reset(self) -> None:
        """Latched; reset puts the pointer back and resets the members."""
        switch = Switch(True)
        condition = InOrder([switch])
        assert condition.met()
        switch.on = False
        assert condition.met()
        condition.reset()
        assert switch.resets == 1
        assert not condition.met()

    def test_state_goes_and_comes(self) -> None:
        """Pointer and members are part of the state."""
        joint = FakeJoint()
        condition = InOrder([Switch(True), JointMoved(joint, 0.1)])
        condition.met()
        state = condition.state()
        joint.position = 1.0
        assert condition.met()
        condition.set_state(state)
        assert condition.passed == 1
        assert condition.state() == state


class TestFollowPath:
    """Index and strikes of `FollowPath`, tolerance 0.01."""

    points = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.2, 0.0, 0.0))

    @staticmethod
    def at(condition: FollowPath, x: float) -> bool:
        condition.body.pose = np.array([x, 0, 0, 0, 0, 0, 1.0])
        return condition.met()

    def test_points_are_visited_in_order(self) -> None:
        """Met when the last one was consumed, and from then on."""
        condition = FollowPath(FakeBody(), self.points)
        assert not self.at(condition, 0.1)
        assert condition.index == 0
        assert not self.at(condition, 0.004)
        assert condition.index == 1
        assert not self.at(condition, 0.1)
        assert self.at(condition, 0.2)
        assert self.at(condition, 5.0)

    def test_between_half_and_whole_tolerance_nothing_happens(self) -> None:
        """Neither a visit nor a strike."""
        condition = FollowPath(FakeBody(), self.points)
        self.at(condition, 0.0)
        assert not self.at(condition, 0.1075)
        assert (condition.index, condition.strikes) == (1, 0)

    def test_several_points_may_be_consumed_at_once(self) -> None:
        """The second look of an evaluation is no strike when it misses."""
        condition = FollowPath(FakeBody(), ((0.0, 0, 0), (0.003, 0, 0), (0.1, 0, 0)))
        assert not self.at(condition, 0.002)
        assert (condition.index, condition.strikes) == (2, 0)

    def test_no_strike_before_the_path_was_started(self) -> None:
        """Unless asked for."""
        condition = FollowPath(FakeBody(), self.points)
        self.at(condition, 1.0)
        assert condition.strikes == 0
        eager = FollowPath(FakeBody(), self.points, start_after_first=False)
        self.at(eager, 1.0)
        assert eager.strikes == 1

    def test_a_visit_clears_the_strikes(self) -> None:
        """Strikes count between visits."""
        condition = FollowPath(FakeBody(), self.points)
        for x in (0.0, 0.05, 0.06):
            self.at(condition, x)
        assert condition.strikes == 2
        self.at(condition, 0.1)
        assert condition.strikes == 0

    def test_past_three_strikes_a_further_miss_loses(self) -> None:
        """Four strikes are more than three; the fifth miss asks to end."""
        condition = FollowPath(FakeBody(), self.points)
        self.at(condition, 0.0)
        lost = []
        for _ in range(5):
            self.at(condition, 0.05)
            lost.append(condition.lost)
        assert lost == [False, False, False, False, True]
        condition.reset()
        assert (condition.index, condition.strikes, condition.lost) == (0, 0, False)

    def test_points_may_stand_in_a_frame(self) -> None:
        """The frame carries the path along."""
        frame = FakeFrame(pose=np.array([1.0, 0, 0, 0, 0, 0, 1]))
        condition = FollowPath(FakeBody(), self.points[:1], frame=frame)
        assert not self.at(condition, 0.0)
        assert self.at(condition, 1.0)

    def test_state_goes_and_comes(self) -> None:
        """Index and strikes are part of the state."""
        condition = FollowPath(FakeBody(), self.points)
        for x in (0.0, 0.05):
            self.at(condition, x)
        state = condition.state()
        condition.reset()
        condition.set_state(state)
        assert (condition.index, condition.strikes) == (1, 1)
