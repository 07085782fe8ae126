"""Bodies at rest sleep until something comes near them, also after a state was restored."""

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
from rlbench_pin.sim import World, resting
from rlbench_pin.sim.resting import QUIET_TICKS
from rlbench_pin.sim.state import LogicalState, WorldState
from rlbench_pin.spatial import above_table
from tests.sim.support import (
    ABOVE,
    AROUND,
    FAR,
    SIDE,
    UPRIGHT,
    asleep,
    build,
    close_on_cube,
    cube,
    cube_scene,
    digest,
    fall_asleep,
    fingers,
    move,
    steps,
    tower_scene,
)


def test_what_rests_sleeps_and_then_nothing_of_it_moves() -> None:
    """From a few ticks after coming to rest on, speeds are zero and poses stay the same to the last bit."""
    with build(tower_scene()) as world:
        steps(world, QUIET_TICKS - 1)
        assert not asleep(world)
        fall_asleep(world)
        world.step()
        before = {name: body.pose.tobytes() for name, body in world.bodies.items()}
        steps(world, 20)
        assert {name: body.pose.tobytes() for name, body in world.bodies.items()} == before
        assert not any(body.velocity.any() for body in world.bodies.values())
        assert {c.other for c in world.contacts("t1")} | {c.body for c in world.contacts("t1")} == {"t0", "t1", "t2"}


def test_the_arm_moves_as_if_nothing_slept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Away from the arm it makes no difference to its joints and motors, not in the last bit, who sleeps."""
    motions = []
    for ticks in (QUIET_TICKS, 10**9):
        monkeypatch.setattr(resting, "QUIET_TICKS", ticks)
        with build(tower_scene()) as world:
            motion = []
            for tick in range(30):
                world.robot.set_velocity_targets(0.3 * np.sin(0.2 * tick + np.arange(7)))
                world.step()
                motion.append(world.robot.joint_states().tobytes())
            assert bool(asleep(world)) == (ticks == QUIET_TICKS)
            motions.append(motion)
    assert motions[0] == motions[1]


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 3.5), (1.5, 0.0, 2.0)], ids=["falls back", "hits"])
def test_what_flies_at_a_sleeping_tower_knocks_it_as_if_it_were_awake(
    monkeypatch: pytest.MonkeyPatch, velocity: tuple[float, ...]
) -> None:
    """The tower sleeps again while the cube is in the air, and wakes in the step in which they come near."""
    ends = []
    for ticks in (QUIET_TICKS, 10**9):
        monkeypatch.setattr(resting, "QUIET_TICKS", ticks)
        scene = cube_scene(*[cube(f"t{k}", *FAR, above_table(SIDE * (k + 0.5))) for k in range(3)], cube("ball", -0.5, FAR[1]))
        with build(scene) as world:
            steps(world, 20)
            world.body("ball").set_velocity([*velocity, 0.0, 0.0, 0.0])
            steps(world, 6)
            assert ({"t0", "t1", "t2"} <= asleep(world)) == (ticks == QUIET_TICKS)
            steps(world, 24)
            ends.append(np.array([world.body(f"t{k}").position for k in range(3)]))
    places = np.array([[*FAR, above_table(SIDE * (k + 0.5))] for k in range(3)])
    for end in ends:
        assert (np.linalg.norm(end - places, axis=1).max() > 2e-3) == (velocity[0] > 0.0)
    np.testing.assert_allclose(ends[0], ends[1], atol=5e-4 if velocity[0] == 0.0 else 5e-3)  # what is awake creeps


def test_the_hand_moves_a_sleeping_cube(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fingers close on a cube that slept as on one that did not, and lift it by friction alone."""
    heights = []
    for ticks in (QUIET_TICKS, 10**9):
        monkeypatch.setattr(resting, "QUIET_TICKS", ticks)
        with build() as world:
            steps(world, 12)
            assert bool(asleep(world)) == (ticks == QUIET_TICKS)
            world.robot.reset_configuration(ABOVE)
            move(world, AROUND)
            fingers(world, 0.0)
            move(world, ABOVE)
            assert "cube" not in asleep(world)
            heights.append(world.body("cube").position)
    assert heights[0][2] > above_table(0.1)
    np.testing.assert_allclose(heights[0], heights[1], atol=1e-4)


