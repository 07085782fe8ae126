"""A player of recordings in a page: timeline, controls, conditions, joint plots, and the scene at the shown frame."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace

import numpy as np
from viser import GuiApi, GuiEvent, Icon

from rlbench_pin.viewer.figures import Figures
from rlbench_pin.viewer.readout import conditions_html, failure_html, framed, instant_html, joints_html, now_style, plot_html
from rlbench_pin.viewer.recording import Frame, Recording, Segment

NEAREST = "nearest reachable pose"
"""Name of the ghost at the nearest reachable pose."""
SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Simulated seconds per second of real time."""
_RED, _AMBER = (230, 40, 40), (255, 176, 0)
_TICK = 1.0 / 30.0
"""Time between two frames in the page [s]."""
_PLOTS = (("Positions", "rad", "arm"), ("Velocities", "rad/s", "velocities"), ("Torques", "Nm", "torques"))
"""Plots of the joints: title, unit and field of `Frame`."""


@dataclass
class Timeline:
    """Playback state of a recording: the times of its frames, and the shown frame."""

    times: list[float] = field(default_factory=list)
    """Time of each frame [s], increasing."""
    segments: tuple[int, ...] = ()
    """Index of the first frame of each segment, increasing."""
    index: int = 0
    """Index of the shown frame."""
    playing: bool = False
    """Whether the recording is playing."""
    speed: float = 1.0
    """Simulated seconds per second of real time."""
    growing: bool = False
    """Whether frames can still be added."""
    following: bool = False
    """Whether each added frame is shown."""
    _rest: float = 0.0
    """Simulated time since the shown frame [s]."""

    @property
    def last(self) -> int:
        """Index of the last frame; 0 if there is none."""
        return max(len(self.times) - 1, 0)

    @property
    def share(self) -> float:
        """Time of the shown frame as a fraction of the recording, from 0 to 1."""
        if not self.times or self.times[-1] <= self.times[0]:
            return 0.0
        return (self.times[self.index] - self.times[0]) / (self.times[-1] - self.times[0])

    @property
    def segment(self) -> int | None:
        """Index of the segment of the shown frame; None before the first."""
        begun = [number for number, begins in enumerate(self.segments) if begins <= self.index]
        return begun[-1] if begun else None

    def load(self, times: Sequence[float], segments: Sequence[int] = ()) -> None:
        """Set a recording and show its first frame, paused."""
        self.times, self.segments = list(times), tuple(segments)
        self.index, self.playing, self.following, self.growing, self._rest = 0, False, False, False, 0.0

    def begin(self, follow: bool) -> None:
        """Remove all frames and expect new ones: show the newest if `follow`, else play from the first."""
        self.load(())
        self.growing, self.following, self.playing = True, follow, not follow

    def add(self, time: float) -> None:
        """Append a frame, and show it if `following`."""
        self.times.append(time)
        if self.following:
            self.index = self.last

    def complete(self, times: Sequence[float], segments: Sequence[int]) -> None:
        """Set the complete recording; the shown frame and `playing` do not change."""
        self.times, self.segments, self.growing, self.following = list(times), tuple(segments), False, False
        self.index = min(self.index, self.last)

    def seek(self, index: int) -> None:
        """Show a frame and pause; the index is clamped to the recording."""
        self.index = min(max(index, 0), self.last)
        self.playing, self.following, self._rest = False, False, 0.0

    def jump(self, direction: int) -> None:
        """Go to the next (1) or previous (-1) start of a segment; without one to the end or the start of the recording."""
        if direction > 0:
            self.seek(min((begins for begins in self.segments if begins > self.index), default=self.last))
        else:
            self.seek(max((begins for begins in self.segments if begins < self.index), default=0))

    def play(self) -> None:
        """Play; if the last frame is shown and the recording is complete, start from the first."""
        if self.index >= self.last and not self.growing:
            self.index = 0
        self.playing, self.following, self._rest = self.last > 0 or self.growing, False, 0.0

    def toggle(self) -> None:
        """Pause if playing, else play."""
        if self.playing:
            self.seek(self.index)
        else:
            self.play()

    def advance(self, seconds: float) -> bool:
        """Advance by real time [s] and return whether the shown frame has changed; at the end, pause or wait for frames."""
        if not self.playing or not self.times:
            return False
        before = self.index
        self._rest += seconds * self.speed
        now = self.times[self.index] + self._rest + 1e-9
        while self.index < self.last and self.times[self.index + 1] <= now:
            self.index += 1
        self._rest = now - 1e-9 - self.times[self.index]
        if self.index == self.last:
            self.playing, self._rest = self.growing, 0.0
        return self.index != before


