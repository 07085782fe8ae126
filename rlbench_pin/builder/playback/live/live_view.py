"""A read-only page on this machine: opened with what it shows, closed with it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Generic, Protocol, TypeVar

from viser import ViserServer

from rlbench_pin.builder.playback.live.dataset_view import DatasetView
from rlbench_pin.builder.playback.live.evaluation_view import EvaluationView
from rlbench_pin.builder.playback.live.task_view import TaskView
from rlbench_pin.builder.server import LocalServer
from rlbench_pin.tasks import OwnTasks, Task


class View(Protocol):
    """What a page shows."""

    def close(self) -> None:
        """Stop, and free what it holds."""


ViewT = TypeVar("ViewT", bound=View)


class LiveView(Generic[ViewT]):
    """A page at an address of this machine, behind a random token; a context manager.

    Args:
        show: Draws what the page shows.
        title: What the page is called.
        port: Where it listens; 0 takes a free one.

    Attributes:
        view: What it shows.

    Raises:
        ServerError: The port is in use.
    """

    def __init__(self, show: Callable[[ViserServer], ViewT], title: str, port: int = 0) -> None:
        self._server = LocalServer(port, title=title)
        try:
            self.view = show(self._server.viser)
        except BaseException:
            self._server.stop()
            raise

    @staticmethod
    def of_task(task: type[Task], seed: int = 0, variation: int = 0, port: int = 0) -> LiveView[TaskView]:
        """Open a page that shows episodes of a task.

        Args:
            task: The task.
            seed: Seed of the first episode.
            variation: Its variation.
            port: As for the page.
        """
        return LiveView(lambda server: TaskView(server, task, seed, variation), task.get_name(), port)

    @staticmethod
    def of_dataset(
        root: Path | str, own: OwnTasks | None = None, trust_task_files: bool = False, port: int = 0
    ) -> LiveView[DatasetView]:
        """Open a page that shows stored demonstrations; arguments and errors are those of `DatasetView`."""
        return LiveView(lambda server: DatasetView(server, root, own, trust_task_files), str(root), port)

    @staticmethod
    def of_evaluation(title: str, port: int = 0) -> LiveView[EvaluationView]:
        """Open a page that shows what a `LiveRunner` plays."""
        return LiveView(EvaluationView, title, port)

    @property
    def address(self) -> str:
        """What a browser opens."""
        return self._server.address

    def close(self) -> None:
        """Close the page."""
        self.view.close()
        self._server.stop()

    def __enter__(self) -> LiveView[ViewT]:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self.close()
