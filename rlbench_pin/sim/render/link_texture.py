"""Textures on moving things: projected along the main axes of each link, whatever texture coordinates its mesh has."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.texture import Texture

_OTHERS = np.array([[1, 2], [0, 2], [0, 1]])


@dataclass(frozen=True, eq=False)
class LinkTexture:
    """A texture on one link."""

    texture: Texture
    repeats: float = 4.0
    """How often the texture repeats along one metre."""


def colors_of(
    link_texture: LinkTexture,
    frame: NDArray[np.float32],
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    metres_per_pixel: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Colours (n, 3) in 0..1 of points on a link.

    Args:
        link_texture: The texture on it.
        frame: Placement (4, 4) of the link in the world.
        points: World points (n, 3) [m].
        normals: Unit normals (n, 3) in the world.
        metres_per_pixel: Size of a pixel at each point (n,) [m].
    """
    rotation = frame[:3, :3]
    local, axis = (points - frame[:3, 3]) @ rotation, np.argmax(np.abs(normals @ rotation), axis=1)
    plane = np.take_along_axis(local, _OTHERS[axis], axis=1) * np.float32(link_texture.repeats)
    texture = link_texture.texture
    density = np.float32(texture.size * link_texture.repeats)
    return texture.texels[texture.indices(plane[:, 0], plane[:, 1], metres_per_pixel * density)]