class _Controls:
    """Slider, buttons and keys that change the timeline."""

    def __init__(self, gui: GuiApi, change: Callable[[Callable[[Timeline], None]], None]) -> None:
        self._change = change
        self._slider = gui.add_slider("Frame", 0, 1, 1, 0, hint="Instant that is shown")
        self._slider.on_update(self._slid)
        self._play = gui.add_button("Play", icon=Icon.PLAYER_PLAY)
        self._play.on_click(lambda _: change(Timeline.toggle))
        moves: dict[str, Callable[[Timeline], None]] = {
            "< segment": lambda timeline: timeline.jump(-1),
            "< step": lambda timeline: timeline.seek(timeline.index - 1),
            "step >": lambda timeline: timeline.seek(timeline.index + 1),
            "segment >": lambda timeline: timeline.jump(1),
        }
        gui.add_button_group("Go", tuple(moves)).on_click(lambda event: change(moves[event.target.value]))
        self._speeds = {f"{speed:g}x": speed for speed in SPEEDS}
        speed = gui.add_dropdown("Pace", tuple(self._speeds), initial_value="1x", hint="Simulated seconds per second")
        speed.on_update(self._set_speed)
        keys = (
            ("Play or pause", "space", Timeline.toggle),
            ("Next frame", "arrowright", moves["step >"]),
            ("Frame before", "arrowleft", moves["< step"]),
        )
        self._commands = [gui.add_command(label, hotkey=key, modifier="shift") for label, key, _ in keys]  # type: ignore[arg-type]
        for command, (_, _, action) in zip(self._commands, keys, strict=True):
            command.on_trigger(lambda _, action=action: change(action))  # type: ignore[misc]

    def show(self, timeline: Timeline) -> None:
        last = max(timeline.last, 1)
        if self._slider.max != last:
            self._slider.max = last
        if (disabled := timeline.last == 0) != self._slider.disabled:
            self._slider.disabled = disabled
        self._slider.value = timeline.index  # type: ignore[misc]  # mypy does not see its setter
        label, icon = ("Pause", Icon.PLAYER_PAUSE) if timeline.playing else ("Play", Icon.PLAYER_PLAY)
        if self._play.label != label:
            self._play.label, self._play.icon = label, icon

    def _slid(self, event: GuiEvent) -> None:
        if event.client is not None:  # otherwise the slider follows the timeline
            index = int(event.target.value)
            self._change(lambda timeline: timeline.seek(index))

    def _set_speed(self, event: GuiEvent) -> None:
        def change(timeline: Timeline) -> None:
            timeline.speed = self._speeds[event.target.value]

        self._change(change)

    def remove_keys(self) -> None:
        for command in self._commands:
            command.remove()


