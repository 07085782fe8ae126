"""Textures for shapes."""

from __future__ import annotations

import zlib
from dataclasses import dataclass


@dataclass(frozen=True)
class Texture:
    """A picture file that shapes can be covered with."""

    filename: str
    """Its file."""

    def get_texture_id(self) -> int:
        """Return a number that is the same for the same file."""
        return zlib.crc32(self.filename.encode())


class TextureHolder:
    """Stands for the shape that other simulators keep a texture on; there is none here."""

    def remove(self) -> None:
        """Nothing: a texture needs no shape."""
