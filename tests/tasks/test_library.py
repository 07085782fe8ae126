"""What holds for every task of the library: its numbers and its episodes."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

from rlbench_pin.errors import BoundaryError
from rlbench_pin.spatial import TABLE_HEIGHT
from rlbench_pin.tasks import place_task, task_names
from tests.tasks.running import begin, running

LOW_DIM = {"pick_and_lift": 6, "reach_target": 3, "slide_block_to_target": 6}
SHAPED = {"reach_target", "slide_block_to_target", "take_lid_off_saucepan"}


@pytest.mark.parametrize("name", task_names())
def test_the_numbers_of_the_specification_hold(name: str) -> None:
    """Length of the low-dimensional state, shaped reward."""
    with running(name) as task:
        begin(task)
        state = task.get_low_dim_state()
        assert np.isfinite(state).all()
        if name in LOW_DIM:
            assert state.shape == (LOW_DIM[name],)
        reward = task.reward()
        assert (reward is not None) == (name in SHAPED)
        assert reward is None or reward < 0.0


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
