"""Where a player stands in a recording: instant, pace, legs; no clock and no page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Simulated seconds in a second by the clock on the wall."""


@dataclass
class Timeline:
    """The instants of a recording, and the one that is shown."""

    times: list[float] = field(default_factory=list)
    """Of each frame [s], rising."""
    legs: tuple[int, ...] = ()
    """Numbers of the frames at which legs begin, rising."""
    index: int = 0
    """Number of the frame that is shown."""
    playing: bool = False
    """Whether time goes on."""
    speed: float = 1.0
    """Simulated seconds in a second by the clock on the wall."""
    growing: bool = False
    """Whether more frames are to come."""
    following: bool = False
    """Whether the newest frame is shown as it arrives."""
    _rest: float = 0.0
    """Time that has gone since the shown frame [s]."""

    @property
    def last(self) -> int:
        """Number of the last frame; 0 where there is none."""
        return max(len(self.times) - 1, 0)

    @property
    def share(self) -> float:
        """How far the shown instant lies between the first and the last, 0 to 1."""
        if not self.times or self.times[-1] <= self.times[0]:
            return 0.0
        return (self.times[self.index] - self.times[0]) / (self.times[-1] - self.times[0])

    @property
    def leg(self) -> int | None:
        """Number of the leg that the shown frame belongs to; None before the first."""
        begun = [number for number, begins in enumerate(self.legs) if begins <= self.index]
        return begun[-1] if begun else None

    def load(self, times: Sequence[float], legs: Sequence[int] = ()) -> None:
        """Take over a recording and show its beginning, at rest."""
        self.times, self.legs = list(times), tuple(legs)
        self.index, self.playing, self.following, self.growing, self._rest = 0, False, False, False, 0.0

    def begin(self, follow: bool) -> None:
        """Forget all and await frames: show the newest where it is to be followed, else let time go on from the first."""
        self.load(())
        self.growing, self.following, self.playing = True, follow, not follow

    def add(self, time: float) -> None:
        """Take one more frame; it is shown where the newest is followed."""
        self.times.append(time)
        if self.following:
            self.index = self.last

    def complete(self, times: Sequence[float], legs: Sequence[int]) -> None:
        """Take over the whole recording of what has grown; what is shown, and whether time goes on, stays."""
        self.times, self.legs, self.growing, self.following = list(times), tuple(legs), False, False
        self.index = min(self.index, self.last)

    def seek(self, index: int) -> None:
        """Show a frame, at rest; beyond the ends the first or the last."""
        self.index = min(max(index, 0), self.last)
        self.playing, self.following, self._rest = False, False, 0.0

    def step(self, count: int) -> None:
        """Go on by `count` frames, or back, at rest."""
        self.seek(self.index + count)

    def jump(self, direction: int) -> None:
        """Go to where the next leg begins, or with -1 the one before; beyond them to the end or the beginning."""
        if direction > 0:
            self.seek(min((begins for begins in self.legs if begins > self.index), default=self.last))
        else:
            self.seek(max((begins for begins in self.legs if begins < self.index), default=0))

    def play(self) -> None:
        """Let time go on, from the beginning where the end is shown and nothing more is to come."""
        if self.index >= self.last and not self.growing:
            self.index = 0
        self.playing, self.following, self._rest = self.last > 0 or self.growing, False, 0.0

    def pause(self) -> None:
        """Stop at the shown frame."""
        self.seek(self.index)

    def pace(self, speed: float) -> None:
        """Let time go on at another pace, in simulated seconds per second on the wall."""
        self.speed = speed

    def advance(self, seconds: float) -> bool:
        """Let time on the wall go on, and say whether another frame is to be shown; at the end time stops, or waits for more."""
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
