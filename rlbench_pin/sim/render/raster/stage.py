"""The triangles of all links, and their positions in the world."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.body import BASE
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.masks import segment_of
from rlbench_pin.sim.render.raster.meshes import Triangles, flat_normals, triangles_of
from rlbench_pin.sim.render.texture import Texture, read_texture
from rlbench_pin.urdf import DULL, Finish

_KEPT_SHAPES = 256
"""Number of visuals, and of links, whose triangles are kept for worlds that are built again."""
_MIN_REST, _MAX_REST = 2, 64
"""After so many instants without motion a link is still, at first and at most."""
Link = tuple[int, int]
"""Numbers of body and link."""


@dataclass(frozen=True)
class Visual:
    """One visual shape as PyBullet lists it."""

    body: int
    link: int
    kind: int
    size: tuple[float, ...]
    file: str
    position: tuple[float, ...]
    quaternion: tuple[float, ...]
    is_textured: bool


@dataclass(frozen=True, eq=False)
class Parts:
    """Triangles and their corner points, in the frames of their links; those of one link follow each other."""

    links: tuple[Link, ...]
    """Body and link number of each link."""
    segments: NDArray[np.int32]
    """Its segmentation value (l,)."""
    point_slices: tuple[slice, ...]
    """Its points."""
    slices: tuple[slice, ...]
    """Its triangles."""
    points: NDArray[np.float32]
    """x, y, z, 1 of every point (4, p) [m]."""
    corners: NDArray[np.int64]
    """Points at the three corners of each triangle (3, m)."""
    planes: NDArray[np.float32]
    """Unit normal of each triangle and minus its product with the corners (4, m); 0 for those without an area."""
    normals: NDArray[np.float32]
    """(3, 3, m): for each corner its unit normal."""
    surface: NDArray[np.float32]
    """(3, c, m): for each corner how much of the ambient light reaches it, 0..1, and where a pattern has it [m], along the two
    axes of its link that its face is most parallel to. c is 3; 1 where no visual has a pattern; 0 where all light reaches all."""
    shape: NDArray[np.int64]
    """Number of the visual of each triangle (m,), in PyBullet's order."""
    link: NDArray[np.int64]
    """Number of the link of each triangle (m,)."""
    balls: NDArray[np.float32]
    """Middle and radius of a ball around each link (l, 4), in its frame [m]."""


def join(shapes: Mapping[Link, Sequence[tuple[int, Triangles]]], segments: Sequence[int], has_pattern: bool = False) -> Parts:
    """Join the visuals of all links.

    Args:
        shapes: Of each link its visuals, by number, in the frame of the link.
        segments: Segmentation value of each link.
        has_pattern: Whether some visual has a pattern.
    """
    every = [pair for group in shapes.values() for pair in group]
    ends = _ends([sum(len(t.corners) for _, t in group) for group in shapes.values()])
    points, corners, point_ends = [], [np.zeros((0, 3), dtype=np.int64)], [0]
    for group in shapes.values():
        own, numbers = _points_of(tuple(t for _, t in group))
        points.append(own)
        corners.append(numbers + point_ends[-1])
        point_ends.append(point_ends[-1] + len(own))
    at_corners, normals = (
        np.concatenate([np.zeros((0, 3, 3)), *(getattr(t, name) for _, t in every)]) for name in ("corners", "normals")
    )
    places = np.concatenate([np.zeros((0, 3)), *points])
    shades = [np.ones((len(t.corners), 3)) if t.shades is None else t.shades for _, t in every]
    surface = np.concatenate([np.zeros((0, 3)), *shades])[..., None]
    if has_pattern:
        on_planes = np.concatenate([np.zeros((0, 3, 2)), *(_on_plane(t) for _, t in every if len(t.corners))])
        surface = np.concatenate([surface, on_planes], axis=2)
    elif all(t.shades is None for _, t in every):
        surface = surface[..., :0]
    return Parts(
        links=tuple(shapes),
        segments=np.array(segments, dtype=np.int32),
        point_slices=_slices(point_ends),
        slices=_slices(ends),
        points=np.ascontiguousarray(np.concatenate([places, np.ones((len(places), 1))], axis=1).T, dtype=np.float32),
        corners=np.ascontiguousarray(np.concatenate(corners).T),
        planes=_planes(at_corners),
        normals=np.ascontiguousarray(normals.transpose(1, 2, 0), dtype=np.float32),
        surface=np.ascontiguousarray(surface.transpose(1, 2, 0), dtype=np.float32),
        shape=np.repeat([number for number, _ in every], [len(t.corners) for _, t in every]).astype(np.int64),
        link=np.repeat(np.arange(len(shapes)), np.diff(ends)),
        balls=np.array([_ball(own) for own in points], dtype=np.float32).reshape(-1, 4),
    )