class Player:
    """Shows recordings, one at a time; all tabs of a page show the same frame.

    Any thread can call its methods.

    Args:
        gui: Graphical interface of a server, so that all tabs share the controls.
        figures: The drawn scene.
        on_show: Function that is called with index and frame when a frame is shown.
        together: Function that returns a context whose changes the page shows at once, such as `server.atomic`.
    """

    def __init__(
        self,
        gui: GuiApi,
        figures: Figures,
        on_show: Callable[[int, Frame], None] | None = None,
        together: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        self._figures, self._on_show, self._together = figures, on_show, together
        self._lock, self._wake, self._closed = threading.RLock(), threading.Event(), False
        self.timeline = Timeline()
        self._recording, self._frames, self._drawn = Recording((), ()), list[Frame](), 0.0
        self._marked, self._present = False, frozenset[str]()
        self._colors: Mapping[str, tuple[float, float, float, float]] | None = None
        self._shown_conditions: object = None
        self._folder = gui.add_folder("Playback")
        with self._folder:
            self._instant, self._controls = gui.add_html(""), _Controls(gui, self._changed)
            self._failure, self._conditions = gui.add_html("", visible=False), gui.add_html("")
            self._cursor = gui.add_html(now_style(0.0))
            with gui.add_folder("Joints", expand_by_default=False):
                self._numbers, self._plots = gui.add_html(""), [gui.add_html("") for _ in _PLOTS]
        self._refresh()
        threading.Thread(target=self._run, daemon=True, name="player").start()

    @property
    def recording(self) -> Recording:
        """The shown recording, with the frames so far."""
        with self._lock:
            return replace(self._recording, frames=tuple(self._frames))

    def load(self, recording: Recording, *, play: bool = False) -> None:
        """Show a recording from its start.

        Args:
            recording: The recording.
            play: Play it at once.
        """
        with self._lock:
            self._take(recording)
            self.timeline.load(*_timing(recording))
            if play:
                self.timeline.play()
            self._refresh()

    def begin(self, conditions: Sequence[str], instruction: str = "", *, follow: bool = False) -> None:
        """Show a running simulation, whose frames are passed to `add`, until `finish`.

        Args:
            conditions: The success conditions as text.
            instruction: The first instruction of the episode.
            follow: Show each new frame; otherwise play at the chosen speed.
        """
        with self._lock:
            self._take(Recording((), tuple(conditions), instruction))
            self.timeline.begin(follow)
            self._refresh()

    def add(self, frame: Frame) -> None:
        """Append a frame of the running simulation."""
        with self._lock:
            self._frames.append(frame)
            self.timeline.add(frame.time)
            if len(self._frames) == 1 or (self.timeline.following and time.monotonic() - self._drawn > _TICK):
                self._show()

    def add_segment(self, segment: Segment) -> None:
        """Append a segment of the running simulation."""
        with self._lock:
            self._recording = replace(self._recording, segments=(*self._recording.segments, segment))
            self.timeline.segments = (*self.timeline.segments, segment.begins)

    def finish(self, recording: Recording) -> None:
        """Set the complete recording at the end of the simulation; the shown frame does not change, and playback continues."""
        with self._lock:
            self._take(recording)
            self.timeline.complete(*_timing(recording))
            self._refresh()

    def seek(self, index: int) -> None:
        """Show a frame and pause."""
        self._changed(lambda timeline: timeline.seek(index))

    def close(self) -> None:
        """Remove the controls from the page and stop; later recordings are not shown."""
        with self._lock:
            if not self._closed:
                self._closed = True
                self._wake.set()
                self._controls.remove_keys()
                self._folder.remove()

    def _take(self, recording: Recording) -> None:
        self._recording, self._frames = recording, list(recording.frames)
        self._colors, self._present = None, frozenset()
        self._unmark()

    def _changed(self, change: Callable[[Timeline], None]) -> None:
        with self._lock:
            change(self.timeline)
            self._show()

    def _refresh(self) -> None:
        """Update the failure, the plots and the shown frame."""
        if not self._closed:
            failure, frames = self._recording.failure, self._frames
            self._failure.content = "" if failure is None else failure_html(failure)
            self._failure.visible = failure is not None
            for (title, unit, name), plot in zip(_PLOTS, self._plots, strict=True):
                plot.content = plot_html(title, unit, np.array([getattr(frame, name) for frame in frames])) if frames else ""
        self._show()

    def _show(self) -> None:
        if self._closed:
            return
        timeline, self._drawn = self.timeline, time.monotonic()
        self._wake.set()
        self._controls.show(timeline)
        self._cursor.content = now_style(timeline.share)
        self._show_conditions()
        if not self._frames:
            self._instant.content = framed("Nothing is recorded yet: press Demonstration or Reset.")
            return
        frame = self._frames[timeline.index]
        segment = None if timeline.segment is None else self._recording.segments[timeline.segment]
        self._instant.content = instant_html(frame, timeline.index, len(self._frames), segment)
        self._numbers.content = joints_html(frame)
        with self._together():
            self._draw(frame)
        if self._on_show is not None:
            self._on_show(timeline.index, frame)

    def _show_conditions(self) -> None:
        texts, frames = self._recording.conditions, self._frames
        met = frames[self.timeline.index].conditions_met if frames else (False,) * len(texts)
        shown = (texts, met, len(frames), frames[0] if frames else None)
        if shown != self._shown_conditions:
            self._shown_conditions = shown
            self._conditions.content = conditions_html(texts, met, [frame.conditions_met for frame in frames])

    def _draw(self, frame: Frame) -> None:
        bodies = frozenset(name.partition("/")[0] for name in frame.poses)
        if bodies != self._present:
            self._present = bodies
            self._figures.present(bodies)
        self._figures.move(frame.poses)
        self._figures.arm(frame.arm, frame.fingers)
        if frame.colors != self._colors:
            self._colors = frame.colors
            self._figures.paint(frame.colors)
        failure = self._recording.failure
        if failure is None or self.timeline.index != self.timeline.last:
            self._unmark()
        elif not self._marked:
            self._figures.mark([name for pair in failure.pairs for name in pair], _RED)
            if failure.nearest is not None:
                self._figures.ghost(NEAREST, failure.nearest, _AMBER)
            self._marked = True

    def _unmark(self) -> None:
        if self._marked:
            self._figures.mark(())
            self._figures.remove_ghost(NEAREST)
        self._marked = False

    def _run(self) -> None:
        """Advance the timeline while it plays."""
        before = time.monotonic()
        while not self._closed:
            if not self.timeline.playing:
                self._wake.wait()
                self._wake.clear()
                before = time.monotonic()
                continue
            time.sleep(_TICK)
            now = time.monotonic()
            with self._lock:
                moved, before = self.timeline.advance(now - before), now
                if moved or not self.timeline.playing:
                    self._show()


def _timing(recording: Recording) -> tuple[list[float], list[int]]:
    """Return the times of the frames and the first frames of the segments."""
    return [frame.time for frame in recording.frames], [segment.begins for segment in recording.segments]
