"""Where a link is, is asked of PyBullet once until something moves, and is never out of date."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import rlbench_pin.sim
from rlbench_pin.errors import EnvironmentClosed
from rlbench_pin.sim import World
from rlbench_pin.sim.client import bullet
from tests.sim.support import ABOVE, build, cube, furniture_scene, steps


def asked(world: World) -> list[tuple[float, ...]]:
    """Where PyBullet says that cube, drawer and tip are."""
    where = {"physicsClientId": world.client.id}
    chest, arm = world.body("chest").model, world.robot.model
    drawer, tip = chest.link_index("drawer_top_link"), arm.link_index(world.robot.description.tip_frame)
    links = [bullet.getLinkState(m.uid, i, computeForwardKinematics=1, **where)[4] for m, i in ((chest, drawer), (arm, tip))]
    return [bullet.getBasePositionAndOrientation(world.body("cube").model.uid, **where)[0], *links]


def told(world: World) -> list[tuple[float, ...]]:
    """Where the world says that they are."""
    poses = (world.body("cube").pose, world.body("chest").link_pose("drawer_top_link"), world.robot.tip_pose())
    return [tuple(pose[:3].tolist()) for pose in poses]


def pushed(world: World) -> None:
    """One tick with a moving arm, asked before every physics step; the cube falls."""
    world.robot.set_velocity_targets(np.full(7, 0.2))
    world.on_physics.append(lambda: np.testing.assert_array_equal(told(world), asked(world)))
    world.step()


def restored(world: World) -> None:
    """Back to an instant, after some time."""
    saved = world.save()
    steps(world, 3)
    told(world)
    world.restore(saved)


def from_arrays(exact: bool) -> Callable[[World], None]:
    """Back to an instant by arrays, after some time."""

    def change(world: World) -> None:
        arrays = world.arrays(exact)
        steps(world, 3)
        told(world)
        world.set_arrays(arrays)

    return change


def origin(world: World) -> None:
    """Back to the beginning, in a server built again."""
    steps(world, 3)
    told(world)
    world.build_again()


CHANGES: dict[str, Callable[[World], None]] = {
    "a tick": pushed,
    "a pose": lambda world: world.body("cube").set_pose([0.4, 0.1, 1.2, 0, 0, 0, 1]),
    "the root": lambda world: world.place_root(world.root.pose + [0.05, 0, 0, 0, 0, 0, 0]),
    "a joint": lambda world: world.joint("chest/drawer_top").set_position(0.03),
    "the arm": lambda world: world.robot.reset_configuration(ABOVE),
    "joint states": lambda world: world.robot.set_joint_states(np.append(ABOVE, [0.02, 0.02]), np.zeros(9)),
    "another body": lambda world: world.add_body("late", cube("late", 0.5, 0.3)) and None,
    "a state": restored,
    "arrays": from_arrays(exact=True),
    "arrays without contacts": from_arrays(exact=False),
    "the origin": origin,
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_placements_are_those_of_the_present_instant(change):
    """Whatever moves things, the world tells where they are now; after a change each is asked for once."""
    with build(furniture_scene()) as world:
        world.body("cube").set_pose([0.3, 0.0, 1.0, 0, 0, 0, 1])
        np.testing.assert_array_equal(told(world), asked(world))
        change(world)
        np.testing.assert_array_equal(told(world), asked(world))


def test_a_placement_is_the_callers_own():
    """Whoever changes what was returned changes nothing else."""
    with build() as world:
        model = world.body("cube").model
        first = model.placement()
        first.translation = np.zeros(3)
        assert model.placement() != first


def test_a_closed_world_says_so():
    """What was read before is not told any more."""
    world = build()
    assert world.body("cube").pose.shape == (7,)
    world.close()
    with pytest.raises(EnvironmentClosed):
        _ = world.body("cube").pose


def test_only_the_client_lets_things_move_unrecorded():
    """No other module steps or restores a server, which would leave old placements behind."""
    folder = Path(rlbench_pin.sim.__file__).parent
    movers = re.compile(r"bullet\.(stepSimulation|restoreState|resetSimulation)\(")
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*.py") if movers.search(path.read_text())}
    assert found == {"client.py"}
