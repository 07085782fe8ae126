"""The edited task, the selection, and the listeners: shared by all tabs of the browser."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from rlbench_pin.builder.contracts import OpenedTask, PlannedPath, WaypointVerdict
from rlbench_pin.builder.document import Behaviour, HasDependants, TaskDocument
from rlbench_pin.builder.figures import Places, places_at_rest
from rlbench_pin.builder.view.placing import Snap
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.spec import ROOT, PosedSpec

_LOG = logging.getLogger(__name__)
_EMPTY = SceneSpec(format=2)
Job = Callable[[], None]


class JobThread:
    """Runs jobs in a thread of its own, in order.

    Args:
        name: Name of the thread.
        on_error: Receives what a job raises, in the thread, which goes on with the next job.
    """

    def __init__(self, name: str, on_error: Callable[[Exception], None]) -> None:
        self._on_error = on_error
        self._jobs: dict[object, Job] = {}
        self._count = 0
        self._wake, self._stopped, self._busy = threading.Condition(), False, False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def post(self, job: Job, kind: str = "") -> None:
        """Add a job. It replaces a waiting one of the same kind; an empty kind replaces none."""
        with self._wake:
            if self._stopped:
                return
            self._count += 1
            self._jobs.pop(kind, None)
            self._jobs[kind or self._count] = job
            self._wake.notify_all()

    def wait(self, timeout: float) -> bool:
        """Wait until all jobs are done [s]; return False after a timeout."""
        with self._wake:
            return self._wake.wait_for(lambda: not self._jobs and not self._busy, timeout)

    def stop(self, timeout: float = 5.0) -> None:
        """End after the present job, and drop waiting ones."""
        with self._wake:
            self._stopped = True
            self._jobs.clear()
            self._wake.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout)

    def _run(self) -> None:
        while (job := self._take()) is not None:
            try:
                job()
            except Exception as error:  # the thread goes on after any error
                self._on_error(error)
            with self._wake:
                self._busy = False
                self._wake.notify_all()

    def _take(self) -> Job | None:
        with self._wake:
            self._wake.wait_for(lambda: bool(self._jobs) or self._stopped)
            if self._stopped:
                return None
            self._busy = True
            return self._jobs.pop(next(iter(self._jobs)))


@dataclass
class WorldStatus:
    """Results of the worker process for the present scene."""

    opened: OpenedTask | None = None
    """Description of the task; None before it was built."""
    verdicts: Mapping[str, WaypointVerdict] = field(default_factory=dict)
    """Reachability by waypoint."""
    paths: tuple[PlannedPath, ...] = ()
    """Planned paths, if any were requested."""
    work: str = ""
    """Present work; empty when idle."""
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
        pending_deletion: A deletion that waits for a confirmation, because other elements depend on the element.
        typed: Files with typed text that is not applied.
    """

    def __init__(self, document: TaskDocument, notify: Callable[[str, str, bool], None]) -> None:
        self.document, self.status, self.selected = document, WorldStatus(), ""
        self.snap: Snap = "grid"
        self.drops_onto = False
        self.pending_deletion: HasDependants | None = None
        self.typed: set[str] = set()
        self._behaviour: tuple[str, Behaviour] | None = None
        self._notify = notify
        self._listeners: list[Callable[[], None]] = []
        self.edits = JobThread("edits", self._report)

    @property
    def spec(self) -> SceneSpec:
        """The scene of the last valid text; an empty one before."""
        return self.document.spec or _EMPTY

    @property
    def behaviour(self) -> Behaviour:
        """What forms can edit of the Python file, cached until the file changes."""
        text = self.document.python_text
        if self._behaviour is None or self._behaviour[0] != text:
            self._behaviour = (text, self.document.behaviour)
        return self._behaviour[1]

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
                self.tell("Not done", str(error), bad=True)

        self.edits.post(run, kind)

    def do(self, edit: Callable[[TaskDocument], object]) -> None:
        """Make an edit, in the thread of edits, and report a refused one."""
        self.pending_deletion = None
        try:
            edit(self.document)
        except RlbenchPinError as error:
            self.tell("Not done", str(error), bad=True)
        self.select(self.selected)

    def select(self, name: str) -> None:
        """Select an element; an unknown name selects none."""
        if self.pending_deletion is not None and self.pending_deletion.name != name:
            self.pending_deletion = None
        self.selected = name if name == ROOT or self.element(name) is not None else ""
        self.changed()

    def do_and_select(self, edit: Callable[[TaskDocument], str]) -> None:
        """Make an edit that returns the name of an element, and select that element."""
        names: list[str] = []
        self.do(lambda document: names.append(edit(document)))
        if names:
            self.select(names[0])

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
            self.tell("Saved", f"{self.document.folder / self.document.name}.toml and .py")
        if self.typed:
            self.tell("Not saved", f"Typed text in {' and '.join(sorted(self.typed))}: press Apply in Files first.", bad=True)

    def tell(self, title: str, text: str, bad: bool = False) -> None:
        """Show a message in all tabs."""
        self._notify(title, text, bad)

    def _report(self, error: Exception) -> None:
        _LOG.exception("in the thread of edits", exc_info=error)
        self.tell("Internal error of the builder", f"{type(error).__name__}: {error}", bad=True)

    def stop(self) -> None:
        """End the thread of edits."""
        self.edits.stop()
