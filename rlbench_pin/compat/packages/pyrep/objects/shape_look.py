"""What shapes look like."""

from __future__ import annotations

from typing import Any

from pyrep.const import TextureMappingMode
from pyrep.errors import UnsupportedCall
from pyrep.objects.object import Object
from rlbench_pin.compat.things import looks
from rlbench_pin.sim import read_texture


class ShapeLook(Object):
    """Colours, transparency and textures of shapes."""

    def get_color(self) -> list[float]:
        """Return red, green, blue in 0..1."""
        return [float(c) for c in looks.color(self.table, self.element)[:3]]

    def set_color(self, color: Any) -> None:
        """Colour the whole shape: a body with all its links, or one link alone.

        Args:
            color: red, green, blue in 0..1.
        """
        values = [float(c) for c in color]
        looks.paint(self.table, self.element, (*values[:3], looks.color(self.table, self.element)[3]))

    def get_transparency(self) -> float:
        """Return 0 for opaque, 1 for invisible."""
        return 1.0 - float(looks.color(self.table, self.element)[3])

    def set_transparency(self, value: float) -> None:
        """Set 0 for opaque to 1 for invisible; in between is drawn as opaque.

        Raises:
            ValueError: `value` is not in 0..1.
        """
        if not 0.0 <= value <= 1.0:
            raise ValueError(f"A transparency lies between 0 (opaque) and 1 (invisible), not {value}.")
        looks.paint(self.table, self.element, (*looks.color(self.table, self.element)[:3], 1.0 - float(value)))

    def set_renderable(self, value: bool) -> None:
        """Show the shape to cameras, or hide it."""
        if bool(value) == self.is_renderable():
            return
        self.set_flag("renderable", value)
        looks.show(self.table, self.element, bool(value))

    def set_texture(
        self,
        texture: Any,
        mapping_mode: TextureMappingMode = TextureMappingMode.PLANE,
        interpolate: bool = True,
        decal_mode: bool = False,
        repeat_along_u: bool = False,
        repeat_along_v: bool = False,
        uv_scaling: list[float] | None = None,
        position: list[float] | None = None,
        orientation: list[float] | None = None,
    ) -> None:
        """Put a texture on a body, a part of the room or a link of the arm.

        Args:
            texture: From `PyRep.create_texture`.
            mapping_mode: Accepted; textures lie along the axes of the shape.
            interpolate: Accepted.
            decal_mode: Accepted.
            repeat_along_u: Accepted; textures repeat.
            repeat_along_v: Accepted; textures repeat.
            uv_scaling: Length of the picture on the shape [m], two numbers; None is 1 m.
            position: Accepted.
            orientation: Accepted.
        """
        file = getattr(texture, "filename", None)
        if file is None:
            raise UnsupportedCall("set_texture", f"{texture!r} is no texture.", "Make one with `PyRep.create_texture(file)`.")
        repeats = 1.0 / float(uv_scaling[0]) if uv_scaling else 1.0
        looks.set_texture(self.table, self.element, read_texture(file), repeats)

    def get_texture(self) -> None:
        """Refused: a shape does not say which texture it has."""
        raise UnsupportedCall("get_texture", "textures are not read back.", "Keep what `create_texture` returned.")

    def remove_texture(self) -> None:
        """Show the shape's own colours again."""
        looks.remove_texture(self.table, self.element)
