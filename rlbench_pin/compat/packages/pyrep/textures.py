"""Textures for shapes; programs import this module as `pyrep.textures.texture`."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

from rlbench_pin.compat import add_aliases

add_aliases(__name__, ["texture"])


@dataclass(frozen=True)
class Texture:
    """An image file that shapes can be covered with."""

    filename: str
    """Its file."""

    def get_texture_id(self) -> int:
        """Return a number that is the same for the same file."""
        return zlib.crc32(self.filename.encode())


class TextureHolder:
    """Placeholder for the shape of a texture in other simulators."""

    def remove(self) -> None:
        """No effect: a texture needs no shape."""
