"""What is simulated, brought to a page frame by frame."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.builder.contracts import Frame, Leg, Recording
from rlbench_pin.builder.playback.conditions import success_texts
from rlbench_pin.builder.playback.live.moments import Moments
from rlbench_pin.builder.playback.live.page import LivePage
from rlbench_pin.environment.runtime import Runtime


class Feed:
    """Shows one stretch of simulation while it is recorded; to be used in the thread that simulates.

    Args:
        page: Where it is shown.
        runtime: The running task.
        moments: Keeps what the cameras need; None keeps nothing.
        check: Called at each frame; what it raises ends the simulation.
        follow: Show the newest frame; otherwise time goes on at the chosen pace.

    Attributes:
        legs: How many legs have begun.
        frames: How many frames there were.
    """

    def __init__(
        self,
        page: LivePage,
        runtime: Runtime,
        moments: Moments | None = None,
        check: Callable[[], None] = lambda: None,
        follow: bool = False,
    ) -> None:
        self._page, self._runtime, self._moments, self._check, self._follow = page, runtime, moments, check, follow
        self._begun, self.legs, self.frames = False, 0, 0
        if moments is not None:
            moments.clear()

    def frame(self, frame: Frame) -> None:
        """Show the next frame; the first shows the scene of the episode, too."""
        self._check()
        if not self._begun:
            self._begin()
        if self._moments is not None:
            self._moments.keep()
        self.frames += 1
        self._page.player.add(frame)

    def _begin(self) -> None:
        self._begun, world = True, self._runtime.world
        instruction = next(iter(self._runtime.instructions), "")
        self._page.show_scene(world.spec, tuple(world.spawned.values()))
        self._page.player.begin(success_texts(self._runtime.task), instruction, follow=self._follow)

    def leg(self, leg: Leg) -> None:
        """Show that a leg begins."""
        self.legs += 1
        self._page.player.add_leg(leg)

    def finish(self, recording: Recording) -> None:
        """Take over the whole recording."""
        if not self._begun:  # there was no start
            self._page.player.load(recording)
        else:
            self._page.player.finish(recording)
