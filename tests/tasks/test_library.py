"""What holds for every task of the library: its numbers and its episodes."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

from rlbench_pin.errors import BoundaryError
from rlbench_pin.spatial import TABLE_HEIGHT
from rlbench_pin.tasks import place_task, task_names
from tests.tasks.running import begin, running

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
"""What the task set defines for each task."""
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


@pytest.mark.parametrize("name", task_names())
def test_the_numbers_of_the_specification_hold(name: str) -> None:
    """Number of variations, length of the low-dimensional state, shaped reward, yaw bounds, static workspace."""
    with running(name) as task:
        begin(task)
        assert task.variation_count() == VARIATIONS[name]
        state = task.get_low_dim_state()
        assert np.isfinite(state).all()
        if name in LOW_DIM:
            assert state.shape == (LOW_DIM[name],)
        reward = task.reward()
        assert (reward is not None) == (name in SHAPED)
        assert reward is None or reward < 0.0
        assert task.base_rotation_bounds()[1][2] == YAW.get(name, 3.14)
        assert task.is_static_workspace() == (name == "reach_target")


@pytest.mark.simulation
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
            assert all(body.position[2] > TABLE_HEIGHT - 0.002 for body in task.world.bodies.values())
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
