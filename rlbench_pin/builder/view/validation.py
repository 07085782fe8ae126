"""The tab *Validate*: results of the validator, failures to replay, the reach map, open requirements of a contribution."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rlbench_pin.builder.contracts import ReachSpot, TaskText, ValidationLine
from rlbench_pin.builder.view.files import all_problems
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.tryout import show_permission
from rlbench_pin.builder.view.widgets import Panel, Sign
from rlbench_pin.builder.view.world_sync import WorldSync
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.viewer.job_thread import JobThread

_SIGNS: dict[bool | None, Sign] = {True: "good", False: "bad", None: "busy"}
_MAX_FAILURES = 8
_LAYOUTS = 60
_SENTENCES, _DEMONSTRATIONS = 3, 100
"""Requirements for a task of the library."""


class Validation:
    """Validates the task.

    Args:
        session: The edited task.
        world: Sends requests to the worker process.
        open_at: Plays the demonstration of a seed and variation.
        on_spots: Called with the layouts of the reach map.
    """

    def __init__(
        self,
        session: Session,
        world: WorldSync,
        open_at: Callable[[int, int], None],
        on_spots: Callable[[Sequence[ReachSpot]], None],
    ) -> None:
        self._session, self._world, self._open_at, self._on_spots = session, world, open_at, on_spots
        self._episodes = 10
        self.lines: dict[str, ValidationLine] = {}
        self.work, self._share, self._fault = "", 0.0, ""
        self._validated: tuple[TaskText, int] | None = None
        self._spots: list[ReachSpot] = []
        self.requests = JobThread("validation", lambda error: self._end(f"{type(error).__name__}: {error}"))

    @property
    def is_green(self) -> bool:
        """Whether the current texts were validated without a failure."""
        return self._is_current and not self.work and bool(self.lines) and all(line.passed for line in self.lines.values())

    @property
    def _is_current(self) -> bool:
        """Whether the results are about the current texts."""
        return self._validated is not None and self._validated[0] == self._session.document.text

    def show(self, panel: Panel) -> None:
        """Show the controls and the results."""
        if not self._world.run_task:
            show_permission(panel, self._world, self._session.document.name)
        is_blocked = not self._world.run_task or bool(self.work)
        panel.number("Demonstrations", self._episodes, self._set_episodes, 5.0, 1.0, 1000.0)
        panel.button("Validate", self.validate, "blue", disabled=is_blocked)
        panel.button("Reach map", self.map_reach, disabled=is_blocked)
        panel.button("Stop validation", self.stop, "red", disabled=not self.work)
        if self.work:
            panel.sign("busy", self.work)
            panel.progress(self._share)
        if self._fault:
            panel.sign("bad", self._fault)
        if self._spots:
            self._show_map(panel)
        if self.lines and not self.work and not self._is_current:
            why = "Stopped before the end." if self._validated is None else "The files have changed since."
            panel.sign("doubtful", f"{why} Validate again.")
        for line in self.lines.values():
            self._show_line(panel, line)
        if legend := "\n".join(f"- **{line.name}**: {line.meaning}" for line in self.lines.values() if line.meaning):
            with panel.folder("What the lines mean", is_open=False) as folder:
                folder.note(legend)
        if not (self.lines or self.work or self._fault):
            panel.note("*Validate* runs `rlbench-pin check`; 10 demonstrations show most mistakes in some minutes.")
        with panel.folder("Ready to contribute") as folder:
            self._show_requirements(folder)

    def _show_map(self, panel: Panel) -> None:
        """Show the legend of the map, and how often each colour occurs."""

        def clear() -> None:
            self._spots = []
            self._on_spots(())
            self._session.changed()

        blocked = sum(not spot.free for spot in self._spots)
        reached = sum(spot.free and all(spot.reached) for spot in self._spots)
        with panel.folder("Map") as folder:
            folder.note(f"Each dot on the table is a position of the task's root, {len(self._spots)} in all:")
            folder.sign("good", "the gripper reaches all waypoints", str(reached))
            folder.sign("bad", "it does not reach one or more waypoints", str(len(self._spots) - blocked - reached))
            folder.sign("unknown", "something touches the arm at home", str(blocked))
            folder.button("Remove the map", clear, disabled=bool(self.work))

    def _show_line(self, panel: Panel, line: ValidationLine) -> None:
        panel.sign(_SIGNS[line.passed], line.figure, line.name)
        for seed, variation, cause in line.failures[:_MAX_FAILURES]:
            label = f"Open seed {seed}, variation {variation}"
            panel.button(label, lambda s=seed, v=variation: self._open_at(s, v), "orange", cause)  # type: ignore[misc]
            panel.note(cause)
        if (more := len(line.failures) - _MAX_FAILURES) > 0:
            panel.note(f"... and {more} more.")

    def _show_requirements(self, panel: Panel) -> None:
        document = self._session.document
        behaviour = document.behaviour
        sentences = behaviour.instructions
        own = sorted({body.asset for body in self._session.spec.body if body.asset.startswith("./")})
        validated = self._validated[1] if self._validated is not None and self.is_green else 0
        has_docstrings = bool(behaviour.title) and bool(behaviour.description) and behaviour.title != behaviour.description
        requirements = (
            (not all_problems(self._session), "No problem in either file", "see Files"),
            (bool(self._session.spec.waypoint), "Waypoints for a demonstration", "see Add"),
            (behaviour.success is None or len(behaviour.success) > 0, "A success condition", "see Behaviour"),
            (
                self.is_green if sentences is None else all(len(group) >= _SENTENCES for group in sentences),
                "Three sentences or more for each variation",
                "see Behaviour",
            ),
            (has_docstrings, "Docstrings about variations and success", "see Behaviour"),
            (
                not own,
                "All objects are from the catalogue",
                f"{', '.join(own)}: the package needs a builder and a licence for it",
            ),
            (self.is_green, "The validator is green for the present files", "press Validate"),
            (
                validated >= _DEMONSTRATIONS,
                f"{_DEMONSTRATIONS} demonstrations validated",
                f"{validated} of the present files",
            ),
            (not document.unsaved, "Saved", "press Save"),
        )
        for done, text, step in requirements:
            panel.sign("good" if done else "unknown", text if done else f"{text} ({step})")
        panel.note("Then by hand: a line in `CHANGELOG.md`, a test of the goal; see `CONTRIBUTING.md`.")

    # Requests --------------------------------------------------------------------------------------------------------

    def _set_episodes(self, value: float) -> None:
        self._episodes = max(1, int(value))

    def validate(self) -> None:
        """Run the validator, as `rlbench-pin check` does."""
        self.lines, self._fault, self._validated = {}, "", None
        text, episodes = self._session.document.text, self._episodes

        def add(line: ValidationLine) -> None:
            self.lines[line.name] = line
            self._session.changed()

        def show_progress(done: int, total: int) -> None:
            self._share = done / max(1, total)
            self._session.changed()

        def take(lines: Sequence[ValidationLine]) -> None:
            self.lines, self._validated = {line.name: line for line in lines}, (text, episodes)

        def request() -> None:
            post = self._session.post
            lines = self._world.worker.validate(
                episodes,
                lambda line: post(lambda: add(line)),
                lambda done, total: post(lambda: show_progress(done, total), "progress"),
            )
            post(lambda: take(lines))

        self._start(f"playing {episodes} demonstrations", request)

    def map_reach(self) -> None:
        """Compute the reachability for layouts all over the table."""
        self._spots, self._fault = [], ""

        def add(spot: ReachSpot) -> None:
            self._spots.append(spot)
            self._share = len(self._spots) / _LAYOUTS
            self._on_spots(tuple(self._spots))
            self._session.changed()

        def request() -> None:
            self._world.worker.reach_map(_LAYOUTS, lambda spot: self._session.post(lambda: add(spot)))

        self._start(f"checking {_LAYOUTS} layouts", request)

    def stop(self) -> None:
        """Stop the validator or the map."""
        for operation in ("validate", "reach_map"):
            self._world.worker.cancel(operation)

    def _start(self, work: str, request: Callable[[], None]) -> None:
        self.work, self._share = work, 0.0
        self._session.changed()

        def run() -> None:
            fault = ""
            try:
                request()
            except RlbenchPinError as error:
                fault = str(error)
            self._end(fault)

        self.requests.post(run)

    def _end(self, fault: str) -> None:
        def end() -> None:
            self.work, self._fault = "", fault
            self._session.changed()

        self._session.post(end)

    def close(self) -> None:
        """End the thread."""
        self.requests.stop()
