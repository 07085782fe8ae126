"""A task of the library whose episode is brought into a state by hand, and asked for its verdict."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from rlbench_pin.sim import World
from rlbench_pin.spatial import FloatArray, compose, pose_at, se3_to_pose
from rlbench_pin.tasks import Task


class Goal:
    """A task at the start of an episode, with what it says of the states that a test brings it into.

    Args:
        task: A task whose episode has begun.
        sentences: Its instructions.

    Attributes:
        verdicts: The verdicts so far; a test of a goal has to see it both reached and not reached.
    """

    def __init__(self, task: Task, sentences: list[str]) -> None:
        self.task = task
        self._said = f" {' '.join(re.findall('[a-z0-9]+', sentences[0].lower()))} "
        self.verdicts: set[bool] = set()

    def says(self, word: str) -> bool:
        """Return whether the first instruction names something, in any case; `_` is a space."""
        return f" {word.replace('_', ' ')} " in self._said

    def asked(self, words: Sequence[str]) -> int:
        """Return the number of the one of some words that the first instruction names."""
        (number,) = (i for i, word in enumerate(words) if self.says(word))
        return number

    @property
    def world(self) -> World:
        """The world of the task."""
        return self.task.world

    def reached(self) -> bool:
        """Return whether the goal is reached now; a reached goal ends the episode, one that is not reached does not."""
        success, over = self.task.success()
        assert success is over, "the fail list ended the episode"
        self.verdicts.add(success)
        return success

    def lost(self) -> bool:
        """Return whether the fail list ends the episode now."""
        return self.task.success() == (False, True)

    def border(self, move: Callable[[float], object], inside: float, outside: float) -> None:
        """Check that the goal is reached at one value of what `move` sets, and is not at the other, just beyond a border."""
        move(inside)
        assert self.reached(), f"not reached at {inside}"
        move(outside)
        assert not self.reached(), f"still reached at {outside}"
        move(inside)
        assert self.reached(), f"not reached again at {inside}"

    def put(self, name: str, place: Sequence[float], rpy: Sequence[float] = (0.0, 0.0, 0.0), on: str = "root") -> None:
        """Put a body at a place [m], turned by roll, pitch, yaw [rad], in the axes of a body, link, frame or the root."""
        self.world.body(name).set_pose(compose(self.place_of(on), pose_at(place, *rpy)))

    def place_of(self, name: str) -> FloatArray:
        """Return the pose (7,) of a body, a link `body/link`, a frame or the root."""
        return se3_to_pose(self.world.placement(name))

    def ends(
        self,
        name: str,
        place: Sequence[float],
        rpy: Sequence[float] = (0.0, 0.0, 0.0),
        on: str = "root",
        within: float = 1e-3,
        **borders: Sequence[float],
    ) -> None:
        """Check that the goal is reached with a body at a place, and how far from there it may be.

        Args:
            name: The body.
            place: Where the goal is reached [m].
            rpy: How it is turned there [rad].
            on: The body, link or frame whose axes are meant.
            within: How exactly the borders are known [m].
            borders: Offsets from the place along `x`, `y` or `z` at which the goal ends [m].
        """
        for axis, offsets in borders.items():
            direction = np.eye(3)["xyz".index(axis)]
            for offset in offsets:
                step = np.copysign(within, offset)
                self.border(lambda d, u=direction: self.put(name, place + d * u, rpy, on), offset - step, offset + step)
        self.put(name, place, rpy, on)
        assert self.reached()

    def joint(self, name: str, value: float) -> None:
        """Put a joint at a value [rad] or [m]."""
        self.world.joint(name).set_position(value)

    def tick(self, count: int = 1) -> None:
        """Let the task note the present instant, as after a control tick; nothing moves."""
        for _ in range(count):
            self.task.step()

    def needs_release_of(self, name: str) -> None:
        """Check that the goal is reached while a body is free, and is not while the gripper holds it."""
        assert self.reached()
        assert self.task.gripper.grasp(name)
        assert not self.reached(), f"reached while '{name}' is held"
        self.task.gripper.release()
        assert self.reached()

    def counts_while_held(self, name: str) -> None:
        """Check that the goal, reached, stays so while the gripper holds a body: no release is specified."""
        assert self.reached()
        assert self.task.gripper.grasp(name)
        assert self.reached(), f"not reached while '{name}' is held"
        self.task.gripper.release()


def goal_of(name: str, *variations: int, also: Sequence[str] = ()) -> pytest.MarkDecorator:
    """Hand a test the `goal` of a task of the library, once for each of these variations; the first, if none is named.

    Args:
        name: The task.
        variations: Its variations.
        also: Tasks that have the same goal with another model of the object.
    """
    cases = [pytest.param((task, number), id=f"{task}-{number}") for task in (name, *also) for number in variations or (0,)]
    return pytest.mark.parametrize("goal", cases, indirect=True)
