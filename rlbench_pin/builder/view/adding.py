"""The tab *Add*: waypoints, frames, regions, sensors, objects of the catalogue, primitives, uploaded files."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial

from rlbench_pin.assets import asset_path
from rlbench_pin.builder.custom_assets.conversion import Conversion, Job
from rlbench_pin.builder.custom_assets.folder import Folder
from rlbench_pin.builder.custom_assets.mesh_asset import CustomAsset
from rlbench_pin.builder.custom_assets.uploads import UploadRefused, check_size, upload_stem
from rlbench_pin.builder.custom_assets.urdf_file import MAX_TEXT_SIZE, checked_model
from rlbench_pin.builder.document import EditRefused
from rlbench_pin.builder.view.catalogue import PRIMITIVES, SIZES, Asset, catalogue, model_size, primitive_urdf, search, thumbnail
from rlbench_pin.builder.view.placing import free_place, in_frame, own_points, top_grasp
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Panel
from rlbench_pin.errors import RlbenchPinError, storing
from rlbench_pin.robot import DEFAULT_ROBOT, robot_description
from rlbench_pin.scene import BodySpec
from rlbench_pin.scene.spec import ROOT
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import COLORS

_PAGE_SIZE = 8
_MAX_FILES = 40
_OPENING = 2.0 * robot_description(DEFAULT_ROBOT).gripper_open
"""Distance between the open fingers [m]."""
_SENSOR: dict[str, object] = {"shape": "sphere", "size": (0.06,)}


class Adding:
    """Adds elements to the scene.

    Args:
        session: The edited task.
        tip: Returns the current pose (7,) of the tip of the shown arm.

    Attributes:
        conversion: The running conversion of an uploaded file; None if there is none.
    """

    def __init__(self, session: Session, tip: Callable[[], FloatArray]) -> None:
        self._session, self._tip = session, tip
        self._words, self._page = "", 0
        self._kind, self._sizes, self._mass, self._color = PRIMITIVES[0], [0.05, 0.05, 0.05], 0.1, "red"
        self._scale, self._urdf_mass, self._step = 1.0, 0.0, ""
        self.conversion: Conversion | None = None

    def show(self, panel: Panel) -> None:
        """Show the controls."""
        with panel.folder("Waypoint") as folder:
            self._show_waypoint(folder)
        with panel.folder("Frame, region, sensor") as folder:
            folder.button("Add frame", lambda: self._add_on_selected("frame", {}))
            folder.button("Add region", lambda: self._add("region", {"size": (0.2, 0.2, 0.0)}))
            folder.button("Add sensor", lambda: self._add_on_selected("sensor", _SENSOR))
        with panel.folder("Objects") as folder:
            self._show_catalogue(folder)
        with panel.folder("Box, cylinder, sphere", is_open=False) as folder:
            self._show_primitives(folder)
        with panel.folder("Custom mesh", is_open=False) as folder:
            self._show_mesh_upload(folder)
        with panel.folder("Custom URDF", is_open=False) as folder:
            self._show_urdf_upload(folder)

    def close(self) -> None:
        """Stop a running conversion."""
        if self.conversion is not None:
            self.conversion.stop()

    def _add(self, table: str, values: dict[str, object]) -> None:
        self._session.do_and_select(lambda document: document.add(table, values))

    def _add_on_selected(self, table: str, values: dict[str, object]) -> None:
        """Add an element, attached to the selected one if there is one."""
        selected = self._session.selected
        self._add(table, {"parent": selected, **values} if self._session.element(selected) else values)

    def _show_waypoint(self, panel: Panel) -> None:
        body = self._selected_body()
        name = "the selected object" if body is None else body.name
        hint = "The gripper points down. Select a body, or an element on one."
        panel.button("Add waypoint at the tip", self._add_waypoint)
        for word, closes in (("Above", False), ("Grasp", True)):
            press = partial(self._add_on_body, closes)
            panel.button(f"{word} {name}", press, hint=hint, disabled=body is None, key=word)

    def _selected_body(self) -> BodySpec | None:
        """Return the selected body, or the one to which the selected element is attached."""
        session = self._session
        names = [body.name for body in session.spec.body]
        element = session.element(session.selected)
        for _ in session.spec.posed():
            if element is None or element.name in names:
                break
            element = session.element(element.parent.partition("/")[0])
        return element if isinstance(element, BodySpec) else None

    def _add_on_body(self, closes: bool) -> None:
        """Add a waypoint above the selected body, or one that grasps it."""
        session, body = self._session, self._selected_body()
        frame = None if body is None else session.places.of(body.name)
        if body is None or frame is None:
            return
        edit = f"add a {'grasp of' if closes else 'waypoint above'} '{body.name}'"
        points = own_points(session.spec, body)
        if len(points) == 0:
            raise EditRefused(edit, "its model has no shape.", "Add a waypoint at the tip.")
        grasp = top_grasp(frame, points)
        values: dict[str, object] = {"ignore_collisions": True, "gripper": "close"} if closes else {}
        if closes and grasp.width > _OPENING:
            problem = f"it is {100.0 * grasp.width:.1f} cm wide, and the gripper opens {100.0 * _OPENING:.0f} cm."
            raise EditRefused(edit, problem, "Add a waypoint at the tip, and move it to a narrower part.")
        pose = in_frame(grasp.pose if closes else grasp.above(), frame)
        self._add("waypoint", {"parent": body.name, "pose": tuple(pose.tolist()), "symmetry": grasp.symmetry, **values})

    def _add_waypoint(self) -> None:
        session, selected = self._session, self._session.selected
        parent = selected if session.table_of(selected) in ("body", "frame") else ROOT
        frame = session.places.of(parent)
        if frame is not None:
            self._add("waypoint", {"parent": parent, "pose": tuple(in_frame(self._tip(), frame).tolist())})

    def _add_body(self, asset: str, values: dict[str, object]) -> None:
        pose = free_place(self._session.spec, BodySpec(name="new_body", asset=asset))
        self._add("body", {"asset": asset, "pose": (*pose, 0.0, 0.0, 0.0, 1.0), **values})

    # Catalogue and primitives ----------------------------------------------------------------------------------------

    def _show_catalogue(self, panel: Panel) -> None:
        def set_words(words: str) -> None:
            self._words, self._page = words, 0
            self._session.changed()

        def turn(pages: int) -> None:
            self._page += pages
            self._session.changed()

        def add(asset: Asset) -> None:
            self._add_body(asset.path, {"fixed": True, "collides": False} if asset.is_mark else {})

        hits = search(catalogue(), self._words)
        pages = max(1, -(-len(hits) // _PAGE_SIZE))
        self._page = min(self._page, pages - 1)
        panel.text("Search", self._words, set_words)
        shown = hits[self._page * _PAGE_SIZE : (self._page + 1) * _PAGE_SIZE]
        with panel.grid("Found") as grid:
            for row in (shown[first : first + 2] for first in range(0, len(shown), 2)):
                for asset in row:
                    file = asset_path(asset.path)
                    size = " x ".join(f"{100.0 * side:.3g}" for side in model_size(file))
                    grid.image(f"{asset.name}, {size} cm", thumbnail(file))
                if len(row) == 1:
                    grid.html("")
                for asset in row:
                    grid.button(f"Add {asset.name}", lambda asset=asset: add(asset), hint=asset.words[:300])  # type: ignore[misc]
        panel.note(f"{len(hits)} objects, page {self._page + 1} of {pages}")
        panel.button("Next page", lambda: turn(1), disabled=self._page + 1 >= pages)
        panel.button("Page before", lambda: turn(-1), disabled=self._page == 0)

    def _show_primitives(self, panel: Panel) -> None:
        def set_kind(word: str) -> None:
            self._kind = next(kind for kind in PRIMITIVES if kind == word)
            self._session.changed()

        def resize(number: int, value: float) -> None:
            self._sizes[number] = round(value, 4)

        def add() -> None:
            name = self._free_name(self._kind)
            sizes = self._sizes[: len(SIZES[self._kind])]
            text = primitive_urdf(name, self._kind, sizes, self._mass, self._rgb())
            self._folder().write(f"{name}.urdf", text.encode())
            self._add_body(f"./{name}.urdf", {"name": name})

        panel.dropdown("Solid", self._kind, PRIMITIVES, set_kind)
        for number, word in enumerate(SIZES[self._kind]):
            label, size = f"{word} [m]", self._sizes[number]
            panel.number(label, size, lambda value, k=number: resize(k, value), 0.01, 0.001, 2.0)  # type: ignore[misc]
        self._show_mass_and_color(panel)
        panel.button("Add solid", add)

    def _show_mass_and_color(self, panel: Panel) -> None:
        """Show mass and colour, which primitives and meshes share."""

        def set_mass(value: float) -> None:
            self._mass = value

        def set_color(word: str) -> None:
            self._color = word

        panel.number("Mass [kg]", self._mass, set_mass, 0.05, 0.001, 100.0)
        panel.dropdown("Colour", self._color, tuple(color.name for color in COLORS), set_color)

    def _rgb(self) -> tuple[float, float, float]:
        return next(color.rgb for color in COLORS if color.name == self._color)

    # Uploaded files --------------------------------------------------------------------------------------------------

    def _show_mesh_upload(self, panel: Panel) -> None:
        mass, color = self._mass, self._rgb()
        panel.note("An OBJ or STL file of at most 64 MB, decomposed into convex parts.")
        self._show_scale(panel)
        self._show_mass_and_color(panel)
        panel.upload("Upload a mesh", lambda name, data: self._convert(name, data, mass, color))
        self._show_conversion(panel)

    def _show_urdf_upload(self, panel: Panel) -> None:
        def set_mass(value: float) -> None:
            self._urdf_mass = value

        def add(file: str) -> None:
            with self._folder().path(file).open("rb") as stream:
                checked_model(file, stream.read(MAX_TEXT_SIZE + 1))
            self._add_body(f"./{file}", {})

        panel.note("A URDF file with meshes in the folder of the task, or a ZIP file with one URDF file and its meshes.")
        self._show_scale(panel)
        panel.number("Mass [kg], 0 keeps the mass of the file", self._urdf_mass, set_mass, 0.05, 0.0, 1000.0)
        gray = (0.8, 0.8, 0.8)
        panel.upload("Upload a URDF or ZIP", lambda name, data: self._convert(name, data, self._urdf_mass, gray))
        self._show_conversion(panel)
        folder = self._session.document.folder
        files = sorted(file.relative_to(folder).as_posix() for pattern in ("*.urdf", "*/*.urdf") for file in folder.glob(pattern))
        panel.note(f"URDF files in the folder of the task: {len(files)}")
        for file in files[:_MAX_FILES]:
            panel.button(f"Add {file}", lambda file=file: add(file))  # type: ignore[misc]

    def _show_scale(self, panel: Panel) -> None:
        def set_scale(value: float) -> None:
            self._scale = value

        panel.number("Scale, 0.001 for millimetres", self._scale, set_scale, 0.001, 1e-6)

    def _show_conversion(self, panel: Panel) -> None:
        if self.conversion is not None:
            panel.note(f"**{self._step}** ...")
            panel.button("Stop", self.conversion.stop, "red")

    def _convert(self, name: str, data: bytes, mass: float, color: tuple[float, ...]) -> None:
        """Start the conversion of a file."""
        check_size(name, len(data))
        if self.conversion is not None:
            raise UploadRefused(
                name, f"'{self.conversion.name}' is still being converted", "Send it again afterwards, or stop the conversion."
            )
        session = self._session
        self._step = f"Reading '{name}'"
        self.conversion = Conversion(
            Job(name, str(session.document.folder), self._scale, mass, color),
            data,
            on_note=lambda text: session.post(lambda: self._show_step(text), "conversion"),
            on_end=lambda found: session.post(lambda: self._take(name, found)),
        )
        session.changed()

    def _show_step(self, text: str) -> None:
        if self.conversion is not None:
            self._step = text
            self._session.changed()

    def _take(self, name: str, found: CustomAsset | RlbenchPinError) -> None:
        """Write the asset to the folder of the task, and add it; or report the error."""
        self.conversion = None
        self._session.changed()
        if isinstance(found, RlbenchPinError):
            raise found
        stem = self._free_name(upload_stem(name))
        self._folder().write_all(stem, found.files)
        self._add_body(f"./{stem}/{found.urdf}", {"name": stem})

    def _folder(self) -> Folder:
        """Return the folder of the task, which is created if necessary."""
        folder = self._session.document.folder
        with storing(folder):
            folder.mkdir(parents=True, exist_ok=True)
            return Folder(folder)

    def _free_name(self, stem: str) -> str:
        """Return a name that no file in the folder of the task and no element of the scene has."""
        taken = {*(element.name for element in self._session.spec.posed()), self._session.document.name}
        folder = self._session.document.folder
        names = (stem if number == 1 else f"{stem}{number}" for number in itertools.count(1))
        return next(n for n in names if n not in taken and not (folder / f"{n}.urdf").exists() and not (folder / n).exists())
