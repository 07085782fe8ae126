"""Engines that need no simulator, for the tests of what surrounds them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Sequence

from rlbench_pin.datasets import encode_demo, episode_entry
from rlbench_pin.observation import Demo
from rlbench_pin.processes import Worker
from rlbench_pin.recording.config import WorkItem
from rlbench_pin.recording.record import ItemResult
from tests.demos_for_tests import make_demo


def made_up_demo(item: WorkItem) -> Demo:
    """Return a demo that follows from its item alone."""
    demo = make_demo(frames=2, seed=item.seed % 1000, variation=item.variation, task=item.name)
    demo.random_seed, demo.attempt = item.seed, 0
    for observation in demo:
        observation.front_rgb = observation.front_depth = observation.front_mask = observation.wrist_point_cloud = None
    return demo


def result_of(item: WorkItem, failures: Sequence[str] = ()) -> ItemResult:
    """Return what a recorder would make of an item."""
    demo = made_up_demo(item)
    data = encode_demo(demo, "lzf")
    return ItemResult(item, tuple(failures), data, episode_entry(demo, data, item.index, failures))


class MadeUpEngine:
    """Makes up demonstrations, in the order given or backwards; some fail, some are retried.

    Args:
        backwards: Yield the last item first.
        failing: Indices of items of which every try fails.
        retried: Indices of items of which the first try fails.
    """

    def __init__(self, *, backwards: bool = False, failing: Sequence[int] = (), retried: Sequence[int] = ()) -> None:
        self.backwards, self.failing, self.retried = backwards, failing, retried
        self.begun: list[WorkItem] = []

    def map(
        self, worker: Callable[[], Worker], items: Sequence[WorkItem], stop: threading.Event, max_deaths: int = 3
    ) -> Generator[ItemResult, None, None]:
        """Yield results until stopped."""
        for item in reversed(items) if self.backwards else items:
            if stop.is_set():
                return
            self.begun.append(item)
            if item.index in self.failing:
                yield ItemResult(item, ("no path: walls everywhere",) * len(item.attempts))
            else:
                yield result_of(item, ["DemoError: it fell"] if item.index in self.retried else [])
