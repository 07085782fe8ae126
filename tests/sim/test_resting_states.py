"""In a restored state those sleep that slept, and the world goes on to the last bit."""

from __future__ import annotations

import hashlib
import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim import World
from rlbench_pin.sim.resting import QUIET_TICKS
from rlbench_pin.sim.state import LogicalState, WorldState
from rlbench_pin.spatial import above_table
from tests.sim.support import SIDE, UPRIGHT, asleep, build, digest, fall_asleep, steps, tower_scene


def go_on(world: World, ticks: int = 12) -> bytes:
    """Move the arm about, and add up everything that moves."""
    parts = []
    for tick in range(ticks):
        world.robot.set_velocity_targets(np.full(7, 0.1 if tick % 4 < 2 else -0.2))
        world.step()
        parts.append(digest(world))
    return b"".join(parts)


@pytest.mark.parametrize("ticks", [3, 30])
def test_states_with_sleepers_go_on_exactly(ticks: int) -> None:
    """After saving, restoring, restoring from elsewhere, and in a server built again, with bodies asleep or nearly."""
    with build(tower_scene()) as world:
        steps(world, ticks)
        saved = world.save()
        quiet = saved.logical.quiet
        assert quiet and (ticks == 3) == all(count < QUIET_TICKS for _, count in quiet)
        first = go_on(world)
        world.restore(saved)
        assert world.resting.quiet == quiet
        assert go_on(world) == first
        world.body("t0").set_pose([0.3, 0.3, 0.9, *UPRIGHT])
        steps(world, 8)
        world.restore(saved)
        assert go_on(world) == first
        world.build_again()
        assert not asleep(world)
        world.restore(saved)
        assert go_on(world) == first


def test_saving_a_thrown_sleeper_keeps_its_speed() -> None:
    """A state between the throw and the next tick goes on as the world it was taken from."""
    with build(tower_scene()) as world:
        fall_asleep(world)
        world.body("t2").set_velocity([0.0, 0.0, 4.0, 0.0, 0.0, 0.0])
        saved = world.save()
        assert saved.logical.quiet == ()
        first = go_on(world)
        assert world.body("t2").position[2] > above_table(SIDE * 2.5) + 0.05
        world.restore(saved)
        assert go_on(world) == first


def test_portable_states_and_arrays_with_sleepers_go_on_exactly_in_another_world() -> None:
    """Pickled, and as arrays, in a world where other bodies slept."""
    with build(tower_scene()) as one, build(tower_scene()) as other:
        fall_asleep(one)
        steps(other, 12)
        data = pickle.dumps(one.save(portable=True))
        first = go_on(one)
        other.restore(pickle.loads(data))
        assert asleep(other) == set(other.bodies)
        assert go_on(other) == first
        fall_asleep(one)
        arrays = one.arrays()
        first = go_on(one)
        other.body("t1").set_pose([0.3, 0.3, 0.9, *UPRIGHT])
        steps(other, 20)
        other.set_arrays(arrays)
        assert go_on(other) == first


CONTINUE = """
import sys, hashlib, numpy as np
sys.path.insert(0, {tests!r})
from tests.sim.support import build, tower_scene
from tests.sim.test_resting_states import go_on
world = build(tower_scene())
world.set_arrays(dict(np.load({file!r})))
print(sorted(world.resting.asleep), hashlib.sha256(go_on(world)).hexdigest())
"""


@pytest.mark.slow
def test_sleepers_go_on_exactly_in_another_process(tmp_path: Path) -> None:
    """The same bodies sleep there, and what follows is the same to the last bit."""
    with build(tower_scene()) as world:
        fall_asleep(world)
        np.savez(tmp_path / "state.npz", **world.arrays())  # type: ignore[arg-type]
        expected = f"{sorted(asleep(world))} {hashlib.sha256(go_on(world)).hexdigest()}"
    code = CONTINUE.format(tests=str(Path(__file__).parents[2]), file=str(tmp_path / "state.npz"))
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == expected


def test_arrays_whose_sleepers_do_not_fit_are_refused() -> None:
    """A name that no loose body has is damage, and the world stays as it is."""
    with build(tower_scene()) as world:
        fall_asleep(world)
        arrays, before = world.arrays(), [body.pose.tobytes() for body in world.bodies.values()]
        arrays["meta"] = np.frombuffer(arrays["meta"].tobytes().replace(b'"quiet": {"t0"', b'"quiet": {"t9"'), np.uint8)
        with pytest.raises(RlbenchPinError, match="damaged"):
            world.set_arrays(arrays)
        assert [body.pose.tobytes() for body in world.bodies.values()] == before
        assert asleep(world) == set(world.bodies)


def test_a_state_that_says_nothing_of_sleep_wakes_all() -> None:
    """Such as one that was pickled by a version in which nothing slept."""
    with build(tower_scene()) as world:
        fall_asleep(world)
        saved = world.save()
        old = WorldState(saved.physics, replace(saved.logical, quiet=LogicalState.quiet))
        world.restore(old)
        world.step()
        assert not asleep(world) and world.body("t2").velocity.any()
        fall_asleep(world)


def test_saving_changes_no_measured_torque() -> None:
    """The step that wakes all colliders is not seen: torques are those of the last tick."""
    with build(tower_scene()) as world:
        world.robot.set_velocity_targets(np.full(7, 0.2))
        fall_asleep(world)
        before = world.robot.joint_states()
        saved = world.save()
        np.testing.assert_array_equal(world.robot.joint_states(), before)
        world.restore(saved)
        np.testing.assert_array_equal(world.robot.joint_states(), before)
        world.step()
        assert not np.array_equal(world.robot.joint_torques, before[2, :7])
