"""Dropped bodies come to rest, or an error says that they do not."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import BoundaryError
from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.tasks import at_rest, settle, settling

SCENE = SceneSpec(
    format=2,
    body=tuple(
        BodySpec(name=f"cube{i}", asset="objects/cube/cube.urdf", pose=(0.1 * i, 0.0, 0.1 + 0.05 * i, 0.5, 0.3, 0.2, 0.787401))
        for i in range(2)
    ),
)


def test_bodies_lie_flat_and_still_afterwards() -> None:
    """The same seed gives the same places."""
    places = []
    for _ in range(2):
        with World(SCENE, robot_description("panda")) as world:
            bodies = list(world.bodies.values())
            settle(world, bodies, np.random.default_rng(0))
            before = [body.pose for body in bodies]
            for _ in range(settling.FALL_TICKS):
                world.step()
            for body, pose in zip(bodies, before, strict=True):
                np.testing.assert_allclose(body.pose, pose, atol=settling.MAX_DRIFT)
            places.append(np.concatenate(before))
    np.testing.assert_array_equal(*places)


def test_what_falls_turns_or_swings_does_not_rest() -> None:
    """Bodies rest by their speeds, fixed ones by those of their joints alone."""
    door = SceneSpec(format=2, body=(BodySpec(name="door", asset="objects/lever_door/lever_door.urdf", fixed=True),))
    with World(door, robot_description("panda")) as world:
        joint = world.joint("door/leaf_hinge")
        assert at_rest([world.body("door")])
        joint.set_state(joint.position, 0.1)
        assert not at_rest([world.body("door")])
    with World(SCENE, robot_description("panda")) as world:
        bodies = list(world.bodies.values())
        assert at_rest(bodies), "nothing has moved yet"
        world.step()
        assert not at_rest(bodies)
        settle(world, bodies, np.random.default_rng(0))
        assert at_rest(bodies)
        bodies[0].set_velocity([0.0, 0.0, 0.0, 0.0, 0.0, 0.5])
        assert not at_rest(bodies)


def test_bodies_that_never_rest_are_an_error() -> None:
    """The number of pushes is bounded."""

    class Restless:
        """A body that is elsewhere whenever one looks."""

        name, looks, pushes = "restless", 0, 0

        @property
        def pose(self) -> np.ndarray:
            """A new place each time."""
            self.looks += 1
            return np.array([self.looks, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])

        @property
        def position(self) -> np.ndarray:
            """Origin."""
            return self.pose[:3]

        def set_velocity(self, velocity: list[float]) -> None:
            """Count."""
            self.pushes += 1

    class Still:
        """A world that does nothing."""

        control_dt = 0.05

        def step(self) -> None:
            """Do nothing."""

    body = Restless()
    with pytest.raises(BoundaryError, match="After 8 pushes one of restless still moves"):
        settle(Still(), [body], np.random.default_rng(0))  # type: ignore[arg-type, list-item]
    assert body.pushes == settling.KNOCKS + settling.MAX_PUSHES
