"""The tasks of the library: what varies, what counts as success, what they tell about themselves."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress

import numpy as np
import pytest

from rlbench_pin.errors import BoundaryError
from rlbench_pin.robot.catalogue import robot_description
from rlbench_pin.sim import World
from rlbench_pin.spatial import pose_at
from rlbench_pin.tasks import BUTTON_COLORS, COLORS, Task, place_task, task_class, task_names, task_scene

VARIATIONS = {
    "beat_the_buzz": 1,
    "close_microwave": 1,
    "empty_container": 20,
    "empty_dishwasher": 1,
    "hang_frame_on_hanger": 1,
    "hockey": 1,
    "insert_onto_square_peg": 20,
    "light_bulb_in": 20,
    "meat_off_grill": 2,
    "open_box": 1,
    "open_door": 1,
    "open_drawer": 3,
    "open_oven": 1,
    "open_wine_bottle": 1,
    "pick_and_lift": 20,
    "place_cups": 3,
    "place_shape_in_shape_sorter": 5,
    "play_jenga": 1,
    "plug_charger_in_power_supply": 1,
    "pour_from_cup_to_cup": 20,
    "push_button": 18,
    "push_buttons": 50,
    "put_groceries_in_cupboard": 9,
    "put_rubbish_in_bin": 1,
    "reach_target": 20,
    "screw_nail": 1,
    "setup_checkers": 3,
    "slide_block_to_target": 1,
    "stack_blocks": 60,
    "straighten_rope": 1,
    "sweep_to_dustpan": 1,
    "take_lid_off_saucepan": 1,
    "weighing_scales": 3,
    "wipe_desk": 1,
}
"""Of the tasks that the specification asks for."""
LOW_DIM = {"pick_and_lift": 6, "reach_target": 3, "slide_block_to_target": 6}
SHAPED = {"reach_target", "slide_block_to_target", "take_lid_off_saucepan"}
YAW = {
    "close_microwave": 0.393,
    "empty_dishwasher": 1.57,
    "hang_frame_on_hanger": 0.0,
    "open_box": 0.393,
    "open_door": 0.785,
    "open_drawer": 0.393,
    "open_oven": 0.785,
    "place_cups": 1.571,
    "play_jenga": 0.393,
    "plug_charger_in_power_supply": 0.785,
    "pour_from_cup_to_cup": 0.0,
    "put_groceries_in_cupboard": 1.0,
    "reach_target": 0.0,
    "screw_nail": 1.57,
    "weighing_scales": 0.785,
}
"""Upper bound of the random yaw where it is not the default [rad]."""
REPEATS = {"push_buttons"}
"""Tasks whose specification gives several variations the same goal."""


@contextmanager
def running(name: str) -> Iterator[Task]:
    """A task in its world, set up."""
    with World(task_scene(task_class(name)), robot_description("panda")) as world:
        task = task_class(name)(world)
        task.init_task()
        yield task


def begin(task: Task, variation: int = 0, seed: int = 0) -> list[str]:
    """Begin an episode at the nominal place; a crowded draw is drawn again, as a reset does."""
    generator = np.random.default_rng(seed)
    for _ in range(5):
        try:
            return task.begin_episode(variation, generator)
        except BoundaryError:
            continue
    raise AssertionError("five draws in a row found no place")


@pytest.mark.parametrize("name", task_names())
def test_every_variation_begins_with_three_sentences_of_its_own(name: str) -> None:
    """Sentences name the goal, are whole, and no two variations share them."""
    with running(name) as task:
        clean, seen = task.world.save(), set()
        assert task.variation_count() == VARIATIONS[name]
        for variation in range(task.variation_count()):
            task.world.restore(clean)
            sentences = begin(task, variation, seed=variation)
            assert len(sentences) >= 3
            assert all(s[0].isupper() and s[-1] in ".?!" for s in sentences)
            assert task.success() == (False, False)
            seen |= set(sentences)
        assert len(seen) == 3 * task.variation_count() or name in REPEATS


@pytest.mark.parametrize("name", task_names())
def test_the_numbers_of_the_specification_hold(name: str) -> None:
    """Length of the low-dimensional state, shaped reward, yaw bounds, static workspace."""
    with running(name) as task:
        begin(task)
        state = task.get_low_dim_state()
        assert np.isfinite(state).all()
        if name in LOW_DIM:
            assert state.shape == (LOW_DIM[name],)
        reward = task.reward()
        assert (reward is not None) == (name in SHAPED)
        assert reward is None or reward < 0.0
        assert task.base_rotation_bounds()[1][2] == YAW.get(name, 3.14)
        assert task.is_static_workspace() == (name == "reach_target")


@pytest.mark.parametrize("name", task_names())
def test_an_episode_depends_on_its_generator_alone(name: str) -> None:
    """Same seed, same bytes, whatever was before; and the scene stays on the table when it is placed."""
    with running(name) as task:
        clean, states = task.world.save(), []
        for seed in (1, 2, 1):
            task.end_episode()
            task.world.restore(clean)
            generator = np.random.default_rng(seed)
            task.begin_episode(0, generator)
            if not task.is_static_workspace():
                with suppress(BoundaryError):  # a reset draws again
                    place_task(task.world, generator, task.base_rotation_bounds())
            states.append(b"".join(body.pose.tobytes() for body in task.world.bodies.values()))
            assert all(body.position[2] > 0.75 for body in task.world.bodies.values())
        assert states[0] == states[2]
        assert name in ("reach_target",) or states[0] != states[1]


@pytest.mark.parametrize("name", task_names())
def test_things_stand_where_they_are_put(name: str) -> None:
    """Settling moves nothing by more than a millimetre."""
    with running(name) as task:
        begin(task)
        before = {n: b.position for n, b in task.world.bodies.items()}
        for _ in range(10):
            task.world.step()
        for n, body in task.world.bodies.items():
            assert n in task.world.spawned or np.linalg.norm(body.position - before[n]) < 1e-3, n
        assert task.success() == (False, False)


def test_all_tasks_of_the_library_are_judged_here() -> None:
    """A new task needs its numbers in this file."""
    assert set(task_names()) <= set(VARIATIONS)


def colors(task: Task, *names: str) -> list[tuple[float, ...]]:
    """Colours of bodies."""
    return [task.world.body(n).color[:3] for n in names]


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
        task.block.set_pose(pose_at((target[0] - 0.055, target[1], 0.782)))
        assert task.success() == (False, False)
        task.block.set_pose(pose_at((target[0] - 0.045, target[1], 0.782)))
        assert task.success() == (True, True)
        tip = np.linalg.norm(task.robot.tip_pose()[:3] - task.block.position)
        assert task.reward() == pytest.approx(-tip - np.linalg.norm(task.block.position - target))


def test_pick_and_lift_wants_the_block_held_at_the_marker() -> None:
    """At the marker but not held is no success."""
    with running("pick_and_lift") as task:
        begin(task, 7)
        assert colors(task, "block") == [COLORS[7].rgb]
        assert task.marker.position[2] == pytest.approx(0.952)
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
            task.world.body(name).set_pose(pose_at((square[0], square[1], 0.777 + 0.05 * k)))
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
