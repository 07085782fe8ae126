"""Masses, friction, and bodies that are held at their place or let go."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim import World
from rlbench_pin.sim.body import BASE
from tests.sim.support import build, cube, cube_scene, furniture_scene


@pytest.fixture
def world() -> Iterator[World]:
    """A free cube in the air above one that the scene file holds there."""
    with build(cube_scene(cube("cube", 0.3, 0.3, 1.2), cube("shelf", 0.3, 0.3, 1.0, fixed=True))) as world:
        yield world


def _run(world: World, ticks: int) -> np.ndarray:
    for _ in range(ticks):
        world.step()
    return world.body("cube").position


def test_held_and_let_go(world: World) -> None:
    """A held body stays to the last bit, also when hit; one that was loaded fixed falls when it is let go."""
    overrides, body, shelf = world.dynamics_overrides, world.body("cube"), world.body("shelf")
    start = body.pose
    overrides.set_fixed(body, True)
    assert np.array_equal(_run(world, 10), start[:3]) and np.array_equal(body.pose, start)
    overrides.set_fixed(body, False)
    assert np.isclose(_run(world, 20)[2], 1.05, atol=2e-3)
    overrides.set_fixed(shelf, False)
    assert _run(world, 20)[2] < 0.9 and np.isclose(shelf.position[2], 0.777, atol=2e-3)
    assert np.isclose(overrides.mass(shelf.model, BASE), 0.1)


def test_scaling_lets_nothing_go(world: World) -> None:
    """Scaled masses are those of moving bodies; what is held stays, and is as heavy as asked once it can move."""
    overrides, body, shelf = world.dynamics_overrides, world.body("cube"), world.body("shelf")
    overrides.set_fixed(body, True)
    for thing in (body, shelf):
        overrides.scale(thing.model, mass=3.0)
    assert np.allclose(_run(world, 10)[2], 1.2) and shelf.position[2] == 1.0
    overrides.clear()
    assert np.allclose(_run(world, 10)[2], 1.2) and shelf.position[2] == 1.0
    overrides.set_mass(body.model, BASE, 0.7)
    overrides.set_fixed(body, False)
    _run(world, 40)
    assert np.isclose(sum(c.force for c in world.contacts("cube", "shelf")), 0.7 * 9.81, atol=0.1)


def test_states_say_what_is_held(world: World) -> None:
    """Saved states, arrays and the origin."""
    body = world.body("cube")
    world.end_building()
    world.dynamics_overrides.set_fixed(body, True)
    saved, arrays = world.save(), world.arrays(exact=False)
    world.restore(world.origin)
    assert not body.fixed and _run(world, 5)[2] < 1.15
    world.restore(saved)
    assert body.fixed and np.isclose(_run(world, 5)[2], 1.2)
    world.build_again()
    assert not body.fixed and _run(world, 5)[2] < 1.15
    world.set_arrays(arrays)
    assert body.fixed and np.isclose(_run(world, 5)[2], 1.2)


def test_bodies_with_joints_stay_as_they_were_loaded() -> None:
    """Their base alone says nothing about the rest."""
    with build(furniture_scene()) as world, pytest.raises(RlbenchPinError, match="scene file"):
        world.dynamics_overrides.set_fixed(world.body("chest"), False)


def test_removed_bodies_leave_nothing_behind(world: World) -> None:
    """A body that gets the number of one that is gone has its own mass."""
    world.end_building()
    first = world.add_body("first", cube("first", 0.0, 0.4))
    world.dynamics_overrides.set_mass(first.model, BASE, 2.0)
    world.remove_body("first")
    second = world.add_body("second", cube("second", 0.0, 0.4))
    assert np.isclose(world.dynamics_overrides.mass(second.model, BASE), 0.1)
    world.build_again()
    assert "second" not in world.bodies


class _Keeper:
    def __init__(self) -> None:
        self.value = 0

    def state(self) -> object:
        """Return the value."""
        return self.value

    def set_state(self, state: object) -> None:
        """Take the value."""
        assert isinstance(state, int)
        self.value = state


def test_keepers_go_back_with_the_world(world: World) -> None:
    """In memory, not by arrays, which know nothing of them."""
    keeper = _Keeper()
    world.keepers.append(keeper)
    world.end_building()
    keeper.value = 1
    saved, arrays = world.save(), world.arrays()
    keeper.value = 2
    world.restore(saved)
    assert keeper.value == 1
    world.build_again()
    assert keeper.value == 0
    world.set_arrays(arrays)
    assert keeper.value == 0
