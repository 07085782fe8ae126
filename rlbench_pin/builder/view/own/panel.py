"""The panel that takes meshes and URDF files of one's own; others can edit meanwhile."""

from __future__ import annotations

import itertools
from collections.abc import Callable

from rlbench_pin.builder.server import Folder, UploadRefused, upload_stem
from rlbench_pin.builder.view.own.making import Making
from rlbench_pin.builder.view.own.solids import OwnAsset
from rlbench_pin.builder.view.own.tree import checked_model
from rlbench_pin.builder.view.own.workshop import Order
from rlbench_pin.builder.view.own.xml_text import LARGEST_TEXT
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Fold, Item, Note, Number, Upload
from rlbench_pin.errors import RlbenchPinError, StorageError

_MOST_FILES = 40
AddBody = Callable[[str, dict[str, object]], None]
"""Adds a body: its asset as the scene names it, and more keys."""


class OwnFiles:
    """Takes files, has assets made of them, and adds these to the scene.

    Args:
        session: What is being edited.
        add_body: Adds a body.
        look: Returns items that set mass and colour, which are shared with other panels, and what they say.
    """

    def __init__(
        self, session: Session, add_body: AddBody, look: Callable[[], tuple[list[Item], float, tuple[float, ...]]]
    ) -> None:
        self._session, self._add_body, self._look = session, add_body, look
        self._scale, self._mass, self._doing = 1.0, 0.0, ""
        self._making: Making | None = None

    def items(self) -> list[Item]:
        """Return both folds."""
        return [
            Fold("Own mesh", self._mesh_items(), is_open=False),
            Fold("Own URDF", self._urdf_items(), is_open=False),
        ]

    def close(self) -> None:
        """End what is being made."""
        if self._making is not None:
            self._making.stop()

    # Items -----------------------------------------------------------------------------------------------------------

    def _mesh_items(self) -> list[Item]:
        more, mass, color = self._look()
        return [
            Note("An OBJ or STL file of at most 64 MB, taken apart into convex parts."),
            self._scale_item(),
            *more,
            Upload("Upload a mesh", lambda name, data: self._begin(name, data, mass, color)),
            *self._work_items(),
        ]

    def _urdf_items(self) -> list[Item]:
        def weigh(value: float) -> None:
            self._mass = value

        folder = self._session.document.folder
        files = sorted(file.relative_to(folder).as_posix() for pattern in ("*.urdf", "*/*.urdf") for file in folder.glob(pattern))
        return [
            Note("A URDF file whose meshes are in the folder of the task, or a ZIP file with one URDF file and its meshes."),
            self._scale_item(),
            Number("Mass [kg], 0 as the file says", self._mass, weigh, 0.05, 0.0, 1000.0),
            Upload("Upload a URDF or ZIP", lambda name, data: self._begin(name, data, self._mass, (0.8, 0.8, 0.8))),
            *self._work_items(),
            Note(f"URDF files in the folder of the task: {len(files)}"),
            *(Button(f"Add {file}", self._adder_of(file)) for file in files[:_MOST_FILES]),
        ]

    def _work_items(self) -> list[Item]:
        if self._making is None:
            return []
        return [Note(f"**{self._doing}** ..."), Button("Stop", self._making.stop, shade="red")]

    def _scale_item(self) -> Number:
        def rescale(value: float) -> None:
            self._scale = value

        return Number("Scale, 0.001 for millimetres", self._scale, rescale, 0.001, 1e-6)

    def _adder_of(self, file: str) -> Callable[[], None]:
        def add() -> None:
            with self.folder().path(file).open("rb") as stream:
                checked_model(file, stream.read(LARGEST_TEXT + 1))
            self._add_body(f"./{file}", {})

        return add

    # What happens ----------------------------------------------------------------------------------------------------

    def _begin(self, name: str, data: bytes, mass: float, color: tuple[float, ...]) -> None:
        """Have an asset made of a file; what follows comes from another thread."""
        if self._making is not None:
            raise UploadRefused(name, f"'{self._making.name}' is still being made", "Send it again afterwards, or stop that.")
        session = self._session
        order = Order(name, str(session.document.folder), self._scale, mass, color)
        self._doing = f"Looking at '{name}'"
        self._making = Making(
            order,
            data,
            on_note=lambda text: session.post(lambda: self._tell(text), "own file"),
            on_end=lambda found: session.post(lambda: self._take(name, found)),
        )
        session.changed()

    def _tell(self, text: str) -> None:
        if self._making is not None:
            self._doing = text
            self._session.changed()

    def _take(self, name: str, found: OwnAsset | RlbenchPinError) -> None:
        """Put an asset beside the task, and add it; or tell why there is none."""
        self._making = None
        self._session.changed()
        if isinstance(found, RlbenchPinError):
            raise found
        stem = self.free_name(upload_stem(name))
        self.folder().write_all(stem, found.files)
        self._add_body(f"./{stem}/{found.urdf}", {"name": stem})

    # Names beside the task -------------------------------------------------------------------------------------------

    def folder(self) -> Folder:
        """Return the folder of the task, which is made when it is not there."""
        folder = self._session.document.folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            return Folder(folder)
        except OSError as error:
            raise StorageError(folder, error) from error

    def free_name(self, stem: str) -> str:
        """Return a name that neither a file beside the task nor a thing of the scene has."""
        taken = {*(thing.name for thing in self._session.spec.posed()), self._session.document.name}
        folder = self._session.document.folder
        names = (stem if number == 1 else f"{stem}{number}" for number in itertools.count(1))
        return next(n for n in names if n not in taken and not (folder / f"{n}.urdf").exists() and not (folder / n).exists())
