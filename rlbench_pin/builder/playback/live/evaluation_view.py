"""An evaluation in a page: the episodes of a policy as they are played, and the latest ones to look at again."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from viser import GuiEvent, ViserServer

from rlbench_pin.builder.contracts import Failure, Frame, Leg, Recording
from rlbench_pin.builder.pictures import camera_pictures
from rlbench_pin.builder.playback.live.feed import Feed
from rlbench_pin.builder.playback.live.page import LivePage
from rlbench_pin.builder.playback.recorder import FrameRecorder
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.evaluation.results.records import EpisodeRecord
from rlbench_pin.evaluation.run import EpisodeItem, EpisodeRunner, EvaluationConfig
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.scene.spec import SceneSpec

KEPT = 20
"""Episodes that can be looked at again."""
_NOW = "the one being played"
_PICTURES = 0.2
"""Time between two rounds of pictures [s]."""


@dataclass(frozen=True, eq=False)
class _Played:
    """An episode that is over."""

    title: str
    spec: SceneSpec
    recording: Recording


class EvaluationView:
    """Shows the episodes that a `LiveRunner` plays in the thread that calls `evaluate`; changes nothing in them.

    Args:
        server: Serves the page.
    """

    def __init__(self, server: ViserServer) -> None:
        self._lock = threading.RLock()
        self._played: dict[str, _Played] = {}
        self._shown, self._now, self._pictures_at = _NOW, "", 0.0
        self.page = LivePage(server, lambda: self._build(server), lambda: None, cameras=False)
        self.page.say("Evaluation", "is about to begin.")

    def _build(self, server: ViserServer) -> None:
        gui = server.gui
        with gui.add_folder("Evaluation"):
            self._choice = gui.add_dropdown("Episode", (_NOW,), initial_value=_NOW)
            self._slow = gui.add_checkbox("Real time", False, hint="Wait, so that episodes take as long as they would")
        self._choice.on_update(self._chosen)

    def close(self) -> None:
        """Stop showing."""
        self.page.player.close()

    # Episodes --------------------------------------------------------------------------------------------------------

    @contextmanager
    def watching(self, item: EpisodeItem, task: TaskEnvironment) -> Iterator[None]:
        """Show a block, in which an episode is played."""
        watch = _Watch(self, task)
        with self._lock:
            self._now = _title(item)
        with FrameRecorder(task.runtime, watch.frame, watch.leg) as recorder:
            try:
                yield
            finally:
                with self._lock:
                    self._played[self._now] = _Played(self._now, task.world.spec, recorder.recording())

    def ended(self, item: EpisodeItem, record: EpisodeRecord) -> None:
        """Take note of how the latest episode ended."""
        with self._lock:
            played = self._played.pop(_title(item), None)
            if played is None:  # it did not even start
                self.page.say(_title(item), f"was not played: {record.fault_detail}", wrong=True)
                return
            recording = replace(played.recording, failure=None if record.success else _failure(record))
            title = f"{played.title}: {'success' if record.success else record.end}"
            self._played[title] = replace(played, title=title, recording=recording)
            while len(self._played) > KEPT:
                self._played.pop(next(iter(self._played)))
            self._choice.options = (_NOW, *reversed(self._played))
            if self._shown == _NOW:
                self.page.player.finish(recording)
                self.page.say(title, recording.instruction, wrong=not record.success)

    @property
    def episodes(self) -> tuple[str, ...]:
        """What was played, the latest first, each with how it ended."""
        with self._lock:
            return tuple(reversed(self._played))

    @contextmanager
    def turn(self) -> Iterator[bool]:
        """Say for the duration of a block whether somebody wants to see the episode under way."""
        with self._lock:
            yield self._shown == _NOW

    @property
    def words(self) -> str:
        """What is being played."""
        return self._now

    def wait(self, frame: Frame, began: float) -> None:
        """Wait until it is time for the next frame, where somebody wants real time."""
        if self._slow.value:
            time.sleep(max(0.0, began + frame.time - time.monotonic()))

    def take_pictures(self, task: TaskEnvironment) -> None:
        """Show what the cameras see, where somebody wants to and has not seen it just now."""
        if self.page.pictures_wanted and time.monotonic() - self._pictures_at > _PICTURES:
            self.page.show_pictures(camera_pictures(task.runtime))
            self._pictures_at = time.monotonic()

    def _chosen(self, event: GuiEvent) -> None:
        if event.client is None:
            return
        with self._lock:
            self._shown = self._choice.value
            played = self._played.get(self._shown)
            if played is not None:
                self.page.say(played.title, played.recording.instruction, wrong=played.recording.failure is not None)
                self.page.show_scene(played.spec, played.recording.added)
                self.page.player.load(played.recording)


class _Watch:
    """Brings one episode to the page, again from its beginning where somebody has looked at another one meanwhile."""

    def __init__(self, view: EvaluationView, task: TaskEnvironment) -> None:
        self._view, self._task = view, task
        self._frames: list[Frame] = []
        self._legs: list[Leg] = []
        self._feed: Feed | None = None
        self._began = time.monotonic()

    def frame(self, frame: Frame) -> None:
        """Show the next frame."""
        self._frames.append(frame)
        with self._view.turn() as wanted:
            if not wanted:
                self._feed = None
                return
            if self._feed is None:
                self._begin_feed()
            else:
                self._feed.frame(frame)
        self._view.take_pictures(self._task)
        self._view.wait(frame, self._began)

    def _begin_feed(self) -> None:
        self._feed = Feed(self._view.page, self._task.runtime, follow=True)
        self._view.page.say(self._view.words, "is being played.")
        for seen in self._frames:
            self._feed.frame(seen)
        for leg in self._legs:
            self._feed.leg(leg)

    def leg(self, leg: Leg) -> None:
        """Show that a leg begins."""
        self._legs.append(leg)
        with self._view.turn() as wanted:
            if wanted and self._feed is not None:
                self._feed.leg(leg)


class LiveRunner(EpisodeRunner):
    """Plays episodes as `EpisodeRunner` does, before the eyes of a view.

    Args:
        config: What is evaluated.
        view: Where they are shown.
    """

    def __init__(self, config: EvaluationConfig, view: EvaluationView) -> None:
        super().__init__(config)
        self._view = view

    def make(self, item: EpisodeItem) -> EpisodeOutcome:
        """Play an episode, and show it."""
        outcome = self.play(item, lambda task: self._view.watching(item, task))
        self._view.ended(item, outcome.record)
        return outcome


def _title(item: EpisodeItem) -> str:
    return f"{item.name}, seed {item.seed}, variation {item.variation}"


def _failure(record: EpisodeRecord) -> Failure:
    fault = f" {record.fault}: {record.fault_detail}" if record.fault else ""
    refused = ", ".join(f"{count} x {cause}" for cause, count in record.refused.items())
    refusals = f" Refused actions: {refused}." if refused else ""
    return Failure(
        f"The episode ended after {record.steps} actions and {record.seconds:.2f} s by '{record.end}'.{fault}{refusals}"
    )
