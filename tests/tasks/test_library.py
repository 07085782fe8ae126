"""What holds for every task of the library: its numbers and its episodes."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

from rlbench_pin.errors import BoundaryError
from rlbench_pin.spatial import TABLE_HEIGHT, pose_at
from rlbench_pin.tasks import SpawnBoundary, clearance, place_task, task_names
from rlbench_pin.tasks.placement import MAX_LAYOUTS
from tests.tasks.running import begin, running
from tests.tasks.stand_ins import FakeBody, FakeFrame

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


REGION = FakeFrame("patch", size=(0.6, 0.6, 0.0))


def cubes(count: int) -> list[FakeBody]:
    """Small cubes."""
    return [FakeBody(f"cube{i}", box=(0.05, 0.05, 0.05)) for i in range(count)]


def test_scattering_is_sampling_one_after_another() -> None:
    """Same draws, same places; what was placed before is forgotten."""
    ones, others, boundary = cubes(3), cubes(3), SpawnBoundary([REGION])
    rng = np.random.default_rng(3)
    for body in ones:
        boundary.sample(body, rng, min_distance=0.1)
    boundary.scatter(others, np.random.default_rng(3), min_distance=0.1)
    assert len(boundary.state()) == 3
    for one, other in zip(ones, others, strict=True):
        np.testing.assert_array_equal(one.pose, other.pose)


def test_a_layout_is_drawn_anew_until_it_is_accepted() -> None:
    """Here until the first cube stands apart."""
    bodies, boundary = cubes(4), SpawnBoundary([REGION])
    for seed in range(20):
        boundary.scatter(bodies, np.random.default_rng(seed), accept=lambda: clearance(bodies[0], bodies) > 0.25)
        assert clearance(bodies[0], bodies) > 0.25
        assert len(boundary.state()) == 4


def test_a_layout_that_is_never_accepted_is_an_error() -> None:
    """The message names the things and the remedy."""
    asked: list[bool] = []
    with pytest.raises(BoundaryError, match=f"None of {MAX_LAYOUTS} layouts of cube0, cube1 was accepted. Enlarge"):
        SpawnBoundary([REGION]).scatter(cubes(2), np.random.default_rng(0), accept=lambda: bool(asked.append(True)))
    assert len(asked) == MAX_LAYOUTS


def test_clearance_is_horizontal_and_leaves_the_thing_itself_out() -> None:
    """Alone it is endless."""
    low, high = FakeBody("low"), FakeBody("high", pose=pose_at((0.3, 0.4, 2.0)))
    assert clearance(low, [low, high]) == pytest.approx(0.5)
    assert clearance(low, [low]) == np.inf


def test_a_place_may_be_farther_from_some_things_than_from_others() -> None:
    """The larger of two distances counts; things that are not named keep the usual one."""
    near, far, boundary = FakeBody("near"), FakeBody("far"), SpawnBoundary([REGION])
    bodies = cubes(6)
    for seed in range(5):
        boundary.clear()
        rng = np.random.default_rng(seed)
        for body in (near, far):
            boundary.sample(body, rng, min_distance=0.05)
        for body in bodies:
            boundary.sample(body, rng, min_distance=0.05, apart={"far": 0.2, "near": 0.01})
        assert clearance(far, bodies) >= 0.2
        assert clearance(near, bodies) >= 0.05
