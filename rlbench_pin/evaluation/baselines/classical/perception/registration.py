"""Where a known model stands: iterative closest points from many headings, the best fit wins."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import small_gicp
from scipy.spatial import cKDTree

from rlbench_pin.evaluation.baselines.classical.perception.cloud import Cloud, thinned
from rlbench_pin.evaluation.baselines.sight.models import NO_JOINTS, KnownModel
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

HEADINGS = 16
"""Headings that registration starts from."""
FARTHEST = 0.03
"""Distances count at most this much in a fit [m]."""
POINTS = 1200
"""Points of the scene that are registered."""
SURFACE = 12000
"""Points of the model that they are brought to; with few, neighbours lie on different faces and normals are wrong."""
STAGES = (0.12, 0.04, 0.015)
"""Largest distance of points that are brought together, one run after the other [m]."""
UNSEEN = 0.3
"""Weight of the model's points, of which some are hidden, against the scene's, all of which belong to it."""


@dataclass(frozen=True, eq=False)
class Located:
    """A model in the scene."""

    model: KnownModel
    """The model."""
    placement: pin.SE3
    """Its frame in the world."""
    joints: Mapping[str, float]
    """Values of its joints."""
    error: float
    """Mean distance of scene and model, each at most `FARTHEST` [m]."""

    def point(self, local: FloatArray) -> FloatArray:
        """Return a point (3,) of the frame of the model in the world."""
        point: FloatArray = self.placement.act(np.asarray(local, dtype=float))
        return point

    def link_points(self, link: str) -> FloatArray:
        """Return the surface of a link in the world (n, 3) [m]."""
        points: FloatArray = self.model.link_points(link, self.joints) @ self.placement.rotation.T + self.placement.translation
        return points


def locate(
    model: KnownModel, cloud: Cloud, states: Iterable[Mapping[str, float]] = (NO_JOINTS,), yaws: int = HEADINGS
) -> Located:
    """Return where an upright model stands on the table.

    Args:
        model: What is looked for.
        cloud: Its points and nothing else.
        states: Joint values that it may have.
        yaws: Headings to start from.
    """
    scene = thinned(cloud, 0.006).points
    scene = scene[:: max(1, len(scene) // POINTS)]
    found = [_best(model, joints, scene, yaws) for joints in states]
    return min(found, key=lambda located: located.error)


def _best(model: KnownModel, joints: Mapping[str, float], scene: FloatArray, yaws: int) -> Located:
    """Return the best fit of one state of the model."""
    surface = outside(model.points_at(joints))
    surface = surface[:: max(1, len(surface) // SURFACE)]
    target, tree = small_gicp.PointCloud(surface), cKDTree(surface)
    points = small_gicp.PointCloud(scene)
    small_gicp.estimate_normals(target, num_neighbors=12)
    gicp_tree, scene_tree = small_gicp.KdTree(target), cKDTree(scene)
    fits: list[tuple[float, int, pin.SE3]] = []
    for yaw in np.linspace(-np.pi, np.pi, yaws, endpoint=False):
        placement = _centred(surface, scene, float(yaw))
        for farthest in STAGES:
            result = small_gicp.align(
                target, points, gicp_tree, placement.inverse().homogeneous,
                registration_type="PLANE_ICP", max_correspondence_distance=farthest, max_iterations=15,
            )  # fmt: skip
            placement = _upright(pin.SE3(result.T_target_source).inverse())
        fits.append((_misfit(tree, scene_tree, surface, scene, placement), len(fits), placement))
    error, _, placement = min(fits)
    return Located(model, placement, dict(joints), error)


def outside(points: FloatArray, cell: float = 0.02, depth: float = 0.01) -> FloatArray:
    """Return those points (m, 3) of a surface (n, 3) that are seen from above or from a side, and not what is within.

    Args:
        points: Points on the surface [m].
        cell: Of the points in a square of this side across the direction of sight, the nearest one hides the others [m].
        depth: Unless they lie less than this behind it [m].
    """
    seen = np.zeros(len(points), dtype=bool)
    for slope in (0.3, 0.8, 1.5):
        for yaw in np.linspace(-np.pi, np.pi, 8, endpoint=False):
            along = points @ pin.rpy.rpyToMatrix(0.0, slope, yaw)  # x towards the thing, and down
            cells = np.floor(along[:, 1:] / cell).astype(np.int64)
            _, which = np.unique(cells[:, 0] * 100_000 + cells[:, 1], return_inverse=True)
            nearest = np.full(which.max() + 1, np.inf)
            np.minimum.at(nearest, which, along[:, 0])
            seen |= along[:, 0] < nearest[which] + depth
    return points[seen]


def _centred(surface: FloatArray, scene: FloatArray, yaw: float) -> pin.SE3:
    """Return a placement of a heading that puts the middle of the model's box over that of the scene's."""
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
    turned = surface @ turn.T
    shift = 0.5 * (scene.min(axis=0) + scene.max(axis=0)) - 0.5 * (turned.min(axis=0) + turned.max(axis=0))
    return pin.SE3(turn, np.array([shift[0], shift[1], TABLE_HEIGHT]))


def _upright(placement: pin.SE3) -> pin.SE3:
    """Return the placement with its heading alone, standing on the table."""
    yaw = float(np.arctan2(placement.rotation[1, 0], placement.rotation[0, 0]))
    return pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, yaw), np.array([*placement.translation[:2], TABLE_HEIGHT]))


def _misfit(tree: cKDTree, scene_tree: cKDTree, surface: FloatArray, scene: FloatArray, placement: pin.SE3) -> float:
    """Return the mean distance of scene to model, and with less weight of model to scene [m]."""
    local = (scene - placement.translation) @ placement.rotation
    there = surface @ placement.rotation.T + placement.translation
    seen = np.minimum(tree.query(local)[0], FARTHEST).mean()
    hidden = np.minimum(scene_tree.query(there[:: max(1, len(there) // POINTS)])[0], FARTHEST).mean()
    return float((1.0 - UNSEEN) * seen + UNSEEN * hidden)
