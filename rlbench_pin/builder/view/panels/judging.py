"""The validator: its lines, failures that open at their seed, where the task can be reached, what is missing to contribute it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rlbench_pin.builder.contracts import Judgement, ReachSpot, TaskText
from rlbench_pin.builder.document import Behaviour
from rlbench_pin.builder.view.panels.texts import problems_of
from rlbench_pin.builder.view.panels.tryout import permission_items
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.watch import Watch
from rlbench_pin.builder.view.widgets import Button, Fold, Item, Note, Number, Progress
from rlbench_pin.builder.view.widgets.signs import Sign, sign
from rlbench_pin.builder.view.worker import Worker
from rlbench_pin.errors import RlbenchPinError

_SIGNS: dict[bool | None, Sign] = {True: "good", False: "bad", None: "busy"}
_SHOWN = 8
_SENTENCES, _DEMONSTRATIONS = 3, 100
"""What the library asks of a task."""


class Judging:
    """The panel in which a task is judged.

    Args:
        session: What is being edited.
        watch: Asks the stage.
        open_at: Plays the demonstration of a seed and variation.
        on_spots: Called with the layouts of the reach map.
    """

    def __init__(
        self,
        session: Session,
        watch: Watch,
        open_at: Callable[[int, int], None],
        on_spots: Callable[[Sequence[ReachSpot]], None],
    ) -> None:
        self._session, self._watch, self._open_at, self._on_spots = session, watch, open_at, on_spots
        self._episodes, self._layouts = 10, 60
        self.lines: dict[str, Judgement] = {}
        self.work, self._share, self._fault = "", 0.0, ""
        self._judged: tuple[TaskText, int] | None = None
        self._spots: list[ReachSpot] = []
        self._worker = Worker("judge", self._failed)

    @property
    def is_green(self) -> bool:
        """Whether the texts as they stand were judged, and kept everything."""
        return self._is_current and not self.work and bool(self.lines) and all(line.passed for line in self.lines.values())

    @property
    def _is_current(self) -> bool:
        """Whether the lines are about the texts as they stand."""
        return self._judged is not None and self._judged[0] == self._session.document.text

    def items(self) -> list[Item]:
        """Return its buttons and lines."""
        name = self._session.document.name
        items: list[Item] = [] if self._watch.run_task else permission_items(self._watch, name)
        items += [
            Number("Demonstrations", self._episodes, self._set_episodes, 5.0, 1.0, 1000.0),
            Button("Judge", self.judge, "blue", disabled=not self._watch.run_task or bool(self.work)),
            Button("Map of what can be reached", self.map, disabled=not self._watch.run_task or bool(self.work)),
            Button("Stop judging", self.stop, "red", disabled=not self.work),
        ]
        items += [sign("busy", self.work), Progress(self._share)] if self.work else []
        items += [sign("bad", self._fault)] if self._fault else []
        items += self._map_items()
        if self.lines and not self.work and not self._is_current:
            why = "Stopped before the end." if self._judged is None else "The files have changed since."
            items.append(sign("doubtful", f"{why} Judge again."))
        for line in self.lines.values():
            items += self._line_items(line)
        if not (self.lines or self.work or self._fault):
            items.append(
                Note("*Judge* asks all that `rlbench-pin check` asks; 10 demonstrations show most mistakes in some minutes.")
            )
        items.append(Fold("Ready to contribute", self._ready_items()))
        return items

    def _map_items(self) -> list[Item]:
        """Return what the colours of the map mean, and how many places have each."""
        if not self._spots:
            return []
        away = sum(not spot.free for spot in self._spots)
        reached = sum(spot.free and all(spot.reached) for spot in self._spots)
        counts: tuple[tuple[Sign, int, str], ...] = (
            ("good", reached, "the hand gets to all waypoints"),
            ("bad", len(self._spots) - away - reached, "it does not get to one or more"),
            ("unknown", away, "something touches the arm at home"),
        )
        legend: list[Item] = [Note(f"Each dot on the table is a place of the task's root, {len(self._spots)} in all:")]
        legend += [sign(kind, text, str(count)) for kind, count, text in counts]
        return [Fold("Map", [*legend, Button("Take the map away", self._clear_map, disabled=bool(self.work))])]

    def _clear_map(self) -> None:
        self._spots = []
        self._on_spots(())
        self._session.changed()

    def _line_items(self, line: Judgement) -> list[Item]:
        items: list[Item] = [sign(_SIGNS[line.passed], line.figure, line.name)]
        for seed, variation, cause in line.failures[:_SHOWN]:
            label = f"Open seed {seed}, variation {variation}"
            items.append(Button(label, lambda s=seed, v=variation: self._open_at(s, v), "orange", cause))  # type: ignore[misc]
            items.append(Note(cause))
        if (more := len(line.failures) - _SHOWN) > 0:
            items.append(Note(f"... and {more} more."))
        return items

    def _ready_items(self) -> list[Item]:
        document, behaviour = self._session.document, self._session.behaviour
        sentences = behaviour.instructions
        own = sorted({body.asset for body in self._session.spec.body if body.asset.startswith("./")})
        judged = self._judged[1] if self._judged is not None and self.is_green else 0
        wanted = (
            (not problems_of(self._session), "No problem in either file", "see Files"),
            (bool(self._session.spec.waypoint), "Waypoints for a demonstration", "see Add"),
            (behaviour.success is None or len(behaviour.success) > 0, "A success condition", "see Behaviour"),
            (
                self.is_green if sentences is None else all(len(group) >= _SENTENCES for group in sentences),
                "Three sentences or more for each variation",
                "see Behaviour",
            ),
            (_are_telling(behaviour), "Docstrings that say what varies and what counts", "see Behaviour"),
            (
                not own,
                "All objects are from the catalogue",
                f"{', '.join(own)}: the package needs a builder and a licence for it",
            ),
            (self.is_green, "The validator is green for the files as they stand", "press Judge"),
            (judged >= _DEMONSTRATIONS, f"{_DEMONSTRATIONS} demonstrations judged", f"{judged} of the files as they stand"),
            (not document.unsaved, "Saved", "press Save"),
        )
        items: list[Item] = [
            sign("good" if done else "unknown", text if done else f"{text} ({step})") for done, text, step in wanted
        ]
        return [*items, Note("Then by hand: a line in `CHANGELOG.md`, a test of the goal; see `CONTRIBUTING.md`.")]

    # What somebody asks for ------------------------------------------------------------------------------------------

    def _set_episodes(self, value: float) -> None:
        self._episodes = max(1, int(value))

    def judge(self) -> None:
        """Ask what `rlbench-pin check` asks."""
        self.lines, self._fault, self._judged = {}, "", None
        text, episodes = self._session.document.text, self._episodes

        def ask() -> None:
            lines = self._watch.stage.judge(episodes, self._add_line, self._progress)
            self._session.post(lambda: self._take(text, episodes, lines))

        self._start(f"playing {episodes} demonstrations", ask)

    def map(self) -> None:
        """Look at layouts all over the table."""
        self._spots, self._fault = [], ""
        layouts = self._layouts

        def ask() -> None:
            self._watch.stage.reach_map(layouts, self._add_spot)

        self._start(f"looking at {layouts} layouts", ask)

    def stop(self) -> None:
        """Stop judging."""
        for operation in ("judge", "reach_map"):
            self._watch.stage.cancel(operation)

    # What comes back -------------------------------------------------------------------------------------------------

    def _start(self, work: str, ask: Callable[[], None]) -> None:
        self.work, self._share = work, 0.0
        self._session.changed()

        def run() -> None:
            fault = ""
            try:
                ask()
            except RlbenchPinError as error:
                fault = str(error)
            self._session.post(lambda: self._end(fault))

        self._worker.post(run)

    def _end(self, fault: str) -> None:
        self.work, self._fault = "", fault
        self._session.changed()

    def _failed(self, error: Exception) -> None:
        self._session.post(lambda: self._end(f"{type(error).__name__}: {error}"))

    def _take(self, text: TaskText, episodes: int, lines: Sequence[Judgement]) -> None:
        self.lines, self._judged = {line.name: line for line in lines}, (text, episodes)

    def _add_line(self, line: Judgement) -> None:
        def add() -> None:
            self.lines[line.name] = line
            self._session.changed()

        self._session.post(add)

    def _progress(self, done: int, all_of_them: int) -> None:
        def show() -> None:
            self._share = done / max(1, all_of_them)
            self._session.changed()

        self._session.post(show, "progress")

    def _add_spot(self, spot: ReachSpot) -> None:
        def add() -> None:
            self._spots.append(spot)
            self._share = len(self._spots) / self._layouts
            self._on_spots(tuple(self._spots))
            self._session.changed()

        self._session.post(add)

    def close(self) -> None:
        """End its thread."""
        self._worker.stop()


def _are_telling(behaviour: Behaviour) -> bool:
    """Whether the docstrings say something, and not the same twice, as those of a new task."""
    return bool(behaviour.title) and bool(behaviour.description) and behaviour.title != behaviour.description
