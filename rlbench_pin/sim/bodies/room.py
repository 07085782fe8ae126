"""Bodies of the room: PyBullet collides with them, the backdrop draws them."""

from __future__ import annotations

import numpy as np

from rlbench_pin.sim.bodies.body import Body, Color
from rlbench_pin.sim.bodies.model import BASE
from rlbench_pin.sim.client import bullet
from rlbench_pin.sim.render.backdrop import Panel
from rlbench_pin.sim.render.quads import read_quads
from rlbench_pin.sim.render.texture import Texture, read_texture
from rlbench_pin.spatial import FloatArray, pose_to_matrix

_REPEATS = 1.7  # of a foreign texture along one metre
_UNSEEN = (1.0, 1.0, 1.0, 0.0)


class RoomBody(Body):
    """Table, floor, a wall or the ceiling; hidden from PyBullet's renderers.

    Attributes:
        texture: Replaces its own textures and covers its plain parts, or None.
    """

    texture: Texture | None = None

    def hide(self) -> RoomBody:
        """Make it invisible to PyBullet's renderers."""
        self.model.client.change(bullet.changeVisualShape, self.model.uid, BASE, rgbaColor=_UNSEEN)
        return self

    def _paint(self, index: int, color: Color) -> None:
        self._colors[index] = color

    def _unpaint(self, index: int) -> None:
        del self._colors[index]

    def appearance(self) -> tuple[object, ...]:
        """All that its picture depends on, to compare."""
        place = bullet.getBasePositionAndOrientation(self.model.uid, physicsClientId=self.model.client.id)
        return (place, self._colors.get(BASE), self.texture)

    def panels(self, identifier: int) -> list[Panel]:
        """Its rectangles in the world.

        Args:
            identifier: Mask id.
        """
        pose, painted = pose_to_matrix(self.pose), self._colors.get(BASE)
        panels = []
        for quad in read_quads(self.model.urdf):
            texture = self.texture or (None if quad.texture is None else read_texture(quad.texture))
            color = quad.color if painted is None else painted[:3]
            if self.texture is not None and painted is None:
                color = (1.0, 1.0, 1.0)
            corner, edges = pose[:3, :3] @ quad.corner + pose[:3, 3], quad.edges @ pose[:3, :3].T
            uv = quad.uv if self.texture is None else _in_metres(quad.edges)
            panels.append(Panel(corner, edges, identifier, color, texture, uv))
        return panels


def _in_metres(edges: FloatArray) -> FloatArray:
    """Texture coordinates of a rectangle on which a texture repeats at an even pace."""
    lengths = _REPEATS * np.linalg.norm(edges, axis=1)
    return np.array([[0.0, 0.0], [lengths[0], 0.0], [0.0, lengths[1]]])
