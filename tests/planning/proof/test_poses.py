"""Bounds of the proof: where shapes are, how far they move, and how far they come along a direction."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.planning.path import JointPath, through
from rlbench_pin.planning.proof import ArmShapes
from rlbench_pin.planning.proof.pieces import Pieces
from rlbench_pin.planning.proof.planes import advances
from rlbench_pin.planning.proof.poses import Poses
from rlbench_pin.planning.proof.shapes import Shapes
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.model import RobotModel
from tests.worlds_for_tests import HOME, Boxes


@pytest.fixture
def collision(model: RobotModel, boxes: Boxes) -> CollisionModel:
    """A screen and cubes, a stick in the hand."""
    collision = CollisionModel(model)
    stick = boxes.box("stick", (0.02, 0.02, 0.3), model.tip_pose(HOME)[:3])
    collision.update(boxes.snapshot(boxes.screen(), *boxes.cubes(4), stick, attached=("stick",)))
    return collision


@pytest.fixture
def path(model: RobotModel) -> JointPath:
    """A curve through random configurations."""
    rng = np.random.default_rng(3)
    return through(rng.uniform(0.8 * model.limits.lower, 0.8 * model.limits.upper, (6, 7)))


def cut(path: JointPath, parts: int) -> Pieces:
    """Each cubic piece in some parts."""
    pieces = Pieces.of(path)
    return pieces.cut(np.arange(len(pieces.low)), np.full(len(pieces.low), parts))


def test_all_joints_are_where_pinocchio_has_them(collision: CollisionModel, path: JointPath) -> None:
    """Placements and axes of many configurations agree with those of one at a time."""
    model = collision.model
    q = cut(path, 3).middles
    placed = ArmShapes(model).chain.place(q)
    for i, configuration in enumerate(q):
        jacobian = pin.computeJointJacobians(model.arm, model.data, configuration)
        for j in range(model.size):
            np.testing.assert_allclose(placed.rotations[i, j], model.data.oMi[j + 1].rotation, atol=1e-12)
            np.testing.assert_allclose(placed.origins[i, j], model.data.oMi[j + 1].translation, atol=1e-12)
        np.testing.assert_allclose(placed.linear[i], jacobian[:3].T, atol=1e-12)
        np.testing.assert_allclose(placed.angular[i], jacobian[3:].T, atol=1e-12)


def test_pieces_are_the_path(path: JointPath) -> None:
    """Parts follow each other without a gap, middles lie on the path, and no configuration leaves the control points' box."""
    pieces = cut(path, 5)
    assert pieces.low[0] == 0.0 and pieces.high[-1] == 1.0
    np.testing.assert_array_equal(pieces.low[1:], pieces.high[:-1])
    np.testing.assert_allclose(pieces.middles, path(0.5 * (pieces.low + pieces.high)), atol=1e-12)
    for share in np.linspace(0.0, 1.0, 9):
        q = path(pieces.low + share * (pieces.high - pieces.low))
        assert np.all(np.abs(q - pieces.middles) <= pieces.turns + 1e-12)


@pytest.mark.parametrize("parts", [2, 8, 40])
def test_no_pair_comes_nearer_than_its_bounds(collision: CollisionModel, path: JointPath, parts: int) -> None:
    """Distances on a piece are at least those bounded by boxes, and by the distance in the middle less what closes it."""
    shapes, pieces = Shapes(ArmShapes(collision.model), collision), cut(path, parts)
    poses, geometry = Poses(shapes, pieces), collision.geometry
    data, placed = collision.model.full.createData(), geometry.model.createData()
    pairs = np.arange(len(shapes.far))
    rng, checked = np.random.default_rng(0), 0
    for i in rng.permutation(len(pieces.low))[:8].tolist():
        piece = np.full(len(pairs), i)
        far_apart = np.ones(len(pairs), dtype=bool)
        far_apart[[k for at, k in zip(*poses.close(pairs, np.zeros(len(pairs))), strict=True) if at == i]] = False
        middle, normal = measure(collision, data, placed, pieces.middles[i])
        normal[shapes.second_farther] *= -1.0
        least = middle - np.minimum(poses.moves(piece, pairs), advances(poses, piece, pairs, normal))
        for share in rng.uniform(0.0, 1.0, 12):
            now, _ = measure(collision, data, placed, path(pieces.low[i] + share * (pieces.high[i] - pieces.low[i])))
            assert np.all(now >= least - 1e-5)
            assert np.all(now[far_apart] > 0.0)
            checked += int((least > 0.0).sum())
    assert checked > 100


def measure(collision: CollisionModel, data: pin.Data, placed: pin.GeometryData, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return Coal's distances (pairs,), [m], and normals (pairs, 3)."""
    geometry = collision.geometry.model
    pin.updateGeometryPlacements(collision.model.full, data, geometry, placed, collision.configuration(q))
    results = [pin.computeDistance(geometry, placed, k) for k in range(len(geometry.collisionPairs))]
    found = [(result.min_distance, np.array(result.normal)) for result in results]
    return np.array([d for d, _ in found]), np.array([n for _, n in found])
