"""Detection of link pairs whose collisions are ignored, by sampling configurations; the SRDF contains these pairs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Literal

import coal
import numpy as np
import pinocchio as pin

from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import Follows, Urdf, format_srdf, read_urdf

SAMPLES, SEED = 10000, 1
NEAR = 0.01
"""Distance above which a pair in all samples is not checked [m]."""
Reason = Literal["Adjacent", "Gripper", "Always", "Never"]
Pair = tuple[str, str]


@dataclass(frozen=True)
class _Tree:
    """The joints of a URDF."""

    parents: Mapping[str, tuple[str, str]]
    """Link -> its parent joint and its parent link."""
    moving: frozenset[str]
    """Joints that are not fixed."""
    follows: Mapping[str, Follows]
    """Joint -> how it follows another."""

    def above(self, link: str) -> list[tuple[str, str]]:
        """Return joint and parent link of a link, then of its parent, up to the base."""
        chain = []
        while link in self.parents:
            chain.append(self.parents[link])
            link = self.parents[link][1]
        return chain

    def between(self, first: str, second: str) -> frozenset[str]:
        """Return the moving joints between two links."""
        a, b = ({joint for joint, _ in self.above(link)} for link in (first, second))
        return frozenset(a ^ b) & self.moving

    def gripper(self) -> frozenset[str]:
        """Return the moving joints below the first link with several moving child joints."""
        above = {joint: [up for up, _ in self.above(parent) if up in self.moving] for joint, parent in self.parents.values()}
        serial = [a for a in self.moving if all(a == b or a in above[b] or b in above[a] for b in self.moving)]
        return self.moving - frozenset(serial)


def sample_disabled_pairs(urdf: Path, samples: int = SAMPLES) -> list[tuple[str, str, Reason]]:
    """Return pairs of links and the reasons why their collisions are ignored, sorted by name.

    Ignored are collisions between links that one joint connects (links without shapes are skipped), between links that only
    gripper joints move relative to each other, and between links that touch in all sampled configurations, or in none.
    """
    tree = _tree_of(read_urdf(urdf))
    model = pin.buildModelFromUrdf(str(urdf))
    shapes = _hulls(model, urdf)
    links = [model.frames[item.parentFrame].name for item in shapes.geometryObjects]
    result: dict[Pair, Reason] = {}
    open_pairs: list[Pair] = []
    gripper = tree.gripper()
    for first, second in combinations(sorted(set(links)), 2):
        if second in _neighbours(tree, first, links) or first in _neighbours(tree, second, links):
            result[first, second] = "Adjacent"
        elif tree.between(first, second) <= gripper:
            result[first, second] = "Gripper"
        else:
            open_pairs.append((first, second))
    configurations = _configurations(model, tree, samples)
    near = _touches(model, shapes, links, open_pairs, configurations, NEAR)
    candidates = [pair for pair in open_pairs if near[pair] == samples]
    touching = _touches(model, shapes, links, candidates, configurations, 0.0)
    result |= {pair: "Never" for pair in open_pairs if near[pair] == 0}
    result |= {pair: "Always" for pair in candidates if touching[pair] == samples}
    return [(*pair, result[pair]) for pair in sorted(result)]


def srdf_text(urdf: Path) -> str:
    """Return the SRDF of an arm: its name and the pairs that are not checked."""
    return format_srdf(read_urdf(urdf).name, sample_disabled_pairs(urdf))


def _tree_of(urdf: Urdf) -> _Tree:
    parents = {joint.child: (joint.name, joint.parent) for joint in urdf.joints}
    moving = frozenset(joint.name for joint in urdf.joints if joint.kind != "fixed")
    return _Tree(parents, moving, {joint.name: joint.follows for joint in urdf.joints if joint.follows is not None})


def _neighbours(tree: _Tree, link: str, solid: Iterable[str]) -> set[str]:
    """Return the nearest link with shapes above a link."""
    return set([parent for _, parent in tree.above(link) if parent in solid][:1])


def _hulls(model: pin.Model, urdf: Path) -> pin.GeometryModel:
    """Return the collision shapes of a URDF, meshes as convex hulls."""
    shapes = pin.buildGeomFromUrdf(model, str(urdf), pin.GeometryType.COLLISION, package_dirs=[str(urdf.parent)])
    for item in shapes.geometryObjects:
        if hasattr(item.geometry, "buildConvexHull"):
            item.geometry.buildConvexHull(True, "Qt")
            item.geometry = item.geometry.convex
    return shapes


def _configurations(model: pin.Model, tree: _Tree, samples: int) -> FloatArray:
    """Return random configurations (samples, nq) within the limits; mimic joints follow their drives."""
    rng = np.random.default_rng(SEED)
    names = list(model.names)[1:]
    angles: dict[str, FloatArray] = {}
    for name in names:
        joint = model.joints[model.getJointId(name)]
        if joint.nq == 1:
            low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
        else:
            low, high = -math.pi, math.pi
        angles[name] = rng.uniform(low, high, samples)
    for name, way in tree.follows.items():
        angles[name] = way.ratio * angles[way.joint] + way.offset
    columns: list[FloatArray] = []
    for name in names:
        turns = model.joints[model.getJointId(name)].nq == 2
        columns += [np.cos(angles[name]), np.sin(angles[name])] if turns else [angles[name]]
    return np.column_stack(columns)


def _touches(
    model: pin.Model,
    shapes: pin.GeometryModel,
    links: list[str],
    pairs: list[Pair],
    configurations: FloatArray,
    margin: float,
) -> dict[Pair, int]:
    """Return the number of configurations in which shapes of each pair of links are nearer than `margin` [m]."""
    shapes.removeAllCollisionPairs()
    owners: list[int] = []
    for number, (first, second) in enumerate(pairs):
        for i, a in enumerate(links):
            for j, b in enumerate(links):
                if a == first and b == second:
                    shapes.addCollisionPair(pin.CollisionPair(i, j))
                    owners.append(number)
    counts = np.zeros(len(pairs), dtype=int)
    if owners:
        data, geometry = model.createData(), shapes.createData()
        for request in geometry.collisionRequests:
            request.security_margin = margin
            request.gjk_initial_guess = coal.GJKInitialGuess.DefaultGuess
        for q in configurations:
            pin.computeCollisions(model, data, shapes, geometry, q, False)
            hit = {owner for owner, found in zip(owners, geometry.collisionResults, strict=True) if found.isCollision()}
            counts[sorted(hit)] += 1
    return dict(zip(pairs, counts.tolist(), strict=True))