@lru_cache(maxsize=_KEPT_SHAPES)
def _points_of(shapes: tuple[Triangles, ...]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points (p, 3) of the visuals of one link, each once, and which of them are the corners of each triangle (m, 3)."""
    own, numbers = np.unique(np.concatenate([t.corners.reshape(-1, 3) for t in shapes]), axis=0, return_inverse=True)
    return own, numbers.reshape(-1, 3)


@lru_cache(maxsize=_KEPT_SHAPES)
def _on_plane(shape: Triangles) -> NDArray[np.float64]:
    """Coordinates (m, 3, 2) of the corners of one visual along the two axes that each triangle is most parallel to.

    The axis along which the visual is longer is first.
    """
    corners = shape.corners
    sizes = np.ptp(corners.reshape(-1, 3), axis=0).round(3)
    across = np.abs(flat_normals(corners)[:, 0]).argmax(axis=1)
    axes = np.array([sorted({0, 1, 2} - {axis}, key=lambda other: -sizes[other]) for axis in range(3)])[across]
    return np.take_along_axis(corners, np.repeat(axes[:, None], 3, axis=1), axis=2)


def _ball(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Middle and radius (4,) of a ball around points (n, 3) [m]."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return np.append(middle, np.linalg.norm(points - middle, axis=1).max() + 1e-4)


def _ends(counts: Sequence[int]) -> list[int]:
    result: list[int] = np.cumsum([0, *counts]).tolist()
    return result


def _slices(ends: Sequence[int]) -> tuple[slice, ...]:
    return tuple(slice(a, b) for a, b in zip(ends, ends[1:]))


def _planes(corners: NDArray[np.float64]) -> NDArray[np.float32]:
    """Planes (4, m) of triangles with corners (m, 3, 3)."""
    normals = flat_normals(corners)[:, 0]
    offsets = -np.einsum("ij,ij->i", normals, corners[:, 0])
    return np.ascontiguousarray(np.concatenate([normals, offsets[:, None]], axis=1).T, dtype=np.float32)


class Placed:
    """Triangles in the world.

    Args:
        parts: The triangles in the frames of their links.

    Attributes:
        parts: The same.
        points: x, y, z, 1 of every point (4, p) in the world [m].
        planes: Planes (4, m) of the triangles in the world.
        normals: Normals (3, 3, m) of their corners in the world.
        middles: x, y, z, 1 of the middles of the balls around the links (4, l) in the world [m].
        still: Whether each link (l,) has not moved for some time; longer for those that moved again.
    """

    def __init__(self, parts: Parts) -> None:
        self.parts = parts
        self.points, self.planes, self.normals = parts.points.copy(), parts.planes.copy(), parts.normals.copy()
        self.middles = np.ones((4, len(parts.links)), dtype=np.float32)
        count = len(parts.links)
        self._frames, self.still = np.full((count, 4, 4), np.nan), np.zeros(count, dtype=np.bool_)
        self._rested, self._rests_after = np.zeros(count, dtype=np.int64), np.full(count, _MIN_REST)

    def place(self, placements: Mapping[Link, NDArray[np.float64]]) -> None:
        """Move the links to their present poses; links that have not moved cost no time.

        Args:
            placements: Matrix (4, 4) of the frame of every link.
        """
        parts = self.parts
        frames = np.array([placements[link] for link in parts.links]).reshape(-1, 4, 4)
        moved = (frames != self._frames).any(axis=(1, 2))
        self._frames = frames
        again = moved & self.still
        self._rests_after[again] = np.minimum(2 * self._rests_after[again], _MAX_REST)
        self._rested += 1
        self._rested[moved] = 0
        self.still = self._rested >= self._rests_after
        numbers = moved.nonzero()[0]
        own = frames.take(numbers, axis=0)
        rotations, shifts = own[:, :3, :3], own[:, :3, 3]
        for_planes = np.zeros((len(own), 4, 4), dtype=np.float32)
        for_planes[:, :3, :3], for_planes[:, 3, 3] = rotations, 1.0
        for_planes[:, 3, :3] = -np.einsum("ij,ijk->ik", shifts, rotations)
        self.middles[:3, numbers] = (np.einsum("ijk,ik->ij", rotations, parts.balls[numbers, :3]) + shifts).T
        turns = own.astype(np.float32)
        for number, turn, for_plane in zip(numbers.tolist(), turns, for_planes, strict=True):
            points, triangles = parts.point_slices[number], parts.slices[number]
            np.matmul(turn, parts.points[:, points], out=self.points[:, points])
            np.matmul(for_plane, parts.planes[:, triangles], out=self.planes[:, triangles])
            np.matmul(turn[:3, :3], parts.normals[:, :, triangles], out=self.normals[:, :, triangles])


_KEPT = 12
"""So many cameras are kept."""


class Layer:
    """View of some links by one camera.

    Args:
        size: Width and height of its image [px].
        count: Number of links.

    Attributes:
        nearest: Key of the nearest triangle of each pixel (h, w), 0 for none; see `Spans.draw_into`.
        links: Which links are in it (l,).
        state: Another object after each change.
    """

    def __init__(self, size: tuple[int, int], count: int) -> None:
        self.nearest = np.zeros((size[1], size[0]), dtype=np.int64)
        self.links = np.zeros(count, dtype=np.bool_)
        self.state = object()

    def clear(self) -> None:
        """Take all links out."""
        self.nearest[:], self.links[:], self.state = 0, False, object()

    def add(self, links: NDArray[np.bool_]) -> None:
        """Note that some links (l,) were drawn into it."""
        self.links |= links
        self.state = object()


class Layers:
    """Layers of cameras, from the second image of the same camera on."""

    def __init__(self) -> None:
        self._layers: OrderedDict[tuple[object, ...], Layer | None] = OrderedDict()
        self._shown = b""

    def of(self, views: Sequence[CameraView], shown: NDArray[np.bool_], still: NDArray[np.bool_]) -> list[Layer | None]:
        """Return the layer of each camera, without links that have moved; None for those that look for the first time.

        Args:
            views: The cameras.
            shown: Whether each triangle is seen (m,).
            still: Whether each link has not moved lately (l,).
        """
        if (now := shown.tobytes()) != self._shown:
            self._shown = now
            self._layers.clear()
        return [self._layer(view, still) for view in views]

    def _layer(self, view: CameraView, still: NDArray[np.bool_]) -> Layer | None:
        layer = self._layers.get(view.key)
        if layer is not None and (layer.links & ~still).any():
            layer.clear()
        elif layer is None and view.key in self._layers:
            layer = Layer(view.size, len(still))
        self._layers[view.key] = layer
        self._layers.move_to_end(view.key)
        while len(self._layers) > _KEPT:
            self._layers.popitem(last=False)
        return layer


_GRAIN = 2.0**-18
"""Step of positions [m] and quaternions: 4 um."""
Visuals = dict[tuple[int, int], tuple[tuple[float, ...], ...]]
"""Something of each visual of some links, by body and link number, in file order."""
Finishes = dict[tuple[int, int], tuple[Finish, ...]]
"""Finishes of each visual of some links, by body and link number, in file order."""
_SAME_COLOR = 0.02
"""Colours that differ by less are the same."""


@dataclass(frozen=True)
class Appearance:
    """Appearance of visuals that PyBullet does not report."""

    mixed_colors: Callable[[], Visuals] = dict
    """Returns rgba of links whose visuals differ and show it. Once such a link was painted and is no more, PyBullet tells the
    colour of its last visual for all."""
    finishes: Callable[[], Finishes] = dict
    """Returns the finishes of visuals, of links that have some."""
    hidden: Callable[[], frozenset[Link]] = frozenset
    """Returns the links that images do not show, by body and link number."""


@dataclass(frozen=True)
class Lamp:
    """A light of the scene that is on."""

    position: tuple[float, float, float]
    """Its middle in the world [m]."""
    color: tuple[float, float, float]
    """rgb in 0..1."""
    reach: float
    """How far its light reaches [m]."""


@dataclass(frozen=True, eq=False)
class Materials:
    """Appearance of the visuals, in PyBullet's order."""

    colors: NDArray[np.float32]
    """Colours (3, v) in 0..255."""
    opacity: NDArray[np.float32]
    """(v,) in 0..1: 0 is not seen, glass lies between."""
    gloss: NDArray[np.float32]
    """Share of red, green, blue that each throws back like a mirror (3, v)."""
    is_glossy: NDArray[np.bool_]
    """Whether it throws back any (v,)."""
    shines: NDArray[np.bool_]
    """Whether it shines by itself (v,)."""
    reach: NDArray[np.float32]
    """How far the light reaches of those that shine (v,) [m]."""
    pattern: NDArray[np.int64]
    """Which of the patterns each has, -1 for none (v,)."""
    patterns: tuple[tuple[Texture, float], ...]
    """Patterns, and the side of each on the surface [m]."""


class Stage:
    """Reader of shapes, colours and poses from a physics server.

    Args:
        client: The server.
        room: Numbers of the bodies that are left out.
        appearance: Appearance that the server does not report.

    Attributes:
        layers: Cached drawings of stationary shapes.
        materials: Their appearance.
    """

    def __init__(self, client: PhysicsClient, room: frozenset[int], appearance: Appearance) -> None:
        self._client, self._room, self._appearance = client, room, appearance
        self._mixed: Visuals = {}
        self._hidden: frozenset[Link] = frozenset()
        self._entries: list[tuple] = []
        self._visuals: tuple[Visual, ...] = ()
        self._placed: Placed | None = None
        self.layers = Layers()
        self._bodies: dict[int, int] = {}
        self._from_com: dict[int, NDArray] = {}
        self.materials = _materials([], {}, {}, frozenset())

    def update(self) -> Placed | None:
        """Read the present shapes, colours and poses; return None if a shape cannot be drawn by numpy."""
        identifier = self._client.id
        uids = [
            bullet.getBodyUniqueId(i, physicsClientId=identifier) for i in range(bullet.getNumBodies(physicsClientId=identifier))
        ]
        entries = [entry for uid in uids if uid not in self._room for entry in _entries_of(uid, identifier)]
        mixed, hidden = self._appearance.mixed_colors(), self._appearance.hidden()
        if entries != self._entries or mixed != self._mixed or hidden != self._hidden:
            self._entries, self._mixed, self._hidden = entries, mixed, hidden
            self.materials = _materials(entries, mixed, self._appearance.finishes(), hidden)
            visuals = tuple(_visual(entry) for entry in entries)
            if visuals != self._visuals:
                parts = _parts(visuals, bool(self.materials.patterns))
                self._visuals, self._placed, self.layers = visuals, None if parts is None else Placed(parts), Layers()
                bodies = {visual.body: bullet.getNumJoints(visual.body, physicsClientId=identifier) for visual in visuals}
                self._from_com = {body: self._com(body) for body in bodies}
                self._bodies = bodies
        if self._placed is not None:
            self._placed.place(self._placements())
        return self._placed

    def lamps(self) -> list[Lamp]:
        """Return the lamps that are on."""
        materials, placed = self.materials, self._placed
        if placed is None or not materials.reach.any():
            return []
        found = []
        for number in materials.reach.nonzero()[0].tolist():
            link = placed.parts.links.index((self._visuals[number].body, self._visuals[number].link))
            x, y, z, _ = placed.middles[:, link].tolist()
            red, green, blue = (materials.colors[:, number] / np.float32(255.0)).tolist()
            found.append(Lamp((x, y, z), (red, green, blue), float(materials.reach[number])))
        return found

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


def _materials(entries: list[tuple], mixed: Visuals, known: Finishes, hidden: frozenset[Link]) -> Materials:
    colors = _colors_of(entries, mixed)
    colors[[entry[:2] in hidden for entry in entries], 3] = 0.0
    left = {link: list(finishes) for link, finishes in known.items()}
    finishes = [left[entry[:2]].pop(0) if left.get(entry[:2]) else DULL for entry in entries]
    gloss = np.array([finish.gloss for finish in finishes], dtype=np.float32).reshape(-1, 3)
    shines = np.array(
        [
            finish.emission is not None and float(np.abs(own - finish.emission).max()) < _SAME_COLOR
            for own, finish in zip(colors[:, :3], finishes, strict=True)
        ],
        dtype=np.bool_,
    )
    reach = np.array([finish.reach for finish in finishes], dtype=np.float32) * shines
    patterns = [(finish.pattern, finish.pattern_size) for finish in finishes]
    kinds = {kind: number for number, kind in enumerate(dict.fromkeys(kind for kind in patterns if kind[0] is not None))}
    return Materials(
        colors=np.ascontiguousarray((colors[:, :3] * np.float32(255.0)).T),
        opacity=np.ascontiguousarray(colors[:, 3]),
        gloss=np.ascontiguousarray(gloss.T),
        is_glossy=np.asarray(gloss.any(axis=1)),
        shines=shines,
        reach=reach,
        pattern=np.array([kinds.get(kind, -1) for kind in patterns], dtype=np.int64),
        patterns=tuple((read_texture(file), size) for file, size in kinds if file is not None),
    )


def _visual(entry: tuple) -> Visual:
    return Visual(entry[0], entry[1], entry[2], entry[3], entry[4].decode(), entry[5], entry[6], entry[8] >= 0)


def _parts(visuals: tuple[Visual, ...], has_pattern: bool) -> Parts | None:
    """Read all shapes; None when one cannot be drawn."""
    placed: dict[tuple[int, int], list[tuple[int, Triangles]]] = {}
    for number, visual in enumerate(visuals):
        triangles = _triangles(visual.kind, visual.size, visual.file, visual.position, visual.quaternion)
        if triangles is None or visual.is_textured:
            return None
        placed.setdefault((visual.body, visual.link), []).append((number, triangles))
    return join(placed, [segment_of(body, link) for body, link in placed], has_pattern)


@lru_cache(maxsize=_KEPT_SHAPES)
def _triangles(
    kind: int, size: tuple[float, ...], file: str, position: tuple[float, ...], quaternion: tuple[float, ...]
) -> Triangles | None:
    """Return a visual in the frame of its link; None when it cannot be drawn."""
    triangles = triangles_of(kind, size, file)
    if triangles is None:
        return None
    frame = _matrices(np.array([[*position, *quaternion]]))[0]
    corners = triangles.corners @ frame[:3, :3].T + frame[:3, 3]
    return Triangles(corners, triangles.normals @ frame[:3, :3].T, triangles.shades)


def _matrices(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrices (n, 4, 4) of poses (n, 7)."""
    x, y, z, w = (poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)).T
    result = np.zeros((len(poses), 4, 4))
    result[:, 0] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), poses[:, 0]], axis=1)
    result[:, 1] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), poses[:, 1]], axis=1)
    result[:, 2] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), poses[:, 2]], axis=1)
    result[:, 3, 3] = 1.0
    return result
