"""The triangles of all links, and where they are in the world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.raster.meshes import Triangles
from rlbench_pin.sim.render.raster.normals import flat_normals

_LEAST_REST, _LONGEST_REST = 2, 64
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
    shape: NDArray[np.int64]
    """Number of the visual of each triangle (m,), in PyBullet's order."""
    link: NDArray[np.int64]
    """Number of the link of each triangle (m,)."""
    balls: NDArray[np.float32]
    """Middle and radius of a ball around each link (l, 4), in its frame [m]."""


def join(shapes: Mapping[Link, Sequence[tuple[int, Triangles]]], segments: Sequence[int]) -> Parts:
    """Put the visuals of all links together.

    Args:
        shapes: Of each link its visuals, by number, in the frame of the link.
        segments: Segmentation value of each link.
    """
    every = [pair for group in shapes.values() for pair in group]
    ends = _ends([sum(len(t.corners) for _, t in group) for group in shapes.values()])
    points, corners, point_ends = [], [np.zeros((0, 3), dtype=np.int64)], [0]
    for group in shapes.values():
        own, numbers = np.unique(np.concatenate([t.corners.reshape(-1, 3) for _, t in group]), axis=0, return_inverse=True)
        points.append(own)
        corners.append(numbers.reshape(-1, 3) + point_ends[-1])
        point_ends.append(point_ends[-1] + len(own))
    at_corners, normals = (
        np.concatenate([np.zeros((0, 3, 3)), *(getattr(t, name) for _, t in every)]) for name in ("corners", "normals")
    )
    places = np.concatenate([np.zeros((0, 3)), *points])
    return Parts(
        links=tuple(shapes),
        segments=np.array(segments, dtype=np.int32),
        point_slices=_slices(point_ends),
        slices=_slices(ends),
        points=np.ascontiguousarray(np.concatenate([places, np.ones((len(places), 1))], axis=1).T, dtype=np.float32),
        corners=np.ascontiguousarray(np.concatenate(corners).T),
        planes=_planes(at_corners),
        normals=np.ascontiguousarray(normals.transpose(1, 2, 0), dtype=np.float32),
        shape=np.repeat([number for number, _ in every], [len(t.corners) for _, t in every]).astype(np.int64),
        link=np.repeat(np.arange(len(shapes)), np.diff(ends)),
        balls=np.array([_ball(own) for own in points], dtype=np.float32).reshape(-1, 4),
    )


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
        self._frames: list[bytes] = [b""] * len(parts.links)
        self.still = np.zeros(len(parts.links), dtype=np.bool_)
        self._rested, self._rests_after = [0] * len(parts.links), [_LEAST_REST] * len(parts.links)

    def place(self, placements: Mapping[Link, NDArray[np.float64]]) -> None:
        """Put the links where they are now; those that have not moved cost nothing.

        Args:
            placements: Matrix (4, 4) of the frame of every link.
        """
        parts = self.parts
        for number, link in enumerate(parts.links):
            frame = placements[link]
            if (now := frame.tobytes()) == self._frames[number]:
                self._rested[number] += 1
                self.still[number] = self._rested[number] >= self._rests_after[number]
                continue
            if self.still[number]:
                self._rests_after[number] = min(2 * self._rests_after[number], _LONGEST_REST)
            self._frames[number], self._rested[number], self.still[number] = now, 0, False
            points, triangles = parts.point_slices[number], parts.slices[number]
            for_planes = np.zeros((4, 4), dtype=np.float32)
            for_planes[:3, :3], for_planes[3, :3], for_planes[3, 3] = frame[:3, :3], -(frame[:3, 3] @ frame[:3, :3]), 1.0
            self.middles[:3, number] = frame[:3, :3] @ parts.balls[number, :3] + frame[:3, 3]
            turn = frame.astype(np.float32)
            np.matmul(turn, parts.points[:, points], out=self.points[:, points])
            np.matmul(for_planes, parts.planes[:, triangles], out=self.planes[:, triangles])
            np.matmul(turn[:3, :3], parts.normals[:, :, triangles], out=self.normals[:, :, triangles])
