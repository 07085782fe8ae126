"""Where a part of one scene is in another: a coarse search over places and turns on the table, then iterative closest points.

Points are rows of six numbers: x, y, z in the world [m], and red, green, blue times `COLOUR`, so that a distance of rows is one
of place and colour together. Things stand on the table, so that motions are planar: a turn about the vertical, and x and y.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from rlbench_pin.spatial import compose, pose_at

COLOUR = 0.06
"""Distance that stands for the whole range of a colour [m]."""
KEPT = 0.8
"""Share of the nearest neighbours that count; the others are hidden in one of the scenes."""
FAR = 0.05
"""Distances beyond are no worse [m]."""
TURNS = np.linspace(-np.pi, np.pi, 24, endpoint=False)
"""Turns that are tried [rad]."""
SHIFTS = [(x, y) for x in np.linspace(-0.2, 0.2, 5) for y in np.linspace(-0.2, 0.2, 5)]
"""Shifts of a whole scene that are tried, beside those that bring the middles together [m]."""
TURNING = 0.001
"""Cost of a turn, so that of two that fit alike the smaller is taken [m/rad]."""
CLEARLY = 0.001
"""What is clearly better [m]."""
PLACES = 40
"""Places that are tried."""
SAMPLES, REFINED = (80, 200, 500), (10, 3)
"""Points that motions are compared by, then refined by, then refined by again, and how many of them are each time."""
OUTLYING, NEAR, NEIGHBOURS = 2.5, 0.2, 12
"""Distances so many times the median do not count; how much neighbours count beside surfaces; neighbours that make a surface."""
STEPS = 20
"""Iterations of a refinement."""


@dataclass(frozen=True)
class PlanarMotion:
    """A turn about the vertical axis of the world, then a shift: from the demonstration's scene to the other."""

    yaw: float = 0.0
    """[rad]"""
    x: float = 0.0
    """[m]"""
    y: float = 0.0
    """[m]"""

    def of_points(self, points: np.ndarray) -> np.ndarray:
        """Return points (n, 6) moved."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        moved = points.copy()
        moved[:, 0] = c * points[:, 0] - s * points[:, 1] + self.x
        moved[:, 1] = s * points[:, 0] + c * points[:, 1] + self.y
        return moved

    def of_pose(self, pose: np.ndarray) -> np.ndarray:
        """Return a pose (7,) moved."""
        return compose(pose_at((self.x, self.y, 0.0), yaw=self.yaw), pose)

    def then(self, step: PlanarMotion) -> PlanarMotion:
        """Return this motion and another one after it, as one."""
        x, y = step.of_points(np.array([[self.x, self.y, 0.0, 0.0, 0.0, 0.0]]))[0, :2]
        return PlanarMotion(self.yaw + step.yaw, float(x), float(y))

    @classmethod
    def about(cls, yaw: float, center: np.ndarray, target: np.ndarray) -> PlanarMotion:
        """Return the turn that brings a point (2,) to another (2,)."""
        c, s = np.cos(yaw), np.sin(yaw)
        return cls(yaw, float(target[0] - c * center[0] + s * center[1]), float(target[1] - s * center[0] - c * center[1]))


@dataclass(frozen=True)
class Match:
    """A motion, and how well it fits."""

    motion: PlanarMotion
    cost: float
    """Mean distance of neighbours, of place and colour together [m]."""


class Scene:
    """Points that parts of another scene are looked for in.

    Args:
        points: Shape (n, 6).
    """

    def __init__(self, points: np.ndarray) -> None:
        self.points = points
        self._tree = KDTree(points)
        self._normals = surface_normals(points, self._tree)

    def cost(self, moved: np.ndarray) -> float:
        """Return the mean distance of points (m, 6) to their neighbours here, without the worst."""
        return kept_mean(self._tree.query(moved, distance_upper_bound=FAR)[0])

    def whole(self, part: np.ndarray) -> Match:
        """Return the motion of a whole scene (m, 6) that fits best, judged both ways."""
        center, here = part[:, :2].mean(axis=0), self.points[:, :2].mean(axis=0)
        tried = [PlanarMotion.about(yaw, center, here + shift) for yaw in TURNS for shift in SHIFTS]
        return self._best(part, [PlanarMotion(), *tried], both_ways=True)

    def staying(self, part: np.ndarray, motion: PlanarMotion) -> Match:
        """Return a motion as it is, and how well it fits a part (m, 6)."""
        return Match(motion, self._misfit(motion, thinned(part, SAMPLES[-1])) + CLEARLY)

    def part(self, part: np.ndarray, likely: PlanarMotion) -> Match:
        """Return the motion of a part (m, 6) that fits best.

        Args:
            part: Its points.
            likely: A motion that is kept, but for a little, unless another one fits clearly better.
        """
        center = part[:, :2].mean(axis=0)
        places = thinned(self.points, PLACES)[:, :2]
        tried = [PlanarMotion.about(yaw, center, place) for place in places for yaw in TURNS]
        kept, other = self._best(part, [likely], both_ways=False), self._best(part, tried, both_ways=False)
        return other if other.cost + CLEARLY < kept.cost else kept

    def _best(self, part: np.ndarray, tried: Sequence[PlanarMotion], both_ways: bool) -> Match:
        """Return the best motion: those tried are compared, refined by few points, then by more, fewer of them each time."""
        few, some, more = (thinned(part, most) for most in SAMPLES)
        distances = self._tree.query(np.concatenate([m.of_points(few) for m in tried]), distance_upper_bound=FAR)[0]
        costs = [kept_mean(of_one) for of_one in distances.reshape(len(tried), len(few))]
        motions = [self._refined(some, tried[i]) for i in np.argsort(costs, kind="stable")[: REFINED[0]]]
        motions = [self._refined(more, m) for m in sorted(motions, key=lambda m: self._misfit(m, some))[: REFINED[1]]]
        matches = [Match(m, self._misfit(m, more) + (self._back(m, part) if both_ways else 0.0)) for m in motions]
        return min(matches, key=lambda match: match.cost)

    def _misfit(self, motion: PlanarMotion, points: np.ndarray) -> float:
        """Return how badly a motion fits, by some points (n, 6)."""
        return self.cost(motion.of_points(points)) + TURNING * abs(float(np.angle(np.exp(1j * motion.yaw))))

    def _back(self, motion: PlanarMotion, whole: np.ndarray) -> float:
        """Return how far what is here is from a whole scene (n, 6) that was moved."""
        here = thinned(self.points, SAMPLES[-1])
        return kept_mean(KDTree(motion.of_points(whole)).query(here, distance_upper_bound=FAR)[0])

    def _refined(self, part: np.ndarray, motion: PlanarMotion) -> PlanarMotion:
        """Bring a part nearer, again and again: to the surfaces of its neighbours, so that it slides along them, and a little
        to the neighbours themselves.
        """
        for _ in range(STEPS):
            moved = motion.of_points(part)
            distances, nearest = self._tree.query(moved)
            close = distances <= max(0.01, OUTLYING * float(np.median(distances)))
            ours, gaps, normals = moved[close, :3], (self.points[nearest] - moved)[close, :3], self._normals[nearest[close]]
            center = ours[:, :2].mean(axis=0)
            x, y = (ours[:, :2] - center).T
            zero, one = np.zeros_like(x), np.ones_like(x)
            flat = np.stack([np.column_stack([-y, one, zero]), np.column_stack([x, zero, one])])  # how a step moves x and y
            rows = np.concatenate([np.einsum("nk,knj->nj", normals[:, :2], flat), *(NEAR * flat)])
            wanted = np.concatenate([(normals * gaps).sum(axis=1), *(NEAR * gaps[:, :2].T)])
            turn, *shift = np.linalg.lstsq(rows, wanted, rcond=None)[0]
            motion = motion.then(PlanarMotion.about(float(turn), center, center + shift))
            if abs(turn) < 1e-4 and np.abs(shift).max() < 1e-5:
                break
        return motion


def surface_normals(points: np.ndarray, tree: KDTree) -> np.ndarray:
    """Return the direction in which the neighbours of each point (n, 6) spread least, shape (n, 3)."""
    around = points[tree.query(points, k=min(NEIGHBOURS, len(points)))[1].reshape(len(points), -1), :3]
    spread = around - around.mean(axis=1, keepdims=True)
    return np.asarray(np.linalg.eigh(np.einsum("nki,nkj->nij", spread, spread))[1][:, :, 0])


def kept_mean(distances: np.ndarray) -> float:
    """Return the mean of the least distances, each cut off at `FAR`."""
    cut = np.sort(np.minimum(distances, FAR))
    return float(cut[: max(1, int(KEPT * len(cut)))].mean())


def thinned(points: np.ndarray, most: int) -> np.ndarray:
    """Return at most so many of the points (n, 6), evenly taken in their order."""
    return points[np.linspace(0, len(points) - 1, min(most, len(points))).astype(int)]
