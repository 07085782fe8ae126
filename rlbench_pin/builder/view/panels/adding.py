"""What can be added: assets of the catalogue, primitives, meshes of one's own, frames, regions, sensors and waypoints."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.assets import asset_path
from rlbench_pin.builder.server import Folder, read_mesh
from rlbench_pin.builder.view.parts.catalogue import Asset, catalogue, found, thumbnail
from rlbench_pin.builder.view.parts.meshes import mesh_asset
from rlbench_pin.builder.view.parts.primitives import PRIMITIVES, SIZES, primitive_urdf
from rlbench_pin.builder.view.parts.standing import standing_pose
from rlbench_pin.builder.view.posing import in_frame
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Choice, Fold, Item, Line, Note, Number, Picture, Upload
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import BodySpec
from rlbench_pin.scene.spec import ROOT
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import COLORS

_SHOWN = 6
_MOST_FILES = 40


class Adding:
    """The panel from which things are added.

    Args:
        session: What is being edited.
        tip: Returns the present pose (7,) of the tip of the arm that is shown.
    """

    def __init__(self, session: Session, tip: Callable[[], FloatArray]) -> None:
        self._session, self._tip = session, tip
        self._words, self._page = "", 0
        self._kind, self._sizes, self._mass, self._color = PRIMITIVES[0], [0.05, 0.05, 0.05], 0.1, "red"
        self._scale = 1.0

    def items(self) -> list[Item]:
        """Return all that can be added."""
        return [
            Fold("Waypoint", [Button("Add waypoint at the tip", self._add_waypoint)]),
            Fold("Objects", self._catalogue_items()),
            Fold("Box, cylinder, sphere", self._primitive_items(), is_open=False),
            Fold("Own mesh", self._mesh_items(), is_open=False),
            Fold("Own URDF", self._urdf_items(), is_open=False),
            Fold(
                "Frame, region, sensor",
                [
                    Button("Add frame", lambda: self._add("frame", {}, True)),
                    Button("Add region", lambda: self._add("region", {"size": (0.2, 0.2, 0.0)}, False)),
                    Button("Add sensor", lambda: self._add("sensor", _BALL, True)),
                ],
                is_open=False,
            ),
        ]

    def _add(self, table: str, values: dict[str, object], on_selected: bool) -> None:
        """Add a thing, perhaps hanging on what is selected."""
        parent: dict[str, object] = (
            {"parent": self._session.selected} if on_selected and self._session.thing(self._session.selected) else {}
        )
        self._session.add(table, {**parent, **values})

    # Waypoints -------------------------------------------------------------------------------------------------------

    def _add_waypoint(self) -> None:
        session, selected = self._session, self._session.selected
        parent = selected if session.table_of(selected) in ("body", "frame") else ROOT
        frame = session.places.of(parent)
        if frame is not None:
            session.add("waypoint", {"parent": parent, "pose": tuple(in_frame(self._tip(), frame).tolist())})

    # Objects ---------------------------------------------------------------------------------------------------------

    def _catalogue_items(self) -> list[Item]:
        hits = found(catalogue(), self._words)
        pages = max(1, -(-len(hits) // _SHOWN))
        self._page = min(self._page, pages - 1)
        shown = hits[self._page * _SHOWN : (self._page + 1) * _SHOWN]
        items: list[Item] = [Line("Search", self._words, self._search)]
        for asset in shown:
            items.append(Picture(asset.name, thumbnail(asset_path(asset.path))))
            items.append(Button(f"Add {asset.name}", self._adder(asset), hint=asset.words[:300]))
        items.append(Note(f"{len(hits)} objects, page {self._page + 1} of {pages}"))
        items.append(Button("Next page", lambda: self._turn(1), disabled=self._page + 1 >= pages))
        items.append(Button("Page before", lambda: self._turn(-1), disabled=self._page == 0))
        return items

    def _search(self, words: str) -> None:
        self._words, self._page = words, 0
        self._session.changed()

    def _turn(self, pages: int) -> None:
        self._page += pages
        self._session.changed()

    def _adder(self, asset: Asset) -> Callable[[], None]:
        extras: dict[str, object] = {"fixed": True, "collides": False} if asset.is_mark else {}
        return lambda: self._add_body(asset.path, extras)

    def _add_body(self, asset: str, extras: dict[str, object]) -> None:
        body = BodySpec(name="new_body", asset=asset)
        pose = standing_pose(self._session.spec, body)
        self._session.add("body", {"asset": asset, "pose": (*pose, 0.0, 0.0, 0.0, 1.0), **extras})

    # Own files -------------------------------------------------------------------------------------------------------

    def _primitive_items(self) -> list[Item]:
        words = SIZES[self._kind]

        def resize(number: int, value: float) -> None:
            self._sizes[number] = round(value, 4)

        sizes = [
            Number(f"{word} [m]", self._sizes[k], lambda value, k=k: resize(k, value), 0.01, 0.001, 2.0)  # type: ignore[misc]
            for k, word in enumerate(words)
        ]
        return [
            Choice("Solid", self._kind, PRIMITIVES, self._set_kind),
            *sizes,
            self._mass_item(),
            self._color_item(),
            Button("Add solid", self._add_primitive),
        ]

    def _mass_item(self) -> Number:
        def weigh(value: float) -> None:
            self._mass = value

        return Number("Mass [kg]", self._mass, weigh, 0.05, 0.001, 100.0)

    def _color_item(self) -> Choice:
        def dye(word: str) -> None:
            self._color = word

        return Choice("Colour", self._color, tuple(color.name for color in COLORS), dye)

    def _set_kind(self, word: str) -> None:
        self._kind = next(kind for kind in PRIMITIVES if kind == word)
        self._session.changed()

    def _rgb(self) -> tuple[float, float, float]:
        return next(color.rgb for color in COLORS if color.name == self._color)

    def _add_primitive(self) -> None:
        sizes = self._sizes[: len(SIZES[self._kind])]
        name = self._free_file(self._kind)
        text = primitive_urdf(name, self._kind, sizes, self._mass, self._rgb())
        self._folder().write(f"{name}.urdf", text.encode())
        self._add_body(f"./{name}.urdf", {"name": name})

    def _mesh_items(self) -> list[Item]:
        def rescale(value: float) -> None:
            self._scale = value

        return [
            Note("An OBJ or STL file of at most 64 MB, taken apart into convex parts."),
            Number("Scale, 0.001 for millimetres", self._scale, rescale, 0.001, 1e-6),
            self._mass_item(),
            self._color_item(),
            Upload("Upload a mesh", self._add_mesh),
        ]

    def _add_mesh(self, name: str, data: bytes) -> None:
        uploaded = read_mesh(name, data)
        made = mesh_asset(uploaded, self._scale, self._mass, self._rgb())
        folder = self._folder()
        stem = self._free_file(uploaded.name)
        for file, content in made.files.items():
            folder.write(f"{stem}/{file}", content)
        self._add_body(f"./{stem}/{made.urdf}", {"name": stem})

    def _urdf_items(self) -> list[Item]:
        """Return the URDF files beside the task; meshes that they name come with them."""
        folder = self._session.document.folder
        files = sorted(file.relative_to(folder).as_posix() for pattern in ("*.urdf", "*/*.urdf") for file in folder.glob(pattern))
        where = f"URDF files in the folder of the task, with the meshes that they name. {len(files)} there."
        return [Note(where), *(Button(f"Add {file}", self._adder_of(file)) for file in files[:_MOST_FILES])]

    def _adder_of(self, file: str) -> Callable[[], None]:
        return lambda: self._add_body(f"./{file}", {})

    def _folder(self) -> Folder:
        self._session.document.folder.mkdir(parents=True, exist_ok=True)
        return Folder(self._session.document.folder)

    def _free_file(self, stem: str) -> str:
        """Return a name that neither a file beside the task nor a thing of the scene has."""
        taken = {thing.name for thing in self._session.spec.posed()}
        folder = self._session.document.folder
        names = (stem if k == 0 else f"{stem}{k + 1}" for k in range(1000))
        free = (n for n in names if n not in taken and not (folder / f"{n}.urdf").exists() and not (folder / n).exists())
        name = next(free, None)
        if name is None:
            raise RlbenchPinError(f"There are a thousand files called '{stem}'. Remove some.")
        return name


_BALL: dict[str, object] = {"shape": "sphere", "size": (0.06,)}
