"""An engine of jobs on a Ray cluster: one actor per worker."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from rlbench_pin.errors import MissingExtra
from rlbench_pin.processes.jobs import MAX_DEATHS, POLL_INTERVAL, Events, ItemT, ResultT, RetryPolicy, Worker

try:
    import ray
    from ray.actor import ActorHandle
    from ray.exceptions import RayError
except ImportError as _error:
    raise MissingExtra("The engine 'ray'", "ray", "ray") from _error


class RayEngine:
    """Runs workers in actors of a Ray cluster. An actor that dies is replaced, and its item is made again.

    The cluster is the one that `ray.init` finds (`RAY_ADDRESS`). Otherwise a cluster on this machine is started for the job.

    Args:
        workers: Number of actors, one core each.
        address: Address of a cluster; None leaves the choice to Ray.
    """

    def __init__(self, workers: int = 1, address: str | None = None) -> None:
        self.workers, self.address = max(1, workers), address

    def map(
        self,
        worker: Callable[[], Worker[ItemT, ResultT]],
        items: Sequence[ItemT],
        stop: threading.Event,
        max_deaths: int = MAX_DEATHS,
    ) -> Events[ResultT, ItemT]:
        """Yield each result when it is finished."""
        began = not ray.is_initialized()
        if began:
            ray.init(address=self.address, log_to_driver=False, logging_level="ERROR", include_dashboard=False)
        try:
            yield from self._map(worker, items, stop, max_deaths)
        finally:
            if began:
                ray.shutdown()

    def _map(
        self, worker: Callable[[], Worker[ItemT, ResultT]], items: Sequence[ItemT], stop: threading.Event, max_deaths: int
    ) -> Events[ResultT, ItemT]:
        queue, retries = deque(items), RetryPolicy[ItemT](max_deaths)
        idle = [_new_actor(worker) for _ in range(min(self.workers, len(queue)))]
        busy: dict[ray.ObjectRef, tuple[ActorHandle, ItemT]] = {}
        while queue or busy:
            while idle and queue and not stop.is_set():
                actor, item = idle.pop(), queue.popleft()
                busy[actor.make.remote(item)] = (actor, item)
            while idle:  # idle actors would occupy cores that busy ones need
                ray.kill(idle.pop())
            if not busy:
                return
            for reference in ray.wait(list(busy), timeout=POLL_INTERVAL)[0]:
                actor, item = busy.pop(reference)
                try:
                    result: ResultT = ray.get(reference)
                except RayError as error:
                    idle.append(_new_actor(worker))
                    yield from retries.on_death(item, type(error).__name__)
                    if not retries.is_given_up(item):
                        queue.appendleft(item)
                    retries.check()
                    continue
                retries.on_success()
                idle.append(actor)
                yield result


class RayWorker:
    """An actor: it creates one worker in its process, and makes the results of items."""

    def __init__(self, worker: Callable[[], Worker[Any, Any]]) -> None:
        self._worker = worker()

    def make(self, item: object) -> object:
        return self._worker.make(item)


def _new_actor(worker: Callable[[], Worker[ItemT, ResultT]]) -> ActorHandle:
    """Start an actor with one core and one thread for linear algebra."""
    options = {"num_cpus": 1, "runtime_env": {"env_vars": {"OMP_NUM_THREADS": "1"}}}
    actor: ActorHandle = ray.remote(RayWorker).options(**options).remote(worker)
    return actor
