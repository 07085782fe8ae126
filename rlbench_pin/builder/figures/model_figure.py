"""One URDF model in the browser: a node for each link, its visuals below it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from viser import FrameHandle, MeshHandle, SceneApi

from rlbench_pin.builder.figures.surfaces import DrawnSurface, drawn_surface
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import UrdfLink, read_urdf

Rgb = tuple[int, int, int]
"""Red, green, blue from 0 to 255."""
OnPick = Callable[[str], None]
"""Called with what somebody clicked on."""
_UNCOLORED = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Look:
    """How a model is drawn."""

    color: tuple[float, ...] | None = None
    """Red, green, blue and perhaps opacity from 0 to 1 of all its visuals; None takes those of the file."""
    scale: float = 1.0
    """Factor on its lengths."""


class ModelFigure:
    """The links of one model, which are moved one by one.

    Args:
        scene: Where it is drawn.
        path: Name of its node, such as `/bodies/cup`.
        urdf: The model's file.
        look: How it is drawn.
        picked: What `on_pick` is told; `{link}` in it becomes the name of the link.
        on_pick: Called when somebody clicks on a link.

    Raises:
        AssetNotFound: The file or one of its meshes does not exist.
        AssetInvalid: The file or one of its meshes cannot be read.
    """

    def __init__(
        self, scene: SceneApi, path: str, urdf: Path, look: Look, picked: str = "{link}", on_pick: OnPick | None = None
    ) -> None:
        self._scene, self._look, self._on_pick = scene, look, on_pick
        links = read_urdf(urdf).links
        surfaces = {link.name: tuple(drawn_surface(s, look.scale) for s in link.visuals if s.kind) for link in links}
        self._top = scene.add_frame(path, show_axes=False)
        self._frames: dict[str, FrameHandle] = {}
        self._parts: dict[str, list[tuple[MeshHandle, Rgb]]] = {}
        self._worn: dict[str, Rgb] = {}
        for number, link in enumerate(links):
            node = f"{path}/{number}"
            self._frames[link.name] = scene.add_frame(node, show_axes=False)
            self._parts[link.name] = self._draw(node, link, surfaces[link.name], picked.replace("{link}", link.name))

    def _draw(self, node: str, link: UrdfLink, surfaces: tuple[DrawnSurface, ...], picked: str) -> list[tuple[MeshHandle, Rgb]]:
        parts = []
        colors = [shape.color for shape in link.visuals if shape.kind]
        for number, (surface, own) in enumerate(zip(surfaces, colors, strict=True)):
            red, green, blue, alpha = (*(self._look.color or own or _UNCOLORED), 1.0)[:4]
            rgb = (round(255 * red), round(255 * green), round(255 * blue))
            part = self._scene.add_mesh_simple(
                f"{node}/{number}",
                surface.corners,
                surface.triangles,
                color=rgb,
                opacity=None if alpha >= 1.0 else alpha,
                side="double" if alpha < 1.0 else "front",
                cast_shadow=alpha >= 1.0,
            )
            if self._on_pick is not None:
                self._let_pick(part, picked, self._on_pick)
            parts.append((part, rgb))
        return parts

    def _let_pick(self, part: MeshHandle, picked: str, on_pick: OnPick) -> None:
        @part.on_click
        def _(_: object) -> None:
            on_pick(picked)

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links that are drawn."""
        return tuple(self._frames)

    def move(self, poses: Mapping[str, FloatArray]) -> None:
        """Put links at world poses (7,), by the name of the link; those that are not drawn are passed over."""
        for link, pose in poses.items():
            if (frame := self._frames.get(link)) is not None:
                frame.position = (pose[0], pose[1], pose[2])
                frame.wxyz = (pose[6], pose[3], pose[4], pose[5])

    def paint(self, link: str, rgb: Rgb | None) -> None:
        """Show one link in one colour; None gives it its own colours back."""
        for part, own in self._parts.get(link, ()):
            color = self._worn.get(link, own) if rgb is None else rgb
            if tuple(part.color) != color:
                part.color = color

    def wear(self, link: str, rgb: Rgb | None) -> None:
        """Give one link a colour that is its own from now on; None that which it was drawn with."""
        if rgb != self._worn.get(link):
            self._worn.pop(link, None)
            if rgb is not None:
                self._worn[link] = rgb
            self.paint(link, None)

    def show(self, visible: bool) -> None:
        """Let it be seen or not."""
        self._top.visible = visible

    def remove(self) -> None:
        """Take it out of the scene."""
        self._top.remove()
