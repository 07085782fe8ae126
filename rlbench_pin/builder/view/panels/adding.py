"""What can be added: assets of the catalogue, primitives, files of one's own, frames, regions, sensors and waypoints."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.assets import asset_path
from rlbench_pin.builder.view.own.panel import OwnFiles
from rlbench_pin.builder.view.parts.catalogue import Asset, catalogue, found, thumbnail
from rlbench_pin.builder.view.parts.primitives import PRIMITIVES, SIZES, primitive_urdf
from rlbench_pin.builder.view.parts.standing import standing_pose
from rlbench_pin.builder.view.posing import in_frame
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Choice, Fold, Item, Line, Note, Number, Picture
from rlbench_pin.scene import BodySpec
from rlbench_pin.scene.spec import ROOT
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import COLORS

_SHOWN = 6


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
        self._own = OwnFiles(session, self._add_body, self._look)

    def items(self) -> list[Item]:
        """Return all that can be added."""
        return [
            Fold("Waypoint", [Button("Add waypoint at the tip", self._add_waypoint)]),
            Fold("Objects", self._catalogue_items()),
            Fold("Box, cylinder, sphere", self._primitive_items(), is_open=False),
            *self._own.items(),
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

    def close(self) -> None:
        """End what is being made."""
        self._own.close()

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

    # Solids ----------------------------------------------------------------------------------------------------------

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
        name = self._own.free_name(self._kind)
        text = primitive_urdf(name, self._kind, sizes, self._mass, self._rgb())
        self._own.folder().write(f"{name}.urdf", text.encode())
        self._add_body(f"./{name}.urdf", {"name": name})

    def _look(self) -> tuple[list[Item], float, tuple[float, ...]]:
        """Return what sets mass and colour, and what they are."""
        return [self._mass_item(), self._color_item()], self._mass, self._rgb()


_BALL: dict[str, object] = {"shape": "sphere", "size": (0.06,)}
