"""A dataset in a page: any stored demonstration, played again, to scrub through."""

from __future__ import annotations

from pathlib import Path

from viser import GuiEvent, ViserServer

from rlbench_pin.builder.contracts import Frame
from rlbench_pin.builder.playback.live.feed import Feed
from rlbench_pin.builder.playback.live.moments import Moments
from rlbench_pin.builder.playback.live.page import LivePage
from rlbench_pin.builder.playback.live.worker import Worker
from rlbench_pin.builder.playback.replaying import recording_of_demo
from rlbench_pin.datasets import Inspector, counted_demo, counted_files, stored_tasks
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import LOW_DIM
from rlbench_pin.tasks import OwnTasks, stored_task
from rlbench_pin.values import as_flag, as_path


class DatasetView:
    """Plays stored demonstrations again, in a thread of its own, and shows what it is asked for.

    Args:
        server: Serves the page.
        root: Folder of the dataset.
        own: Tasks that the user named files of, by name; they go before all others.
        trust_task_files: Whether task files that the dataset keeps may be run.

    Raises:
        DatasetError: The folder holds no demonstrations.
        UntrustedTaskFile: The first task is code that came with the dataset, and nobody said that it may be run.
    """

    def __init__(
        self, server: ViserServer, root: Path | str, own: OwnTasks | None = None, trust_task_files: bool = False
    ) -> None:
        self._root, self._own = as_path(root, "root"), own
        self._trusted = as_flag(trust_task_files, "trust_task_files")
        self._files = {task: counted_files(self._root, task) for task in stored_tasks(self._root, at_least_one=True)}
        self._files = {task: files for task, files in self._files.items() if files}
        if not self._files:
            raise DatasetError(f"'{self._root}' holds no demonstrations. `rlbench-pin record` makes some.")
        stored_task(self._root, next(iter(self._files)), self._own, self._trusted)
        self._environment: Environment | None = None
        self._loaded: tuple[str, TaskEnvironment, Moments] | None = None
        self.page = LivePage(server, lambda: self._build(server), self._look)
        self.worker = Worker(self.page.fail, self._shut_down)
        self.open(next(iter(self._files)), 0)

    def _build(self, server: ViserServer) -> None:
        gui, tasks = server.gui, tuple(self._files)
        with gui.add_folder("Stored demonstrations"):
            self._task = gui.add_dropdown("Task", tasks, initial_value=tasks[0])
            self._number = gui.add_number("Episode", 0, min=0, max=len(self._files[tasks[0]]) - 1, step=1)
            moves = gui.add_button_group("Go to", ("before", "next"))
        self._task.on_update(lambda event: self._chosen(event, 0))
        self._number.on_update(lambda event: self._chosen(event, int(self._number.value)))
        moves.on_click(lambda event: self._move(1 if event.target.value == "next" else -1))

    # What somebody does ----------------------------------------------------------------------------------------------

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks that have demonstrations."""
        return tuple(self._files)

    def open(self, task: str, number: int) -> None:
        """Show the demonstration of a number, from 0 in natural order, instead of what is under way."""
        last = len(self._files[task]) - 1
        self._number.max = last
        self._number.value = min(max(number, 0), last)  # type: ignore[misc]
        self.worker.ask("play", self._play, instead=True)

    def close(self) -> None:
        """End the thread and free the world."""
        self.page.player.close()
        self.worker.close()

    def _move(self, by: int) -> None:
        self.open(self._task.value, int(self._number.value) + by)

    def _chosen(self, event: GuiEvent, number: int) -> None:
        if event.client is not None:
            self.open(self._task.value, number)

    def _look(self) -> None:
        self.worker.ask("look", self._take_pictures)

    # In the thread ---------------------------------------------------------------------------------------------------

    def _play(self) -> None:
        name, number = self._task.value, int(self._number.value)
        path, sha256 = list(self._files[name].items())[number]
        head = f"{name}, {path.relative_to(self._root)}:"
        with self.page.computing(head) as progress:
            with Inspector() as inspector:
                demo = counted_demo(path, sha256, LOW_DIM, inspector=inspector)
            task, moments = self._task_of(name)
            feed = Feed(self.page, task.runtime, moments, self.worker.check)

            def on_frame(frame: Frame) -> None:
                feed.frame(frame)
                progress(feed.frames / len(demo))

            recording = recording_of_demo(task, demo, on_frame)
            feed.finish(recording)
        self.page.say(head, recording.instruction, wrong=recording.failure is not None)
        self._look()

    def _task_of(self, name: str) -> tuple[TaskEnvironment, Moments]:
        if self._environment is None:
            self._environment = make_environment(low_dim_config())
        if self._loaded is None or self._loaded[0] != name:
            self._loaded = None
            task = self._environment.get_task(stored_task(self._root, name, self._own, self._trusted))
            self._loaded = (name, task, Moments(task.runtime))
        return self._loaded[1:]

    def _take_pictures(self) -> None:
        if self._loaded is not None and (pictures := self._loaded[2].pictures(self.page.player.timeline.index)):
            self.page.show_pictures(pictures)

    def _shut_down(self) -> None:
        if self._environment is not None:
            self._environment.shutdown()
