"""All that moves in a world, as triangles in the frames of its links."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.bodies.model import BASE
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.render.masks import segment_of
from rlbench_pin.sim.render.raster.layers import Layers
from rlbench_pin.sim.render.raster.meshes import Triangles, triangles_of
from rlbench_pin.sim.render.raster.parts import Parts, Placed, Visual, join

_GRAIN = 2.0**-18
"""Step of positions [m] and quaternions: 4 um."""
Visuals = dict[tuple[int, int], tuple[tuple[float, ...], ...]]
"""Something of each visual of some links, by body and link number, in file order."""


@dataclass(frozen=True)
class Looks:
    """What PyBullet does not tell of visuals."""

    mixed_colors: Callable[[], Visuals] = dict
    """Returns rgba of links whose visuals differ and show it. Once such a link was painted and is no more, PyBullet tells the
    colour of its last visual for all."""
    gloss: Callable[[], Visuals] = dict
    """Returns the share of red, green, blue that visuals throw back like mirrors, of links that have such."""


class Stage:
    """Reads what a physics server shows.

    Args:
        client: The server.
        room: Numbers of the bodies that are left out.
        looks: What the server does not tell.

    Attributes:
        layers: What was drawn of these shapes and stands still.
    """

    def __init__(self, client: PhysicsClient, room: frozenset[int], looks: Looks) -> None:
        self._client, self._room, self._looks = client, room, looks
        self._mixed: Visuals = {}
        self._entries: list[tuple] = []
        self._visuals: tuple[Visual, ...] = ()
        self._placed: Placed | None = None
        self.layers = Layers()
        self._bodies: dict[int, int] = {}
        self._from_com: dict[int, NDArray] = {}
        self._colors: NDArray[np.float32] = np.zeros((0, 4), dtype=np.float32)
        self._gloss: NDArray[np.float32] = np.zeros((0, 3), dtype=np.float32)

    def update(self) -> Placed | None:
        """Take shapes, colours and places of this instant; None when there is a shape that cannot be drawn here."""
        identifier = self._client.id
        uids = [
            bullet.getBodyUniqueId(i, physicsClientId=identifier) for i in range(bullet.getNumBodies(physicsClientId=identifier))
        ]
        entries = [entry for uid in uids if uid not in self._room for entry in _entries_of(uid, identifier)]
        mixed = self._looks.mixed_colors()
        if entries != self._entries or mixed != self._mixed:
            self._entries, self._mixed = entries, mixed
            self._colors, self._gloss = _colors_of(entries, mixed), _gloss_of(entries, self._looks.gloss())
            visuals = tuple(_visual(entry) for entry in entries)
            if visuals != self._visuals:
                parts = _parts(visuals)
                self._visuals, self._placed, self.layers = visuals, None if parts is None else Placed(parts), Layers()
                bodies = {visual.body: bullet.getNumJoints(visual.body, physicsClientId=identifier) for visual in visuals}
                self._from_com = {body: self._com(body) for body in bodies}
                self._bodies = bodies
        if self._placed is not None:
            self._placed.place(self._placements())
        return self._placed

    @property
    def colors(self) -> NDArray[np.float32]:
        """Colour rgba in 0..1 of each visual (n, 4)."""
        return self._colors

    @property
    def gloss(self) -> NDArray[np.float32]:
        """Share of red, green, blue that each visual throws back like a mirror (n, 3)."""
        return self._gloss

    def _placements(self) -> dict[tuple[int, int], NDArray[np.float64]]:
        """Matrix (4, 4) of the frame of every link now, by body and link."""
        keys: list[tuple[int, int]] = []
        poses: list[tuple[float, ...]] = []
        identifier = self._client.id
        for body, joints in self._bodies.items():
            position, quaternion = bullet.getBasePositionAndOrientation(body, physicsClientId=identifier)
            keys.append((body, BASE))
            poses.append((*position, *quaternion))
            if joints:
                states = bullet.getLinkStates(body, range(joints), computeForwardKinematics=1, physicsClientId=identifier)
                keys += [(body, link) for link in range(joints)]
                poses += [(*state[4], *state[5]) for state in states]
        # what rests trembles by less than a pixel can show; rounded, it stands still
        matrices = dict(zip(keys, _matrices(np.round(np.array(poses).reshape(-1, 7) / _GRAIN) * _GRAIN)))
        for body, offset in self._from_com.items():
            matrices[body, BASE] = matrices[body, BASE] @ offset
        return matrices

    def _com(self, body: int) -> NDArray:
        """Base link frame (4, 4) in the inertial frame, by which PyBullet poses a body."""
        dynamics = bullet.getDynamicsInfo(body, BASE, physicsClientId=self._client.id)
        return np.linalg.inv(_matrices(np.array([[*dynamics[3], *dynamics[4]]]))[0])


def _entries_of(uid: int, identifier: int) -> tuple[tuple, ...]:
    flag = bullet.VISUAL_SHAPE_DATA_TEXTURE_UNIQUE_IDS
    entries: tuple[tuple, ...] = bullet.getVisualShapeData(uid, flags=flag, physicsClientId=identifier)
    return entries


def _colors_of(entries: list[tuple], mixed: Visuals) -> NDArray[np.float32]:
    """Return the colour of each visual (n, 4), to six digits as bodies keep them; under a texture it is what PyBullet has."""
    left = {link: list(colors) for link, colors in mixed.items()}
    colors = np.round(np.array([entry[7] for entry in entries]).reshape(-1, 4), 6)
    for shown, entry in zip(colors, entries):
        if entry[:2] in left:
            own = left[entry[:2]].pop(0)
            if tuple(shown) == mixed[entry[:2]][-1]:
                shown[:] = own
    return colors.astype(np.float32)


def _gloss_of(entries: list[tuple], known: Visuals) -> NDArray[np.float32]:
    left = {link: list(gloss) for link, gloss in known.items()}
    own = [left[entry[:2]].pop(0) if left.get(entry[:2]) else (0.0, 0.0, 0.0) for entry in entries]
    return np.array(own, dtype=np.float32).reshape(-1, 3)


def _visual(entry: tuple) -> Visual:
    return Visual(entry[0], entry[1], entry[2], entry[3], entry[4].decode(), entry[5], entry[6], entry[8] >= 0)


def _parts(visuals: tuple[Visual, ...]) -> Parts | None:
    """Read all shapes; None when one cannot be drawn."""
    placed: dict[tuple[int, int], list[tuple[int, Triangles]]] = {}
    for number, visual in enumerate(visuals):
        triangles = triangles_of(visual.kind, visual.size, visual.file)
        if triangles is None or visual.is_textured:
            return None
        frame = _matrices(np.array([[*visual.position, *visual.quaternion]]))[0]
        corners = triangles.corners @ frame[:3, :3].T + frame[:3, 3]
        moved = Triangles(corners, triangles.normals @ frame[:3, :3].T)
        placed.setdefault((visual.body, visual.link), []).append((number, moved))
    return join(placed, [segment_of(body, link) for body, link in placed])


def _matrices(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrices (n, 4, 4) of poses (n, 7)."""
    x, y, z, w = (poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)).T
    result = np.zeros((len(poses), 4, 4))
    result[:, 0] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), poses[:, 0]], axis=1)
    result[:, 1] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), poses[:, 1]], axis=1)
    result[:, 2] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), poses[:, 2]], axis=1)
    result[:, 3, 3] = 1.0
    return result
