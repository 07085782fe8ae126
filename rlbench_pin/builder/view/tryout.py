"""The tab *Try*: episodes by seed, simulation, demonstrations, camera images, planned paths."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Panel
from rlbench_pin.builder.view.world_sync import WorldSync
from rlbench_pin.scene import BodySpec
from rlbench_pin.viewer.player import Player
from rlbench_pin.viewer.recording import Frame, Recording

_IMAGE_SIZE = 160
_MAX_SEED = 2**31 - 1
_DURATIONS = (0.05, 0.5, 2.0, 10.0)
"""Durations to simulate [s]; the first is one control tick."""


class Tryout:
    """Tries the task.

    Args:
        session: The edited task.
        world: Sends requests to the worker process.
        player: Shows recordings.
        on_added: Receives the bodies that an episode adds to the scene, before it is shown.
    """

    def __init__(
        self, session: Session, world: WorldSync, player: Player, on_added: Callable[[Sequence[BodySpec]], None]
    ) -> None:
        self._session, self._world, self._player, self._on_added = session, world, player, on_added
        self.seed, self.variation = 0, 0
        self._live = False
        self._frame: Frame | None = None
        self._images: Mapping[str, NDArray[np.uint8]] = {}
        self._rng = np.random.default_rng()

    def show(self, panel: Panel) -> None:
        """Show the controls."""
        status = self._session.status
        if not self._world.run_task:
            show_permission(panel, self._world, self._session.document.name)
        variations = 1 if status.opened is None else max(1, status.opened.variations)
        panel.number("Seed", self.seed, self._set_seed, 1.0, 0.0, _MAX_SEED)
        label = f"Variation, 0 to {variations - 1}"
        panel.number(label, self.variation, self._set_variation, 1.0, 0.0, variations - 1.0)
        seeds: dict[str, Callable[[], None]] = {
            "Before": lambda: self._reset_to(max(0, self.seed - 1)),
            "Next": lambda: self._reset_to(min(self.seed + 1, _MAX_SEED)),
            "Random": lambda: self._reset_to(int(self._rng.integers(0, _MAX_SEED))),
        }
        panel.button_row("Other seed", seeds)
        panel.button("Reset", self.reset, "blue", "Start the episode of this seed")
        panel.button("Demonstration", self.demonstrate, "blue", disabled=not self._world.run_task)
        panel.button_row("Simulate", {f"{t:g} s": lambda t=t: self.simulate(t) for t in _DURATIONS})  # type: ignore[misc]
        panel.button("Plan paths", self._world.plan)
        panel.button("Stop", self.stop, "red", disabled=not status.work)
        # Both lines are always there, so that the controls below keep their positions.
        if status.work:
            panel.sign("busy", status.work)
        else:
            panel.html("")
        if status.fault:
            panel.sign("bad", status.fault)
        elif status.ran_code and status.opened is not None and not (status.opened.conditions or status.opened.problems):
            panel.sign("doubtful", "The task registers no success condition: see Behaviour.")
        else:
            panel.html("")
        with panel.folder("Cameras", is_open=False) as folder:
            folder.checkbox("Live", self._live, self._set_live)
            folder.button("Take images", self.take_images)
            for name, image in self._images.items():
                folder.image(name, image)

    def _set_seed(self, value: float) -> None:
        self.seed = int(value)

    def _set_variation(self, value: float) -> None:
        self.variation = int(value)

    def _set_live(self, value: bool) -> None:
        self._live = value
        self.take_images()

    def _reset_to(self, seed: int) -> None:
        self.seed = seed
        self.reset()

    # Requests --------------------------------------------------------------------------------------------------------

    def reset(self) -> None:
        """Start the episode of the current seed and variation."""
        seed, variation = self.seed, self.variation
        self._world.work(f"resetting to seed {seed}", lambda: self._load(self._world.worker.reset(seed, variation)), "reset")

    def simulate(self, seconds: float) -> None:
        """Simulate for a duration [s]."""

        def request() -> None:
            self._begin()
            self._finish(self._world.worker.simulate(seconds, self._player.add))

        self._world.work(f"simulating {seconds:g} s", request, "simulate")

    def demonstrate(self) -> None:
        """Play the demonstration of the current seed and variation."""
        seed, variation = self.seed, self.variation

        def request() -> None:
            start = self._world.worker.reset(seed, variation)
            if start.failure is not None:
                self._load(start)
                return
            self._on_added(start.added)
            self._begin()
            self._finish(self._world.worker.demonstrate(seed, variation, self._player.add))

        self._world.work(f"demonstrating seed {seed}", request, "demonstrate")

    def open_at(self, seed: int, variation: int) -> None:
        """Play the demonstration of a seed and variation."""
        self.seed, self.variation = seed, variation
        self.demonstrate()

    def stop(self) -> None:
        """Stop the current work of the worker process."""
        self._world.worker.cancel()

    def take_images(self) -> None:
        """Render the cameras."""
        frame, worker = self._frame, self._world.worker

        def request() -> None:
            images = worker.images(_IMAGE_SIZE, frame)
            self._session.post(lambda: self._show_images(images))

        self._world.work("rendering images", request, "images")

    def _show_images(self, images: Mapping[str, NDArray[np.uint8]]) -> None:
        self._images = images
        self._session.changed()

    def set_frame(self, frame: Frame | None) -> None:
        """Record which frame is shown; None is the scene at rest. May be called from any thread."""
        self._frame = frame
        if self._live:
            self.take_images()

    # Recordings ------------------------------------------------------------------------------------------------------

    def _begin(self) -> None:
        opened = self._session.status.opened
        self._player.begin(() if opened is None else opened.conditions, follow=True)

    def _load(self, recording: Recording) -> None:
        self._on_added(recording.added)
        self._player.load(recording)
        self._report(recording)

    def _finish(self, recording: Recording) -> None:
        self._player.finish(recording)
        self._report(recording)

    def _report(self, recording: Recording) -> None:
        if (failure := recording.failure) is not None:
            self._session.post(lambda: self._session.show_message("It failed", failure.cause, bad=True))


def show_permission(panel: Panel, world: WorldSync, name: str) -> None:
    """Ask whether the Python file of the task may run."""
    panel.note(
        f"To try and to validate the task, the code in `{name}.py` has to run on this machine, with your rights, "
        "in a subprocess. If it is not your code, read it first in *Files*."
    )
    panel.button(f"Run the code of {name}.py", world.allow_code, "orange", key="allow")
