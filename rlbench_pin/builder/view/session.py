"""The edited task, the selection, and the listeners: shared by all tabs of the browser."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from rlbench_pin.builder.contracts import OpenedTask, PlannedPath, WaypointVerdict
from rlbench_pin.builder.document import HasDependants, TaskDocument
from rlbench_pin.builder.view.placing import Snap
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.spec import ROOT, PosedSpec
from rlbench_pin.viewer.job_thread import Job, JobThread
from rlbench_pin.viewer.places import Places, places_at_rest

_LOG = logging.getLogger(__name__)
_EMPTY = SceneSpec(format=2)


@dataclass
class WorldStatus:
    """Results of the worker process for the current scene."""

    opened: OpenedTask | None = None
    """Description of the task; None before it was built."""
    ran_code: bool = False
    """Whether the task's own module was run for that description; otherwise it has no conditions."""
    verdicts: Mapping[str, WaypointVerdict] = field(default_factory=dict)
    """Reachability by waypoint."""
    paths: tuple[PlannedPath, ...] = ()
    """Planned paths, if any were requested."""
    work: str = ""
    """Current work; empty when idle."""
    fault: str = ""
    """Error of the last request."""


class Session:
    """One task in the editor. Edits run in one thread, `edits`, which also calls the listeners.

    Args:
        document: The task.
        notify: Shows a message: title, text, whether it is an error.

    Attributes:
        document: The task.
        edits: Thread of edits.
        status: Results of the worker process.
        selected: Name of the selected element; `root` is the placement of the task, empty is none.
        snap: Snapping of dragged elements.
        drops_onto: Whether an element that is dropped over a body is attached to it.
        pending_deletion: A deletion that needs a confirmation, because other elements depend on the element.
        typed: Files with typed text that is not applied.
    """

    def __init__(self, document: TaskDocument, notify: Callable[[str, str, bool], None]) -> None:
        self.document, self.status, self.selected = document, WorldStatus(), ""
        self.snap: Snap = "grid"
        self.drops_onto = False
        self.pending_deletion: HasDependants | None = None
        self.typed: set[str] = set()
        self._notify = notify
        self._listeners: list[Callable[[], None]] = []
        self.edits = JobThread("edits", self._report)

    @property
    def spec(self) -> SceneSpec:
        """The scene of the last valid text; an empty one before."""
        return self.document.spec or _EMPTY

    @property
    def places(self) -> Places:
        """World poses of all elements at rest."""
        return places_at_rest(self.spec)

    def element(self, name: str) -> PosedSpec | None:
        """Return a body, frame, region, sensor or waypoint; None for an unknown name."""
        return next((element for element in self.spec.posed() if element.name == name), None)

    def table_of(self, name: str) -> str:
        """Return `body`, `frame`, `region`, `sensor` or `waypoint`; empty for an unknown name."""
        spec = self.spec
        tables = {"body": spec.body, "frame": spec.frame, "region": spec.region, "sensor": spec.sensor, "waypoint": spec.waypoint}
        return next((table for table, elements in tables.items() if any(e.name == name for e in elements)), "")

    # Changes ---------------------------------------------------------------------------------------------------------

    def listen(self, listener: Callable[[], None]) -> None:
        """Have a function called after each change, in the thread of edits."""
        self._listeners.append(listener)

    def post(self, job: Job, kind: str = "") -> None:
        """Run a job in the thread of edits; of several waiting ones of the same non-empty kind, only the last runs."""

        def run() -> None:
            try:
                job()
            except RlbenchPinError as error:
                self.show_message("Not done", str(error), bad=True)

        self.edits.post(run, kind)

    def do(self, edit: Callable[[TaskDocument], object]) -> None:
        """Make an edit, in the thread of edits, and report a refused one."""
        self.pending_deletion = None
        try:
            edit(self.document)
        except RlbenchPinError as error:
            self.show_message("Not done", str(error), bad=True)
        self.select(self.selected)

    def select(self, name: str) -> None:
        """Select an element; an unknown name selects none."""
        if self.pending_deletion is not None and self.pending_deletion.name != name:
            self.pending_deletion = None
        self.selected = name if name == ROOT or self.element(name) is not None else ""
        self.changed()

    def do_and_select(self, edit: Callable[[TaskDocument], str]) -> None:
        """Make an edit that returns the name of an element, and select that element."""

        def edit_and_select(document: TaskDocument) -> None:
            self.selected = edit(document)

        self.do(edit_and_select)

    def changed(self) -> None:
        """Call all listeners."""
        for listener in self._listeners:
            listener()

    def set_typing(self, file: str, is_typed: bool) -> None:
        """Record whether text is typed in the field of a file and not applied."""
        (self.typed.add if is_typed else self.typed.discard)(file)
        self.changed()

    def save(self) -> None:
        """Save both files, and report typed text that is left out."""
        self.do(lambda document: document.save())
        if not self.document.unsaved:
            self.show_message("Saved", f"{self.document.folder / self.document.name}.toml and .py")
        if self.typed:
            self.show_message(
                "Not saved", f"Typed text in {' and '.join(sorted(self.typed))}: press Apply in Files first.", bad=True
            )

    def show_message(self, title: str, text: str, bad: bool = False) -> None:
        """Show a message in all tabs."""
        self._notify(title, text, bad)

    def _report(self, error: Exception) -> None:
        _LOG.exception("in the thread of edits", exc_info=error)
        self.show_message("Internal error of the builder", f"{type(error).__name__}: {error}", bad=True)

    def stop(self) -> None:
        """End the thread of edits."""
        self.edits.stop()
