"""How a recording is shown in a page: time line, play and pause, step, legs, conditions, plots, the failure in place."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Protocol

from viser import GuiApi

from rlbench_pin.builder.contracts import Frame, Leg, Recording
from rlbench_pin.builder.playback.controls import Controls
from rlbench_pin.builder.playback.panels import ConditionPanel, Cursor, FailurePanel, JointPanel
from rlbench_pin.builder.playback.readout import framed, instant_html
from rlbench_pin.builder.playback.timeline import Timeline
from rlbench_pin.spatial import FloatArray, PoseLike

NEAREST = "nearest reachable pose"
"""Name of the ghost that shows it."""
_RED, _AMBER = (230, 40, 40), (255, 176, 0)
_TICK = 1.0 / 30.0
"""Time between two pictures while time goes on [s]."""
_EMPTY = Recording((), ())
Colors = Mapping[str, tuple[float, float, float, float]]
"""`<body>/<link>` -> rgba in 0..1."""


class Drawing(Protocol):
    """What a player moves: `Figures`."""

    def move(self, poses: Mapping[str, FloatArray]) -> None:
        """Put links at world poses (7,), by `<body>/<link>`."""

    def arm(self, q: FloatArray, fingers: FloatArray) -> None:
        """Show the arm at joint positions (n,) [rad], with its fingers at (m,) [m]."""

    def paint(self, colors: Colors) -> None:
        """Show links in colours of an episode, all others in those of the scene."""

    def present(self, bodies: Collection[str]) -> None:
        """Show these bodies and no others."""

    def mark(self, names: Iterable[str], rgb: tuple[int, int, int] = ...) -> None:
        """Show links in one colour, those marked before in their own again."""

    def ghost(self, name: str, pose: PoseLike, rgb: tuple[int, int, int]) -> None:
        """Show the hand alone, with its tip at a pose (7,)."""

    def remove_ghost(self, name: str) -> None:
        """Take a ghost away, if there is one of that name."""


class Player:
    """Shows recordings, one at a time; all tabs of a page see the same instant.

    Its methods may be called from any thread.

    Args:
        gui: Where its controls are drawn: that of a server, so that all tabs share them.
        figures: What it moves.
        on_show: Called with number and frame of every instant that is shown.
        together: Makes a block whose changes a page shows at once, such as `server.atomic`.
    """

    def __init__(
        self,
        gui: GuiApi,
        figures: Drawing,
        on_show: Callable[[int, Frame], None] | None = None,
        together: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        self._figures, self._on_show, self._together = figures, on_show, together
        self._lock, self._wake, self._closed = threading.RLock(), threading.Event(), False
        self.timeline = Timeline()
        self._recording, self._frames, self._drawn = _EMPTY, list[Frame](), 0.0
        self._marked, self._present = False, frozenset[str]()
        self._colors: Colors | None = None
        self._folder = gui.add_folder("Playback")
        with self._folder:
            self._instant, self._controls = gui.add_html(""), Controls(gui, self._changed)
            self._failure, self._conditions, self._cursor = FailurePanel(gui), ConditionPanel(gui), Cursor(gui)
            with gui.add_folder("Joints", expand_by_default=False):
                self._joints = JointPanel(gui)
        self._refresh()
        threading.Thread(target=self._run, daemon=True, name="player").start()

    # What is shown ---------------------------------------------------------------------------------------------------

    @property
    def recording(self) -> Recording:
        """What is shown, as far as it is there."""
        with self._lock:
            return replace(self._recording, frames=tuple(self._frames))

    def load(self, recording: Recording, *, play: bool = False) -> None:
        """Show a recording from its beginning.

        Args:
            recording: What to show.
            play: Let time go on at once.
        """
        with self._lock:
            self._take(recording)
            self.timeline.load(_times(recording), _begins(recording))
            if play:
                self.timeline.play()
            self._refresh()

    def begin(self, conditions: Sequence[str], instruction: str = "", *, follow: bool = False) -> None:
        """Show what is simulated now, as `add` brings it, until `finish`.

        Args:
            conditions: What `Frame.held` of the frames is about.
            instruction: The first sentence of the episode.
            follow: Show the newest frame as it arrives; otherwise time goes on at the chosen pace.
        """
        with self._lock:
            self._take(Recording((), tuple(conditions), instruction))
            self.timeline.begin(follow)
            self._refresh()

    def add(self, frame: Frame) -> None:
        """Take the next frame of what is simulated now."""
        with self._lock:
            self._frames.append(frame)
            self.timeline.add(frame.time)
            if len(self._frames) == 1 or (self.timeline.following and time.monotonic() - self._drawn > _TICK):
                self._show()

    def add_leg(self, leg: Leg) -> None:
        """Take the next leg of what is simulated now."""
        with self._lock:
            self._recording = replace(self._recording, legs=(*self._recording.legs, leg))
            self.timeline.legs = (*self.timeline.legs, leg.begins)

    def finish(self, recording: Recording) -> None:
        """Take over the whole recording of what was shown by `add`; the instant shown, and whether time goes on, stays."""
        with self._lock:
            self._take(recording)
            self.timeline.complete(_times(recording), _begins(recording))
            self._refresh()

    def seek(self, index: int) -> None:
        """Show a frame, at rest."""
        self._changed(lambda timeline: timeline.seek(index))

    def close(self) -> None:
        """Take the controls out of the page and stop; what comes later is not shown any more."""
        with self._lock:
            if not self._closed:
                self._closed = True
                self._wake.set()
                self._controls.remove_keys()
                self._folder.remove()

    # Inside ----------------------------------------------------------------------------------------------------------

    def _take(self, recording: Recording) -> None:
        self._recording, self._frames = recording, list(recording.frames)
        self._colors, self._present = None, frozenset()
        self._unmark()

    def _changed(self, change: Callable[[Timeline], None]) -> None:
        """Change the time line and show what it stands at."""
        with self._lock:
            change(self.timeline)
            self._show()

    def _refresh(self) -> None:
        """Draw all that depends on the recording as a whole."""
        with self._lock:
            if not self._closed:
                self._failure.show(self._recording.failure)
                self._joints.draw(self._frames)
            self._show()

    def _show(self) -> None:
        if self._closed:
            return
        timeline, self._drawn = self.timeline, time.monotonic()
        self._wake.set()
        self._controls.show(timeline)
        self._cursor.put(timeline.share)
        self._conditions.show(self._recording.conditions, self._frames, timeline.index)
        if not self._frames:
            self._instant.content = framed("Nothing is recorded yet: press Demonstration or Reset.")
            return
        frame = self._frames[timeline.index]
        leg = timeline.leg
        named = None if leg is None else (leg, self._recording.legs[leg])
        self._instant.content = instant_html(frame, timeline.index, len(self._frames), named)
        self._joints.show(frame)
        with self._together():
            self._draw(frame)
        if self._on_show is not None:
            self._on_show(timeline.index, frame)

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
        self._mark()

    def _mark(self) -> None:
        """Show the evidence of a failure while its instant, the last, is shown."""
        failure = self._recording.failure
        wanted = failure is not None and self.timeline.index == self.timeline.last
        if wanted and failure is not None and not self._marked:
            self._figures.mark([name for pair in failure.pairs for name in pair], _RED)
            if failure.nearest is not None:
                self._figures.ghost(NEAREST, failure.nearest, _AMBER)
            self._marked = True
        elif not wanted:
            self._unmark()

    def _unmark(self) -> None:
        if self._marked:
            self._figures.mark(())
            self._figures.remove_ghost(NEAREST)
        self._marked = False

    def _run(self) -> None:
        """Let time go on while it is to."""
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


def _times(recording: Recording) -> list[float]:
    return [frame.time for frame in recording.frames]


def _begins(recording: Recording) -> list[int]:
    return [leg.begins for leg in recording.legs]
