"""A task in a page: an episode from a seed, the next or a random one, its variations, its demonstration."""

from __future__ import annotations

import secrets

from viser import GuiEvent, Icon, ViserServer

from rlbench_pin.builder.contracts import Leg, Recording
from rlbench_pin.builder.playback.live.feed import Feed
from rlbench_pin.builder.playback.live.moments import Moments
from rlbench_pin.builder.playback.live.page import LivePage
from rlbench_pin.builder.playback.live.worker import Worker
from rlbench_pin.builder.playback.recorder import record_demonstration, record_reset
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.tasks import Task
from rlbench_pin.values import LARGEST_SEED

_RANDOM = 2**31
"""Random seeds are below."""


class TaskView:
    """Resets and demonstrates one task, in a thread of its own, and shows what it is asked for.

    Args:
        server: Serves the page.
        task: The task.
        seed: Seed of the first episode.
        variation: Its variation.
    """

    def __init__(self, server: ViserServer, task: type[Task], seed: int = 0, variation: int = 0) -> None:
        self._task, self._start = task, (seed, variation)
        self._environment: Environment | None = None
        self._loaded: TaskEnvironment | None = None
        self._moments: Moments | None = None
        self.page = LivePage(server, lambda: self._build(server), self._look)
        self.worker = Worker(self.page.fail, self._shut_down)
        self.page.say(task.get_name(), "is being loaded.")
        self.worker.ask("reset", self._reset)

    def _build(self, server: ViserServer) -> None:
        gui = server.gui
        seed, variation = self._start
        with gui.add_folder("Episode"):
            self._seed = gui.add_number("Seed", seed, min=0, max=LARGEST_SEED, step=1)
            moves = gui.add_button_group("Go to", ("before", "next", "random"))
            self._variation = gui.add_dropdown("Variation", (str(variation),), initial_value=str(variation))
            demonstrate = gui.add_button("Play the demonstration", icon=Icon.ROBOT)
        self._seed.on_update(self._chosen)
        self._variation.on_update(self._chosen)
        moves.on_click(lambda event: self._move(event.target.value))
        demonstrate.on_click(lambda _: self.demonstrate())

    # What somebody does ----------------------------------------------------------------------------------------------

    @property
    def episode(self) -> tuple[int, int]:
        """Seed and variation that are chosen."""
        return int(self._seed.value), int(self._variation.value)

    def reset(self, seed: int) -> None:
        """Start the episode of a seed, instead of what is under way."""
        self._seed.value = min(max(seed, 0), LARGEST_SEED)  # type: ignore[misc]
        self.worker.ask("reset", self._reset, instead=True)

    def demonstrate(self) -> None:
        """Play the demonstration of the chosen episode, instead of what is under way."""
        self.worker.ask("demonstrate", self._demonstrate, instead=True)

    def close(self) -> None:
        """End the thread and free the world."""
        self.page.player.close()
        self.worker.close()

    def _move(self, where: str) -> None:
        seed, _ = self.episode
        self.reset({"before": seed - 1, "next": seed + 1}.get(where, secrets.randbelow(_RANDOM)))

    def _chosen(self, event: GuiEvent) -> None:
        if event.client is not None:
            self.reset(self.episode[0])

    def _look(self) -> None:
        self.worker.ask("look", self._take_pictures)

    # In the thread ---------------------------------------------------------------------------------------------------

    def _reset(self) -> None:
        loaded, moments = self._parts()
        recording = record_reset(loaded, *self.episode)
        moments.clear()
        moments.keep()
        self._tell(recording)
        self.page.show_scene(loaded.world.spec, recording.added)
        self.page.player.load(recording)

    def _demonstrate(self) -> None:
        loaded, moments = self._parts()
        feed = Feed(self.page, loaded.runtime, moments, self.worker.check)
        waypoints = max(len(loaded.task.get_waypoints()), 1)

        with self.page.computing(self._head()) as progress:

            def on_leg(leg: Leg) -> None:
                feed.leg(leg)
                progress(feed.legs / (waypoints + 1))

            recording = record_demonstration(loaded, *self.episode, feed.frame, on_leg)
        self._tell(recording)
        feed.finish(recording)
        self._look()

    def _head(self) -> str:
        seed, variation = self.episode
        return f"{self._task.get_name()}, seed {seed}, variation {variation}:"

    def _tell(self, recording: Recording) -> None:
        failed = recording.failure is not None
        self.page.say(self._head(), recording.instruction or "no start was found.", wrong=failed)

    def _take_pictures(self) -> None:
        _, moments = self._parts()
        if pictures := moments.pictures(self.page.player.timeline.index):
            self.page.show_pictures(pictures)

    def _parts(self) -> tuple[TaskEnvironment, Moments]:
        """Return the task and what is kept of it; the first time it is loaded."""
        if self._loaded is None or self._moments is None:
            if self._environment is None:
                self._environment = make_environment(low_dim_config())
            self._loaded = self._environment.get_task(self._task)
            self._moments = Moments(self._loaded.runtime)
            self._variation.options = tuple(str(number) for number in range(self._loaded.variation_count()))
        return self._loaded, self._moments

    def _shut_down(self) -> None:
        if self._environment is not None:
            self._environment.shutdown()
