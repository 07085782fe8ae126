"""Tasks of the library one by one: what varies, what counts as success, what does not."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.spatial import TABLE_HEIGHT, pose_at
from rlbench_pin.tasks import BUTTON_COLORS, COLORS
from tests.tasks.running import begin, colors, running


def test_reach_target_colours_and_spreads_its_balls() -> None:
    """Three colours, 20 cm apart; the tip in the goal ball is success."""
    with running("reach_target") as task:
        begin(task, 4)
        names = ("target", "distractor0", "distractor1")
        seen = colors(task, *names)
        assert seen[0] == COLORS[4].rgb
        assert len(set(seen)) == 3
        places = [task.world.body(n).position for n in names]
        assert min(np.linalg.norm(places[i] - places[j]) for i in range(3) for j in range(i)) >= 0.2
        np.testing.assert_array_equal(task.get_low_dim_state(), places[0])
        task.target.set_pose(np.concatenate([task.robot.tip_pose()[:3] + [0.0, 0.0, 0.02], [0, 0, 0, 1]]))
        assert task.success() == (True, True)
        assert task.reward() == pytest.approx(-0.02)


def test_push_button_latches_and_turns_green() -> None:
    """A press of 3 mm counts for good; the colours start anew."""
    with running("push_button") as task:
        clean = task.world.save()
        for variation in (3, 5):
            task.world.restore(clean)
            begin(task, variation)
            cap = task.world.joint("button/cap_joint")
            assert colors(task, "button") == [BUTTON_COLORS[variation].rgb]
            task.step()
            assert not task.is_green
            cap.set_position(0.004)
            task.step()
            assert task.is_green
            cap.set_position(0.0)
            assert task.success() == (True, True)


def test_the_button_springs_back() -> None:
    """A pressed cap comes up by itself."""
    with running("push_button") as task:
        begin(task)
        cap = task.world.joint("button/cap_joint")
        cap.set_position(0.006)
        for _ in range(10):
            task.world.step()
        assert cap.position < 0.001


def test_slide_block_wants_the_block_on_the_middle() -> None:
    """Touching the square is not enough."""
    with running("slide_block_to_target") as task:
        begin(task)
        target = task.square.position
        task.block.set_pose(pose_at((target[0] - 0.055, target[1], TABLE_HEIGHT + 0.03)))
        assert task.success() == (False, False)
        task.block.set_pose(pose_at((target[0] - 0.045, target[1], TABLE_HEIGHT + 0.03)))
        assert task.success() == (True, True)
        tip = np.linalg.norm(task.robot.tip_pose()[:3] - task.block.position)
        assert task.reward() == pytest.approx(-tip - np.linalg.norm(task.block.position - target))


def test_pick_and_lift_wants_the_block_held_at_the_marker() -> None:
    """At the marker but not held is no success."""
    with running("pick_and_lift") as task:
        begin(task, 7)
        assert colors(task, "block") == [COLORS[7].rgb]
        assert task.marker.position[2] == pytest.approx(TABLE_HEIGHT + 0.2)
        task.block.set_pose(task.marker.pose)
        assert task.success() == (False, False)
        task.block.set_pose(task.robot.tip_pose())
        task.marker.set_pose(task.robot.tip_pose())
        assert task.gripper.grasp("block")
        assert task.success() == (True, True)


@pytest.mark.parametrize("variation", [0, 4, 59])
def test_stack_blocks_counts_the_blocks_of_its_colour(variation: int) -> None:
    """Two to four blocks on the column, let go; distractors do not count."""
    with running("stack_blocks") as task:
        sentences = begin(task, variation)
        height = 2 + variation % 3
        assert colors(task, "block0", "block3") == [COLORS[variation // 3].rgb] * 2
        assert len(set(colors(task, *(f"distractor{i}" for i in range(4))))) == 1
        assert str(height) in sentences[0]
        square = task.world.body("square").position
        names = [*(f"block{i}" for i in range(height - 1)), "distractor0"]
        for k, name in enumerate(names):
            task.world.body(name).set_pose(pose_at((square[0], square[1], TABLE_HEIGHT + 0.025 + 0.05 * k)))
        assert task.success() == (False, False)
        task.world.body("block3").set_pose(task.world.body("distractor0").pose)
        assert task.success() == (True, True)
        task.gripper.grasp("block3")
        assert task.success() == (False, False)


def test_stack_blocks_retargets_its_waypoints_every_round() -> None:
    """The next block, a higher tower, and no retreat after the last."""
    with running("stack_blocks") as task:
        begin(task, 2)
        heights, skips = [], []
        for k in range(4):
            points = task.get_waypoints()
            for i in (0, 3, 5):
                points[i].run_start_hook()
            np.testing.assert_allclose(points[1].pose[:3], task.world.body(f"block{k}").position, atol=1e-9)
            heights.append(points[3].pose[2] - task.world.body("square").position[2])
            skips.append(points[5].skip)
            assert task.should_repeat_waypoints() == (k < 3)
        np.testing.assert_allclose(heights, [0.08, 0.13, 0.18, 0.23])
        assert skips == [False, False, False, True]


def test_take_lid_off_wants_the_lid_held_high() -> None:
    """The reward counts the way of the hand and the way of the knob."""
    with running("take_lid_off_saucepan") as task:
        begin(task)
        lid, above = task.lid, task.above.position
        to_tip = np.linalg.norm(task.robot.tip_pose()[:3] - lid.position)
        assert task.reward() == pytest.approx(-to_tip - np.linalg.norm(lid.position - above))
        lid.set_pose(pose_at(above))
        assert task.success() == (False, False)
        assert task.gripper.grasp("lid")
        assert task.success() == (True, True)


def test_rubbish_stands_in_any_of_three_places() -> None:
    """Each about equally often; the tomatoes take the others."""
    with running("put_rubbish_in_bin") as task:
        clean, counts = task.world.save(), {}
        for seed in range(60):
            task.world.restore(clean)
            begin(task, seed=seed)
            x = round(float(task.rubbish.position[0]), 3)
            counts[x] = counts.get(x, 0) + 1
            assert len({round(float(b.position[0]), 3) for b in (task.rubbish, *task.tomatoes)}) == 3
        assert len(counts) == 3
        assert min(counts.values()) >= 10


def test_rubbish_has_to_reach_the_bottom() -> None:
    """A tomato in the bin does not count, nor does paper above it."""
    with running("put_rubbish_in_bin") as task:
        begin(task)
        x, y, z = task.world.body("bin").position
        task.tomatoes[0].set_pose(pose_at((x, y, z + 0.04)))
        task.rubbish.set_pose(pose_at((x, y, z + 0.2)))
        assert task.success() == (False, False)
        task.rubbish.set_pose(pose_at((x, y, z + 0.04)))
        assert task.success() == (True, True)


@pytest.mark.parametrize(("variation", "meat", "other"), [(0, "chicken", "steak"), (1, "steak", "chicken")])
def test_meat_off_grill_wants_the_asked_meat(variation: int, meat: str, other: str) -> None:
    """The grasp goes to it at the same height, and only it counts."""
    with running("meat_off_grill") as task:
        height = task.world.frame("waypoint1").position[2]
        begin(task, variation)
        grasp = task.get_waypoints()[1].pose
        np.testing.assert_allclose(grasp[:2], task.world.body(meat).position[:2], atol=1e-9)
        assert grasp[2] == pytest.approx(height)
        side = task.world.sensor("side").position
        task.world.body(other).set_pose(pose_at(side))
        assert task.success() == (False, False)
        task.world.body(meat).set_pose(pose_at(side))
        assert task.success() == (True, True)


@pytest.mark.parametrize(("variation", "drawer"), list(enumerate(("bottom", "middle", "top"))))
def test_open_drawer_wants_the_asked_drawer(variation: int, drawer: str) -> None:
    """The grasp goes to its handle; another drawer does not count; pushed back is undone."""
    with running("open_drawer") as task:
        begin(task, variation)
        np.testing.assert_allclose(task.get_waypoints()[1].pose, task.world.frame(f"handle_{drawer}").pose, atol=1e-9)
        for name in ("bottom", "middle", "top"):
            if name != drawer:
                task.world.joint(f"chest/drawer_{name}").set_position(0.2)
        assert task.success() == (False, False)
        joint = task.world.joint(f"chest/drawer_{drawer}")
        joint.set_position(0.151)
        assert task.success() == (True, True)
        joint.set_position(0.149)
        assert task.success() == (False, False)


def test_close_microwave_wants_forty_degrees() -> None:
    """The door starts at 1.5 rad and stays there until pushed."""
    with running("close_microwave") as task:
        begin(task)
        door = task.world.joint("microwave/door")
        for _ in range(20):
            task.world.step()
        assert door.position == pytest.approx(1.5, abs=1e-3)
        door.set_position(1.5 - np.deg2rad(39.0))
        assert task.success() == (False, False)
        door.set_position(1.5 - np.deg2rad(41.0))
        assert task.success() == (True, True)
