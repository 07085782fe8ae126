"""Trying the task: episodes by seed, time that passes, a demonstration, what the cameras see, planned paths."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.watch import Watch
from rlbench_pin.builder.view.widgets import Button, Check, Fold, Item, Note, Number, Picture, Row
from rlbench_pin.builder.view.widgets.signs import NOTHING, sign
from rlbench_pin.scene import BodySpec
from rlbench_pin.viewer.recording import Frame, Recording

_PICTURE = 160
_LARGEST_SEED = 2**31 - 1
_SPANS = (0.05, 0.5, 2.0, 10.0)
"""How long time may pass at once [s]; the first is one control tick."""


class Player(Protocol):
    """Shows recordings; see `builder.playback`."""

    def load(self, recording: Recording, *, play: bool = False) -> None:
        """Show a recording from its beginning."""

    def begin(self, conditions: tuple[str, ...], instruction: str = "", *, follow: bool = False) -> None:
        """Show what is simulated now, as `add` brings it."""

    def add(self, frame: Frame) -> None:
        """Take the next frame."""

    def finish(self, recording: Recording) -> None:
        """Take over the whole recording."""


class Tryout:
    """The panel in which a task is tried.

    Args:
        session: What is being edited.
        watch: Asks the stage.
        player: Shows recordings.
        on_added: Called with what an episode adds to the scene, before it is shown.
    """

    def __init__(self, session: Session, watch: Watch, player: Player, on_added: Callable[[Sequence[BodySpec]], None]) -> None:
        self._session, self._watch, self._player, self._on_added = session, watch, player, on_added
        self.seed, self.variation = 0, 0
        self._live = False
        self._frame: Frame | None = None
        self._pictures: Mapping[str, NDArray[np.uint8]] = {}
        self._rng = np.random.default_rng()

    def items(self) -> list[Item]:
        """Return its buttons."""
        sight = self._session.sight
        items: list[Item] = []
        if not self._watch.run_task:
            items += permission_items(self._watch, self._session.document.name)
        variations = 1 if sight.opened is None else max(1, sight.opened.variations)
        items += [
            Number("Seed", self.seed, self._set_seed, 1.0, 0.0, _LARGEST_SEED),
            Number(f"Variation, 0 to {variations - 1}", self.variation, self._set_variation, 1.0, 0.0, variations - 1.0),
            Row("Other seed", {"Before": self._before, "Next": self._next, "Random": self._random}),
            Button("Reset", self.reset, "blue", hint="Lay out the episode of this seed"),
            Button("Demonstration", self.demonstrate, "blue", disabled=not self._watch.run_task),
            Row("Let time pass", {f"{span:g} s": self._passing(span) for span in _SPANS}),
            Button("Plan paths", self._watch.plan),
            Button("Stop", self.stop, "red", disabled=not sight.work),
        ]
        items.append(sign("busy", sight.work) if sight.work else NOTHING)  # always there: what follows is not made anew
        items.append(sign("bad", sight.fault) if sight.fault else NOTHING)
        items.append(Fold("Cameras", self._camera_items(), is_open=False))
        return items

    def _camera_items(self) -> list[Item]:
        pictures: list[Item] = [Picture(name, picture) for name, picture in self._pictures.items()]
        return [Check("Live", self._live, self._set_live), Button("Take pictures", self.take_pictures), *pictures]

    # What somebody asks for ------------------------------------------------------------------------------------------

    def _set_seed(self, value: float) -> None:
        self.seed = int(value)

    def _set_variation(self, value: float) -> None:
        self.variation = int(value)

    def _before(self) -> None:
        self._go(max(0, self.seed - 1))

    def _next(self) -> None:
        self._go(min(self.seed + 1, _LARGEST_SEED))

    def _random(self) -> None:
        self._go(int(self._rng.integers(0, _LARGEST_SEED)))

    def _passing(self, seconds: float) -> Callable[[], None]:
        return lambda: self.simulate(seconds)

    def _go(self, seed: int) -> None:
        self.seed = seed
        self.reset()

    def _set_live(self, value: bool) -> None:
        self._live = value
        self.take_pictures()

    def reset(self) -> None:
        """Lay out the episode of the present seed and variation."""
        seed, variation = self.seed, self.variation
        self._watch.work(f"laying out seed {seed}", lambda: self._loaded(self._watch.stage.reset(seed, variation)), "reset")

    def simulate(self, seconds: float) -> None:
        """Let time pass [s]."""

        def ask() -> None:
            self._player.begin(self._conditions(), follow=True)
            self._finished(self._watch.stage.simulate(seconds, self._player.add))

        self._watch.work(f"simulating {seconds:g} s", ask, "simulate")

    def demonstrate(self) -> None:
        """Play the demonstration of the present seed and variation."""
        seed, variation = self.seed, self.variation

        def ask() -> None:
            start = self._watch.stage.reset(seed, variation)
            if start.failure is not None:
                self._loaded(start)
                return
            self._on_added(start.added)
            self._player.begin(self._conditions(), follow=True)
            self._finished(self._watch.stage.demonstrate(seed, variation, self._player.add))

        self._watch.work(f"demonstrating seed {seed}", ask, "demonstrate")

    def open_at(self, seed: int, variation: int) -> None:
        """Play the demonstration of a seed and variation that failed."""
        self.seed, self.variation = seed, variation
        self.demonstrate()

    def stop(self) -> None:
        """Stop what the stage is doing."""
        self._watch.stage.cancel()

    def take_pictures(self) -> None:
        """Have the cameras look."""
        frame, stage = self._frame, self._watch.stage

        def ask() -> None:
            pictures = stage.images(_PICTURE, frame)
            self._session.post(lambda: self._show_pictures(pictures))

        self._watch.work("taking pictures", ask, "pictures")

    def shown(self, frame: Frame | None) -> None:
        """Take note of the instant that is shown; None is the scene at rest. May be called from any thread."""
        self._frame = frame
        if self._live:
            self.take_pictures()

    # What comes back -------------------------------------------------------------------------------------------------

    def _conditions(self) -> tuple[str, ...]:
        opened = self._session.sight.opened
        return () if opened is None else opened.conditions

    def _loaded(self, recording: Recording) -> None:
        self._on_added(recording.added)
        self._player.load(recording)
        self._told(recording)

    def _finished(self, recording: Recording) -> None:
        self._player.finish(recording)
        self._told(recording)

    def _told(self, recording: Recording) -> None:
        if (failure := recording.failure) is not None:
            self._session.post(lambda: self._session.tell("It failed", failure.cause, bad=True))

    def _show_pictures(self, pictures: Mapping[str, NDArray[np.uint8]]) -> None:
        self._pictures = pictures
        self._session.changed()


def permission_items(watch: Watch, name: str) -> list[Item]:
    """Return the question whether the task's own module may run."""
    text = (
        f"To try and to judge the task, the code in `{name}.py` has to run on this machine, with your rights, "
        "in a process of its own. Read it first (*Files*) if it is not yours."
    )
    return [Note(text), Button(f"Run the code of {name}.py", watch.allow, "orange", key="allow")]
