"""Pages that show a task, stored demonstrations or an evaluation, without an editor."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.datasets import Inspector, counted_demo, counted_files, stored_tasks
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DatasetError, MissingExtra, RlbenchPinError
from rlbench_pin.evaluation.results.records import EpisodeRecord
from rlbench_pin.evaluation.run import EpisodeItem, EpisodeRunner, EvaluationConfig
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.observation import LOW_DIM
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.tasks import OwnTasks, Task, stored_task
from rlbench_pin.values import LARGEST_SEED, as_flag, as_path
from rlbench_pin.viewer.job_thread import Job, JobThread
from rlbench_pin.viewer.recording import (
    Failure,
    Frame,
    FrameRecorder,
    Recording,
    Segment,
    camera_images,
    record_demonstration,
    record_reset,
    recording_of_demo,
    success_texts,
)

try:
    from viser import GuiEvent, Icon, ViserServer

    from rlbench_pin.viewer.figures import Figures
    from rlbench_pin.viewer.player import Player
    from rlbench_pin.viewer.readout import framed, images_html
except ModuleNotFoundError as _error:
    raise MissingExtra("The live view", _error.name or "viser", "builder") from _error

_EYE, _TARGET = (1.3, 0.9, 1.65), (0.15, 0.0, 0.95)
"""Position and target of the camera of a new tab [m]: over the table from the left of the robot."""
_LEFT, _RIGHT = 300.0, 360.0
"""Widths of the panels [px]."""
_RANDOM = 2**31
"""Upper bound of random seeds."""
KEPT = 20
"""Maximum number of stored episodes of an evaluation."""
_NOW = "the one being played"
_IMAGES = 0.2
"""Time between two rounds of camera images during an evaluation [s]."""


class LivePage:
    """Common parts of all views: the scene, the player, the camera images and a line of text.

    Args:
        server: Server of the page.
        build_controls: Function that adds the controls of the view, above the player.
        on_look: Function that is called when camera images are needed: for another frame, or after they were switched on.
        cameras: Whether the images are initially switched on.

    Attributes:
        player: Shows recordings.
    """

    def __init__(self, server: ViserServer, build_controls: Job, on_look: Job, cameras: bool = True) -> None:
        gui, self._on_look = server.gui, on_look
        gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        server.initial_camera.position, server.initial_camera.look_at = _EYE, _TARGET
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_RIGHT)
        self._figures = Figures(server.scene)
        self._words = gui.add_html("")
        self._progress = gui.add_progress_bar(0.0, visible=False)
        build_controls()
        self.player = Player(gui, self._figures, lambda index, frame: self._look(), server.atomic)
        side = gui.add_panel()
        with side.add_tab("Cameras"):
            self._switch = gui.add_checkbox("Show", cameras, hint="Images take a few milliseconds each")
            self._images = gui.add_html("")
        self._switch.on_update(lambda _: self._switched())
        side.dock_left()
        side.set_width(_LEFT)

    def _look(self) -> None:
        """Request camera images, if they are switched on."""
        if self.images_wanted:
            self._on_look()

    def _switched(self) -> None:
        self._look()
        if not self.images_wanted:
            self._images.content = ""

    @property
    def images_wanted(self) -> bool:
        """Whether the camera images are switched on."""
        return bool(self._switch.value)

    def show_images(self, images: Mapping[str, NDArray[np.uint8]]) -> None:
        """Show camera images (h, w, 3) by name, if they are switched on."""
        if self.images_wanted:
            self._images.content = images_html(images)

    def show_scene(self, spec: SceneSpec, added: Sequence[BodySpec] = ()) -> None:
        """Draw the bodies of a scene, and those that an episode adds to it."""
        faults = self._figures.show(spec.model_copy(update={"body": (*spec.body, *added)}))
        if faults:
            self.say("Not drawn:", "; ".join(f"{name}: {why}" for name, why in faults.items()), wrong=True)

    @property
    def words(self) -> str:
        """The text above the controls, as HTML."""
        return self._words.content

    def say(self, title: str, text: str, *, wrong: bool = False) -> None:
        """Replace the text above the controls."""
        color = "#d93025" if wrong else "inherit"
        self._words.content = framed(f'<div class="words" style="color:{color}"><b>{escape(title)}</b> {escape(text)}</div>')

    @contextmanager
    def computing(self, title: str) -> Iterator[Callable[[float], None]]:
        """Show a progress bar during a `with` block; yields a function that sets it, from 0 to 1."""
        self.say(title, "is being computed. The 3D view is live meanwhile; camera images follow.")
        self._show_progress(0.0)
        self._progress.visible = True
        try:
            yield self._show_progress
        finally:
            self._progress.visible = False

    def _show_progress(self, share: float) -> None:
        self._progress.value = round(100.0 * min(max(share, 0.0), 1.0))  # type: ignore[misc]

    def fail(self, error: Exception) -> None:
        """Show an error."""
        kind = "" if isinstance(error, RlbenchPinError) else f"{type(error).__name__}: "
        self.say("Failed:", f"{kind}{error}", wrong=True)


class _Moments:
    """The state of a world at each frame of a recording; only for the thread of the world."""

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._moments: list[dict[str, np.ndarray]] = []

    def clear(self) -> None:
        self._moments.clear()

    def keep(self) -> None:
        """Store the state of the world for the next frame."""
        self._moments.append(self._runtime.world.arrays(exact=False))

    def images(self, index: int) -> dict[str, np.ndarray]:
        """Restore the world at a frame and return the images of the five cameras; empty if the frame is not stored."""
        if not 0 <= index < len(self._moments):
            return {}
        self._runtime.world.set_arrays(self._moments[index])
        return camera_images(self._runtime)


class _Feed:
    """Shows a simulation in a page during the recording; only for the thread of the simulation.

    Args:
        page: The page.
        runtime: The running task.
        moments: Stores the states of the world; None stores none.
        check: Function that is called at each frame; an exception ends the simulation.
        follow: Show each new frame; otherwise play at the chosen speed.

    Attributes:
        segments: Number of segments so far.
        frames: Number of frames so far.
    """

    def __init__(
        self,
        page: LivePage,
        runtime: Runtime,
        moments: _Moments | None = None,
        check: Job = lambda: None,
        follow: bool = False,
    ) -> None:
        self._page, self._runtime, self._moments, self._check, self._follow = page, runtime, moments, check, follow
        self.segments, self.frames = 0, 0
        if moments is not None:
            moments.clear()

    def frame(self, frame: Frame) -> None:
        self._check()
        if self.frames == 0:
            world = self._runtime.world
            self._page.show_scene(world.spec, tuple(world.spawned.values()))
            instruction = next(iter(self._runtime.instructions), "")
            self._page.player.begin(success_texts(self._runtime.task), instruction, follow=self._follow)
        if self._moments is not None:
            self._moments.keep()
        self.frames += 1
        self._page.player.add(frame)

    def segment(self, segment: Segment) -> None:
        self.segments += 1
        self._page.player.add_segment(segment)

    def finish(self, recording: Recording) -> None:
        if self.frames == 0:  # no start was found
            self._page.player.load(recording)
        else:
            self._page.player.finish(recording)


class _WorldView:
    """A page with a world that is simulated in a separate thread.

    Attributes:
        page: The page in the browser.
        worker: The thread of the simulation.
    """

    def __init__(self, server: ViserServer) -> None:
        self._environment: Environment | None = None
        self._loaded: tuple[TaskEnvironment, _Moments] | None = None
        self.page = LivePage(server, lambda: self._build(server), self._look)
        self.worker = JobThread("simulation", self.page.fail, self._shut_down)

    def _build(self, server: ViserServer) -> None:
        """Add the controls of the view."""
        raise NotImplementedError

    def _look(self) -> None:
        self.worker.post(self._take_images, "look")

    def close(self) -> None:
        """End the thread and close the world."""
        self.page.player.close()
        self.worker.stop()

    # In the thread ---------------------------------------------------------------------------------------------------

    def _load(self, task: type[Task]) -> tuple[TaskEnvironment, _Moments]:
        self._loaded = None
        if self._environment is None:
            self._environment = make_environment(low_dim_config())
        loaded = self._environment.get_task(task)
        self._loaded = (loaded, _Moments(loaded.runtime))
        return self._loaded

    def _take_images(self) -> None:
        if self._loaded is not None and (images := self._loaded[1].images(self.page.player.timeline.index)):
            self.page.show_images(images)

    def _shut_down(self) -> None:
        if self._environment is not None:
            self._environment.shutdown()


class TaskView(_WorldView):
    """Shows episodes and demonstrations of one task, by seed and variation.

    Args:
        server: Server of the page.
        task: The task.
        seed: Seed of the first episode.
        variation: Variation of the first episode.
    """

    def __init__(self, server: ViserServer, task: type[Task], seed: int = 0, variation: int = 0) -> None:
        self._task, self._start = task, (seed, variation)
        super().__init__(server)
        self.page.say(task.get_name(), "is being loaded.")
        self.worker.post(self._reset, "reset")

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

    @property
    def episode(self) -> tuple[int, int]:
        """Chosen seed and variation."""
        return int(self._seed.value), int(self._variation.value)

    def reset(self, seed: int) -> None:
        """Start the episode of a seed, and end the current job."""
        self._seed.value = min(max(seed, 0), LARGEST_SEED)  # type: ignore[misc]
        self.worker.post(self._reset, "reset", instead=True)

    def demonstrate(self) -> None:
        """Execute the demonstration of the chosen episode, and end the current job."""
        self.worker.post(self._demonstrate, "demonstrate", instead=True)

    def _move(self, where: str) -> None:
        seed, _ = self.episode
        self.reset({"before": seed - 1, "next": seed + 1}.get(where, secrets.randbelow(_RANDOM)))

    def _chosen(self, event: GuiEvent) -> None:
        if event.client is not None:
            self.reset(self.episode[0])

    # In the thread ---------------------------------------------------------------------------------------------------

    def _reset(self) -> None:
        task, moments = self._parts()
        recording = record_reset(task, *self.episode)
        moments.clear()
        moments.keep()
        self._show_result(recording)
        self.page.show_scene(task.world.spec, recording.added)
        self.page.player.load(recording)

    def _demonstrate(self) -> None:
        task, moments = self._parts()
        feed = _Feed(self.page, task.runtime, moments, self.worker.check)
        waypoints = max(len(task.task.get_waypoints()), 1)
        with self.page.computing(self._head()) as progress:

            def on_segment(segment: Segment) -> None:
                feed.segment(segment)
                progress(feed.segments / (waypoints + 1))

            recording = record_demonstration(task, *self.episode, feed.frame, on_segment)
        self._show_result(recording)
        feed.finish(recording)
        self._look()

    def _parts(self) -> tuple[TaskEnvironment, _Moments]:
        if self._loaded is None:
            task, _ = self._loaded = self._load(self._task)
            self._variation.options = tuple(str(number) for number in range(task.variation_count()))
        return self._loaded

    def _head(self) -> str:
        seed, variation = self.episode
        return f"{self._task.get_name()}, seed {seed}, variation {variation}:"

    def _show_result(self, recording: Recording) -> None:
        failed = recording.failure is not None
        self.page.say(self._head(), recording.instruction or "no start was found.", wrong=failed)


class DatasetView(_WorldView):
    """Replays the stored demonstrations of a dataset.

    Args:
        server: Server of the page.
        root: Folder of the dataset.
        own: Tasks from files of the user, by name; they take precedence.
        trust_task_files: Whether to allow execution of task files in the dataset.

    Raises:
        DatasetError: The folder contains no demonstrations.
        UntrustedTaskFile: The first task is a task file in the dataset, whose execution is not allowed.
    """

    def __init__(
        self, server: ViserServer, root: Path | str, own: OwnTasks | None = None, trust_task_files: bool = False
    ) -> None:
        self._root, self._own = as_path(root, "root"), own
        self._trusted = as_flag(trust_task_files, "trust_task_files")
        self._files = {task: counted_files(self._root, task) for task in stored_tasks(self._root, at_least_one=True)}
        self._files = {task: files for task, files in self._files.items() if files}
        if not self._files:
            raise DatasetError(f"'{self._root}' contains no demonstrations. Record some with `rlbench-pin record`.")
        stored_task(self._root, next(iter(self._files)), self._own, self._trusted)
        self._loaded_name = ""
        super().__init__(server)
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

    def open(self, task: str, number: int) -> None:
        """Show a demonstration of a task, and end the current job; `number` counts from 0 in natural order and is clamped."""
        last = len(self._files[task]) - 1
        self._number.max = last
        self._number.value = min(max(number, 0), last)  # type: ignore[misc]
        self.worker.post(self._play, "play", instead=True)

    def _move(self, by: int) -> None:
        self.open(self._task.value, int(self._number.value) + by)

    def _chosen(self, event: GuiEvent, number: int) -> None:
        if event.client is not None:
            self.open(self._task.value, number)

    def _play(self) -> None:
        """Replay the chosen demonstration; runs in the thread."""
        name, number = self._task.value, int(self._number.value)
        path, sha256 = list(self._files[name].items())[number]
        head = f"{name}, {path.relative_to(self._root)}:"
        with self.page.computing(head) as progress:
            with Inspector() as inspector:
                demo = counted_demo(path, sha256, LOW_DIM, inspector=inspector)
            if self._loaded is None or self._loaded_name != name:
                self._loaded = self._load(stored_task(self._root, name, self._own, self._trusted))
                self._loaded_name = name
            task, moments = self._loaded
            feed = _Feed(self.page, task.runtime, moments, self.worker.check)

            def on_frame(frame: Frame) -> None:
                feed.frame(frame)
                progress(feed.frames / len(demo))

            recording = recording_of_demo(task, demo, on_frame)
            feed.finish(recording)
        self.page.say(head, recording.instruction, wrong=recording.failure is not None)
        self._look()


@dataclass(frozen=True, eq=False)
class _Played:
    """A completed episode of an evaluation."""

    title: str
    spec: SceneSpec
    recording: Recording


class EvaluationView:
    """Shows the episodes that a `LiveRunner` executes in the thread that calls `evaluate`, without an effect on them.

    Args:
        server: Server of the page.
    """

    def __init__(self, server: ViserServer) -> None:
        self._lock = threading.RLock()
        self._played: dict[str, _Played] = {}
        self._shown, self._now, self._images_at = _NOW, "", 0.0
        self.page = LivePage(server, lambda: self._build(server), lambda: None, cameras=False)
        self.page.say("Evaluation", "is starting.")

    def _build(self, server: ViserServer) -> None:
        gui = server.gui
        with gui.add_folder("Evaluation"):
            self._choice = gui.add_dropdown("Episode", (_NOW,), initial_value=_NOW)
            self._slow = gui.add_checkbox("Real time", False, hint="Wait, so that episodes play in real time")
        self._choice.on_update(self._chosen)

    def close(self) -> None:
        """Close the player of the page."""
        self.page.player.close()

    @contextmanager
    def watching(self, item: EpisodeItem, task: TaskEnvironment) -> Iterator[None]:
        """Show the episode that is executed in a `with` block."""
        began, frames, segments = time.monotonic(), list[Frame](), list[Segment]()
        feed: _Feed | None = None

        def on_frame(frame: Frame) -> None:
            nonlocal feed
            frames.append(frame)
            with self._lock:
                if self._shown != _NOW:
                    feed = None
                    return
                if feed is not None:
                    feed.frame(frame)
                else:  # first frame, or another episode was shown in the meantime
                    feed = _Feed(self.page, task.runtime, follow=True)
                    self.page.say(self._now, "is being played.")
                    for seen in frames:
                        feed.frame(seen)
                    for segment in segments:
                        feed.segment(segment)
            self._take_images(task)
            if self._slow.value:
                time.sleep(max(0.0, began + frame.time - time.monotonic()))

        def on_segment(segment: Segment) -> None:
            segments.append(segment)
            with self._lock:
                if feed is not None and self._shown == _NOW:
                    feed.segment(segment)

        with self._lock:
            self._now = _title(item)
        with FrameRecorder(task.runtime, on_frame, on_segment) as recorder:
            try:
                yield
            finally:
                with self._lock:
                    self._played[self._now] = _Played(self._now, task.world.spec, recorder.recording())

    def ended(self, item: EpisodeItem, record: EpisodeRecord) -> None:
        """Store the last executed episode with its result."""
        with self._lock:
            played = self._played.pop(_title(item), None)
            if played is None:  # the episode did not start
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
        """Titles of the stored episodes with their results, the newest first."""
        with self._lock:
            return tuple(reversed(self._played))

    def _take_images(self, task: TaskEnvironment) -> None:
        if self.page.images_wanted and time.monotonic() - self._images_at > _IMAGES:
            self.page.show_images(camera_images(task.runtime))
            self._images_at = time.monotonic()

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


class LiveRunner(EpisodeRunner):
    """Executes episodes like `EpisodeRunner`, and shows them in a view.

    Args:
        config: The evaluation.
        view: The view that shows them.
    """

    def __init__(self, config: EvaluationConfig, view: EvaluationView) -> None:
        super().__init__(config)
        self._view = view

    def make(self, item: EpisodeItem) -> EpisodeOutcome:
        """Execute an episode, and show it."""
        outcome = self.play(item, lambda task: self._view.watching(item, task))
        self._view.ended(item, outcome.record)
        return outcome


def _title(item: EpisodeItem) -> str:
    """Return the title of an episode in the page."""
    factors = f", {item.factors}" if item.factors else ""
    return f"{item.name}, seed {item.seed}, variation {item.variation}{factors}"


def _failure(record: EpisodeRecord) -> Failure:
    """Return the failure of an episode, with its end, its error and its refused actions."""
    fault = f" {record.fault}: {record.fault_detail}" if record.fault else ""
    refused = ", ".join(f"{count} x {cause}" for cause, count in record.refused.items())
    refusals = f" Refused actions: {refused}." if refused else ""
    return Failure(
        f"The episode ended after {record.steps} actions and {record.seconds:.2f} s by '{record.end}'.{fault}{refusals}"
    )
