"""What is being edited, what is selected, and who is told: one for all tabs of the browser."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from rlbench_pin.builder.contracts import OpenedTask, PlannedPath, WaypointVerdict
from rlbench_pin.builder.document import Behaviour, HasDependants
from rlbench_pin.builder.view.contracts import Document
from rlbench_pin.builder.view.snapping import Snap
from rlbench_pin.builder.view.worker import Worker
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.spec import ROOT, PosedSpec
from rlbench_pin.viewer.places import Places, places_at_rest

_LOG = logging.getLogger(__name__)
_EMPTY = SceneSpec(format=2)


@dataclass
class Sight:
    """What the stage has seen of the scene as it stands."""

    opened: OpenedTask | None = None
    """What the task is; None before it was built."""
    verdicts: Mapping[str, WaypointVerdict] = field(default_factory=dict)
    """By name of the waypoint."""
    paths: tuple[PlannedPath, ...] = ()
    """Planned ways, where they were asked for."""
    work: str = ""
    """What the stage is doing; empty when it waits."""
    fault: str = ""
    """Why the last thing that it was asked for failed."""


class Session:
    """One task in the editor. What changes it runs in one thread, `edits`; listeners are told there.

    Args:
        document: The task.
        notify: Shows somebody a message: title, text, whether it is bad.

    Attributes:
        document: The task.
        edits: Where edits are made.
        sight: What the stage has seen.
        selected: Name of the selected thing; `root` is the placement of the task, empty is nothing.
        snap: What things that are dragged fall onto.
        drops_onto: Whether a thing that is dragged over a body hangs on it afterwards.
        needed: Why a thing was not deleted, until somebody decides; None otherwise.
        typed: Files in whose fields something is typed that is not applied.
    """

    def __init__(self, document: Document, notify: Callable[[str, str, bool], None]) -> None:
        self.document, self.sight, self.selected = document, Sight(), ""
        self.snap: Snap = "grid"
        self.drops_onto = False
        self.needed: HasDependants | None = None
        self.typed: set[str] = set()
        self._behaviour: tuple[str, Behaviour] | None = None
        self._notify = notify
        self._listeners: list[Callable[[], None]] = []
        self.edits = Worker("edits", self._internal)

    # Looking ---------------------------------------------------------------------------------------------------------

    @property
    def spec(self) -> SceneSpec:
        """The scene as the last valid text says it; an empty one before there was any."""
        return self.document.spec or _EMPTY

    @property
    def behaviour(self) -> Behaviour:
        """What forms can edit of the Python; it is read again only when the Python has changed."""
        text = self.document.python_text
        if self._behaviour is None or self._behaviour[0] != text:
            self._behaviour = (text, self.document.behaviour)
        return self._behaviour[1]

    @property
    def places(self) -> Places:
        """Where everything stands at rest."""
        return places_at_rest(self.spec)

    def thing(self, name: str) -> PosedSpec | None:
        """Return a body, frame, region, sensor or waypoint; None where there is none of that name."""
        return next((thing for thing in self.spec.posed() if thing.name == name), None)

    def table_of(self, name: str) -> str:
        """Return `body`, `frame`, `region`, `sensor` or `waypoint`; empty for another name."""
        spec = self.spec
        tables = {"body": spec.body, "frame": spec.frame, "region": spec.region, "sensor": spec.sensor, "waypoint": spec.waypoint}
        return next((table for table, things in tables.items() if any(t.name == name for t in things)), "")

    # Changing --------------------------------------------------------------------------------------------------------

    def listen(self, listener: Callable[[], None]) -> None:
        """Have a function called, in the thread of edits, after whatever changed."""
        self._listeners.append(listener)

    def post(self, job: Callable[[], None], kind: str = "") -> None:
        """Have something done in the thread of edits; of several of one kind that wait, the last counts."""
        self.edits.post(lambda: self._do(job), kind)

    def do(self, edit: Callable[[Document], object]) -> None:
        """Make an edit; to be called in the thread of edits. What is refused is told."""
        self.needed = None
        try:
            edit(self.document)
        except RlbenchPinError as error:
            self.tell("Not done", str(error), bad=True)
        self.select(self.selected)

    def _do(self, job: Callable[[], None]) -> None:
        try:
            job()
        except RlbenchPinError as error:
            self.tell("Not done", str(error), bad=True)

    def select(self, name: str) -> None:
        """Select a thing; a name that there is none of selects nothing."""
        if self.needed is not None and self.needed.name != name:
            self.needed = None
        self.selected = name if name == ROOT or self.thing(name) is not None else ""
        self.changed()

    def add(self, table: str, values: Mapping[str, object]) -> str:
        """Add a thing and select it; returns its name, empty where it is refused."""
        added: list[str] = []
        self.do(lambda document: added.append(document.add(table, values)))
        if added:
            self.select(added[0])
        return added[0] if added else ""

    def typing(self, file: str, is_typed: bool) -> None:
        """Take note of whether something is typed in the field of a file that is not applied."""
        (self.typed.add if is_typed else self.typed.discard)(file)
        self.changed()

    def save(self) -> None:
        """Save both files, and say what is left out."""
        self.do(lambda document: document.save())
        if not self.document.unsaved:
            self.tell("Saved", f"{self.document.folder / self.document.name}.toml and .py")
        if self.typed:
            self.tell("Not saved", f"What is typed in {' and '.join(sorted(self.typed))}: press Apply in Files first.", bad=True)

    def changed(self) -> None:
        """Tell all listeners."""
        for listener in self._listeners:
            listener()

    def tell(self, title: str, text: str, bad: bool = False) -> None:
        """Show a message in all tabs."""
        self._notify(title, text, bad)

    def _internal(self, error: Exception) -> None:
        _LOG.exception("in the thread of edits", exc_info=error)
        self.tell("A mistake of the builder", f"{type(error).__name__}: {error}", bad=True)

    def stop(self) -> None:
        """End the thread of edits."""
        self.edits.stop()
