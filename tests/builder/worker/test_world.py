"""A task in the world: built with or without its code, laid out, played, changed in place."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from rlbench_pin.builder.worker.process import NothingOpen
from rlbench_pin.builder.worker.world import NO_CODE, AliveListener, TaskWorld
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.viewer.recording import Frame, Recording
from tests.builder.worker.conftest import Copied, Opened

TASKS = ("take_lid_off_saucepan", "push_button", "slide_block_to_target")


def _played(world: TaskWorld, seed: int) -> Recording:
    frames: list[Frame] = []
    return replace(world.demonstrate(seed, 0, frames.append), frames=tuple(frames))


@pytest.mark.simulation
@pytest.mark.parametrize("name", TASKS)
def test_a_task_is_opened_and_demonstrated(copied: Copied, opened: Opened, world: TaskWorld, name: str) -> None:
    """It says what it holds; the demonstration of a seed is that of the library, tick by tick."""
    task = opened(copied(name))
    assert task.problems == ()
    assert task.conditions
    assert task.waypoints[:2] == ("waypoint0", "waypoint1")
    recording = _played(world, 3)
    assert recording.failure is None
    assert recording.conditions == task.conditions
    assert [segment.waypoint for segment in recording.segments] == list(task.waypoints)
    assert recording.frames[-1].success
    assert not recording.frames[0].success
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        assert task.try_demo(seed=3, variation=0, record=False).success
        assert np.array_equal(task.world.robot.joint_positions, recording.frames[-1].arm)


def test_without_its_code_the_scene_stands_alone(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """No line of the module is run; there are waypoints and no conditions, and the waypoints can be visited."""
    text = copied("push_button")
    task = opened(replace(text, python="raise SystemError('was run')\n"), run_task=False)
    assert (task.problems, task.variations, task.conditions) == ((), 1, ())
    assert task.waypoints == ("waypoint0", "waypoint1")
    assert world.reset(0, 0).instruction == NO_CODE
    recording = _played(world, 0)
    assert len(recording.segments) == 2
    assert recording.failure is not None
    assert "goal was not reached" in recording.failure.cause


def test_a_reset_is_one_frame(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """Every link has its pose, the instruction is that of the variation, and the same seed gives the same frame."""
    opened(copied("push_button"))
    first, other, again = world.reset(5, 2), world.reset(6, 2), world.reset(5, 2)
    (frame,) = first.frames
    assert (first.failure, frame.time, frame.conditions_met, frame.success) == (None, 0.0, (False,), False)
    assert list(frame.poses) == ["button/base", "button/cap"]
    assert "base" in first.instruction
    assert np.array_equal(frame.poses["button/cap"], again.frames[0].poses["button/cap"])
    assert not np.array_equal(frame.poses["button/cap"], other.frames[0].poses["button/cap"])


@pytest.mark.simulation
def test_a_reset_that_is_refused_says_why(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """A footprint that fits nowhere, a variation that there is not, and code that raises, with its line."""
    text = copied("push_button")
    opened(replace(text, scene=text.scene.replace("[0.24, 0.24]", "[0.9, 0.9]")))
    failure = world.reset(0, 0).failure
    assert failure is not None
    assert "40 x BoundaryError" in failure.cause
    assert "smaller footprint" in failure.cause
    opened(text)
    failure = world.reset(0, 99).failure
    assert failure is not None
    assert "Choose 0 to 17" in failure.cause
    python = text.python.replace("self.is_green = False", "self.is_green = nothing")
    opened(replace(text, python=python))
    failure = world.reset(0, 0).failure
    assert failure is not None
    assert failure.problem is not None
    assert failure.problem.line == python[: python.index("nothing")].count("\n") + 1
    assert "nothing" in failure.cause


def test_code_that_raises_while_it_is_played(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """The demonstration ends there with the line, in `step` as in a condition."""
    text = copied("push_button")
    python = re.sub(r"( +)if not self.is_green and", r"\1self.gone\n\1if not self.is_green and", text.python)
    opened(replace(text, python=python))
    recording = _played(world, 0)
    assert recording.failure is not None
    assert recording.failure.problem is not None
    assert recording.failure.problem.line == python[: python.index("self.gone")].count("\n") + 1
    assert len(recording.frames) == 1
    assert world.simulate(0.1, lambda frame: None).failure is not None


def test_time_goes_on_with_the_arm_held_still(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """From the present moment, counted from the reset; what is not supported falls."""
    text = copied("take_lid_off_saucepan")
    opened(replace(text, scene=text.scene.replace("pose = [0.0, 0.0, 0.1215]", "pose = [0.0, 0.0, 0.3]")))
    frames: list[Frame] = []
    world.simulate(0.2, frames.append)
    world.simulate(0.3, frames.append)
    assert [round(frame.time, 3) for frame in frames] == pytest.approx(
        [0, 0.05, 0.1, 0.15, 0.2, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5]
    )
    heights = [frame.poses["lid/knob"][2] for frame in frames]
    assert heights[0] - heights[-1] > 0.1
    assert np.abs(frames[-1].arm - frames[0].arm).max() < 1e-3


@pytest.mark.simulation
def test_looking_does_not_change_what_is_played(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """After a demonstration, reach and paths are about its start, and the world stays at its end."""
    opened(copied("take_lid_off_saucepan"))
    world.reset(3, 0)
    before = [verdict.pose for verdict in world.reach()]
    end = _played(world, 3).frames[-1]
    after = [verdict.pose for verdict in world.reach()]
    assert np.array_equal(before, after)
    assert [path.cause for path in world.paths(lambda path: None)] == ["", "", ""]
    frames: list[Frame] = []
    world.simulate(0.05, frames.append)
    assert np.abs(frames[0].poses["lid/knob"] - end.poses["lid/knob"]).max() < 1e-6
    assert frames[0].time == pytest.approx(end.time)
    assert frames[-1].conditions_met == (True, True)


def test_long_work_shows_that_it_lives(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """A reset and a plan are heard, now and then; what the listener raises ends the work."""
    opened(copied("push_button"))
    signs: list[bool] = []
    with world.runtime.listening(AliveListener(lambda: signs.append(True), interval=0.0)):
        world.reset(0, 0)
    assert len(signs) > 2
    with world.runtime.listening(AliveListener(lambda: signs.clear(), interval=60.0)):
        world.reset(0, 0)
    assert signs

    def enough() -> None:
        raise LookupError("enough")

    with world.runtime.listening(AliveListener(enough, interval=0.0)):
        failure = world.reset(0, 0).failure
    assert failure is not None
    assert "enough" in failure.cause


def test_what_is_not_open_is_said(world: TaskWorld) -> None:
    """Before the first task, and after one that could not be built."""
    with pytest.raises(NothingOpen, match="reach"):
        TaskWorld().reach()


def test_the_map_of_what_can_be_reached(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """One spot for each layout that found a place, each reported as it is found."""
    opened(copied("push_button"))
    seen: list[object] = []
    spots = world.reach_map(6, seen.append)
    assert list(spots) == seen
    assert all(spot.free and spot.reached == (True, True) and len(spot.spots) == 2 for spot in spots)
    assert len({spot.place for spot in spots}) == 6
