"""What tasks call with things of a world refuses everything else by name, before anything has moved."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin.errors import InvalidValue, TaskError
from rlbench_pin.tasks import SpawnBoundary, Tray, clearance, easiest_top_grasp, free_direction, place_task, settle, swap_places
from tests.tasks.stand_ins import FakeBody, FakeFrame

REGION = FakeFrame("patch", size=(0.6, 0.6, 0.0))
TRAY = Tray(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), np.array([0.1, 0.1]))
RNG = np.random.default_rng(0)


class World:
    """As much of a world as is asked for."""

    def step(self) -> None:
        """Nothing happens."""

    def place_root(self, pose: object) -> None:
        """Nothing is moved."""


def sample(**arguments: object) -> object:
    """Place a body with some arguments exchanged."""
    given = {"thing": FakeBody(), "rng": np.random.default_rng(0), **arguments}
    return SpawnBoundary([REGION]).sample(**given)  # type: ignore[arg-type]


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "regions": (lambda: SpawnBoundary(REGION), "regions has to be a list"),  # type: ignore[arg-type]
    "a body for a region": (lambda: SpawnBoundary(["patch"]), r"entry 0 of regions.*self.world.region"),  # type: ignore[list-item]
    "a name for a thing": (lambda: sample(thing="cube"), r"thing has to be a body or a frame"),
    "a seed for a generator": (lambda: sample(rng=3), r"rng has to be a Generator.*default_rng"),
    "degrees": (lambda: sample(min_rotation=(0.0, 0.0, -1800.0)), "min_rotation has to hold numbers"),
    "turned round": (lambda: sample(max_rotation=(0.0, 0.0, -4.0)), "max_rotation has to be nowhere below min_rotation"),
    "no distance": (lambda: sample(min_distance=-1.0), "min_distance"),
    "no switch": (lambda: sample(ignore_collisions="yes"), "ignore_collisions"),
    "no function": (lambda: SpawnBoundary([REGION]).scatter([FakeBody()], RNG, accept=True), "accept"),  # type: ignore[arg-type]
    "no others": (lambda: clearance(FakeBody(), FakeBody()), "others has to be a list"),  # type: ignore[arg-type]
    "no tray": (lambda: easiest_top_grasp([], [], None), "tray has to be a Tray"),  # type: ignore[arg-type]
    "half a tray": (lambda: Tray(TRAY.pose, np.array([0.1, 0.0])), "Tray.half"),
    "no heading": (lambda: free_direction(np.zeros(2), ["north"], [], 0.1, 0.1), "each of directions"),  # type: ignore[list-item]
    "no place": (lambda: free_direction(np.zeros(3), [0.0], [], 0.1, 0.1), "place has to have shape"),
    "no world": (lambda: place_task(None, RNG), "world has to be a world"),  # type: ignore[arg-type]
    "one bound": (lambda: place_task(World(), RNG, (0.0, 1.0, 2.0)), "bounds has to be the lowest and"),  # type: ignore[arg-type]
    "nothing to settle": (lambda: settle(World(), [], RNG), "bodies has to name at least one"),  # type: ignore[arg-type]
    "one to swap": (lambda: swap_places(FakeBody(), "other"), "second has to be a body"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize(("call", "words"), WRONG.values(), ids=WRONG.keys())
def test_what_is_no_thing_of_a_world_is_refused(call: Callable[[], object], words: str) -> None:
    """The error names the argument and says where a task finds the right thing."""
    with pytest.raises(InvalidValue, match=words):
        call()


def test_a_boundary_needs_a_region() -> None:
    """The error says where regions are."""
    with pytest.raises(TaskError, match=r"at least one region, such as `self.world.region\(name\)`"):
        SpawnBoundary([])


def test_a_wanted_body_is_one_of_the_bodies() -> None:
    """A body that is not named among those in the tray cannot be judged."""

    class Bulky(FakeBody):
        def bounds_from(self, frame: object) -> np.ndarray:
            return self.bounds()

    with pytest.raises(InvalidValue, match=r"wanted has to be some of the bodies, one. Got \['other'\]"):
        easiest_top_grasp([Bulky("other")], [Bulky("one")], TRAY)


def test_directions_and_others_may_be_arrays() -> None:
    """As lists of numbers and of points may be."""
    others = np.array([[-0.1, 0.0]])
    assert free_direction([0.0, 0.0], np.array([0.0, 1.0]), others, 0.05, 0.5) == 1.0  # type: ignore[arg-type]