def test_whatever_changes_the_world_wakes_what_stands_on_it() -> None:
    """A support that is moved, taken away, made to pass through things, thrown or freed: what stood on it falls."""
    height = above_table(SIDE * 2.5)
    with build(tower_scene()) as world:
        world.add_body("base", cube("base", 0.1, -0.1))
        world.add_body("top", cube("top", 0.1, -0.1, above_table(SIDE * 1.5)))
        fall_asleep(world)
        saved = world.save()
        changes = (
            lambda: world.body("t0").set_pose([0.3, 0.3, 0.9, *UPRIGHT]),
            lambda: world.body("t1").set_collides(False),
            lambda: world.body("t1").set_velocity([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        )
        for change in changes:
            world.restore(saved)
            assert asleep(world) == set(world.bodies)
            change()
            world.step()
            assert not asleep(world)
            steps(world, 10)
            assert world.body("t2").position[2] < height - 0.01
        world.restore(saved)
        world.remove_body("base")
        steps(world, 10)
        assert world.body("top").position[2] < above_table(SIDE * 0.6)


def test_changed_dynamics_wake() -> None:
    """Another mass, another friction, and a body that is held or freed."""
    with build(tower_scene()) as world:
        body = world.body("t0")
        for change in (
            lambda: world.dynamics_overrides.scale(body.model, mass=2.0),
            lambda: world.dynamics_overrides.set_friction(body.model, -1, 0.1),
            world.dynamics_overrides.clear,
        ):
            fall_asleep(world)
            change()
            world.step()
            assert not asleep(world)
        fall_asleep(world)
        world.dynamics_overrides.set_fixed(world.body("t1"), True)
        fall_asleep_without(world, "t1")
        world.body("t1").set_pose([*FAR, above_table(0.3), *UPRIGHT])
        steps(world, 10)
        assert world.body("t1").position[2] == pytest.approx(above_table(0.3))
        world.dynamics_overrides.set_fixed(world.body("t1"), False)
        steps(world, 20)
        assert world.body("t1").position[2] < above_table(0.15)


def fall_asleep_without(world: World, name: str) -> None:
    """Step until everything but one body sleeps."""
    for _ in range(40):
        world.step()
        if asleep(world) == set(world.bodies) - {name}:
            return
    raise AssertionError(f"only {asleep(world)} sleep")


def test_a_thrown_sleeper_flies_and_one_that_is_pushed_up_falls() -> None:
    """Speeds that are given to what sleeps are not lost; it starts a physics step later than what is awake."""
    with build(tower_scene()) as world:
        fall_asleep(world)
        start = world.body("beside").position
        world.body("beside").set_velocity([0.0, -1.0, 1.0, 0.0, 0.0, 0.0])
        world.step()
        moved = world.body("beside").position - start
        assert -0.05 < moved[1] < -0.04 and 0.03 < moved[2] < 0.045
        steps(world, 10)
        fall_asleep(world)
        world.body("beside").set_pose([0.1, -0.35, above_table(0.3), *UPRIGHT])
        steps(world, 4)
        assert world.body("beside").position[2] < above_table(0.3) - 0.1


def test_a_colour_wakes_nobody_and_a_grasp_does() -> None:
    """Appearance does not matter to physics."""
    with build() as world:
        world.robot.reset_configuration(ABOVE)
        fall_asleep(world)
        world.body("cube").set_color((0.0, 1.0, 0.0))
        world.step()
        assert asleep(world) == {"cube"}
        close_on_cube(world)
        assert world.gripper.grasp("cube")
        move(world, ABOVE)
        assert world.body("cube").position[2] > above_table(0.1)
        world.gripper.release()
        fingers(world, 1.0)
        steps(world, 10)
        assert world.body("cube").position[2] < above_table(0.05)


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
from tests.sim.support import asleep, build, tower_scene
from tests.sim.test_resting import go_on
world = build(tower_scene())
world.set_arrays(dict(np.load({file!r})))
print(sorted(asleep(world)), hashlib.sha256(go_on(world)).hexdigest())
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
