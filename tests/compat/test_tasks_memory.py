"""What a user's task keeps comes back with the episode, and its global draws are its own."""

from __future__ import annotations

import logging
import random
from collections import deque
from types import SimpleNamespace
from typing import Any

import numpy as np

from rlbench_pin.compat.task_memory import GlobalDraws, SavedAttributes


class Counter:
    """What an author of a task may write."""

    def __init__(self) -> None:
        self.count, self.seen, self.me = 0, [1, 2], self


class Owner:
    """Stands for a task of a user."""

    def __init__(self) -> None:
        self.number, self.name, self.fixed = 1, "a", [0]
        self.array, self.list, self.nested = np.zeros(3), [1, [2]], {"a": [1], "b": (np.ones(2), [3])}
        self.set, self.queue, self.counter, self.record = {1, 2}, deque([1]), Counter(), SimpleNamespace(x=1)
        self.rng, self.log = np.random.default_rng(0), logging.getLogger("x")
        self.random, self.state_rng = random.Random(0), np.random.RandomState(0)


def test_contents_come_back_in_the_same_objects() -> None:
    """Numbers, arrays, containers in containers, objects of one's own, generators; new attributes go."""
    owner: Any = Owner()
    kept = SavedAttributes(owner, ("fixed",))
    state = kept.state()
    inner, counter, array, log = owner.list[1], owner.counter, owner.array, owner.log
    drawn = [owner.rng.random(), owner.random.random(), owner.state_rng.rand()]
    owner.number, owner.extra = 5, 1
    owner.array += 3.0
    inner.append(9)
    owner.list.append(4)
    owner.nested["a"].append(2)
    owner.nested["b"][0][:] = 7.0
    owner.nested["c"] = 1
    owner.set.add(3)
    owner.queue.append(2)
    counter.count, counter.seen[:] = 8, []
    owner.record.x = 2
    owner.counter = None
    owner.fixed.append(1)
    kept.set_state(state)
    assert owner.number == 1 and not hasattr(owner, "extra")
    assert owner.array is array and (array == 0.0).all()
    assert owner.list == [1, [2]] and owner.list[1] is inner
    assert owner.nested.keys() == {"a", "b"} and owner.nested["a"] == [1] and (owner.nested["b"][0] == 1.0).all()
    assert owner.set == {1, 2} and list(owner.queue) == [1] and owner.record.x == 1
    assert owner.counter is counter and (counter.count, counter.seen) == (0, [1, 2]) and counter.me is counter
    assert [owner.rng.random(), owner.random.random(), owner.state_rng.rand()] == drawn
    assert owner.fixed == [0, 1] and owner.log is log


def test_a_state_can_be_given_back_twice() -> None:
    """Changes after going back do not reach the state."""
    owner: Any = Owner()
    kept = SavedAttributes(owner)
    state = kept.state()
    for _ in range(2):
        owner.list.append(1)
        owner.array += 1.0
        kept.set_state(state)
        assert owner.list == [1, [2]] and (owner.array == 0.0).all()


def test_global_draws_are_lent() -> None:
    """They repeat with the seed, continue from block to block, and leave the generators as they were."""
    draws = GlobalDraws()
    np.random.seed(3)
    random.seed(3)
    expected = (np.random.rand(), random.random())
    np.random.seed(3)
    random.seed(3)
    draws.seed(7)
    with draws.lent():
        first = (np.random.rand(), random.random())
    saved = draws.state()
    with draws.lent(), draws.lent():
        second = np.random.rand()
    assert (np.random.rand(), random.random()) == expected
    draws.set_state(saved)
    with draws.lent():
        assert np.random.rand() == second
    draws.seed(7)
    with draws.lent():
        assert (np.random.rand(), random.random()) == first
    assert first[0] != second
