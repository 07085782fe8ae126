"""Textures for shapes; programs import this module as `pyrep.textures.texture`."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

from rlbench_pin.compat import add_aliases

add_aliases(__name__, ["texture"])


@dataclass(frozen=True)
class Texture:
    """A texture for shapes: an image file."""

    filename: str
    """Path of the image file."""

    def get_texture_id(self) -> int:
        """Return an identifier that depends only on the path of the file."""
        return zlib.crc32(self.filename.encode())


class TextureHolder:
    """Placeholder for the shape that holds a texture in other simulators."""

    def remove(self) -> None:
        """No effect: textures need no shape."""
