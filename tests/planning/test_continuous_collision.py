"""Continuous collision checks, and the bounds that they rest on."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.planning.continuous_collision import ArmShapes, Pieces, Poses, Shapes, advances, certify
from rlbench_pin.planning.path import JointPath, along, through
from rlbench_pin.planning.planner import MotionPlanner, PlannerConfig
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray
from tests.worlds_for_tests import HOME, Boxes


@pytest.fixture
def collision(model: RobotModel, boxes: Boxes) -> CollisionModel:
    """A screen and cubes, a stick in the gripper."""
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


def collision_model(model: RobotModel, world: WorldSnapshot) -> CollisionModel:
    """A collision model with no clearance."""
    collision = CollisionModel(model)
    collision.update(world)
    return collision


def reach(collision: CollisionModel) -> FloatArray:
    """How far anything that the arm carries can get from the axis of each joint (n,), [m]."""
    return Shapes(ArmShapes(collision.model), collision).reaches.max(axis=0)


def test_no_point_moves_farther_than_its_bound(model: RobotModel, boxes: Boxes) -> None:
    """The reach of each joint bounds how far the tip can move when the joint turns."""
    reaches = reach(collision_model(model, boxes.snapshot()))
    rng = np.random.default_rng(0)
    for q in rng.uniform(model.limits.lower, model.limits.upper, (200, 7)):
        turn = rng.uniform(-0.3, 0.3, 7)
        moved = np.linalg.norm(model.tip_pose(q + turn)[:3] - model.tip_pose(q)[:3])
        assert moved <= reaches @ np.abs(turn)


def test_a_held_stick_lengthens_the_reach(model: RobotModel, boxes: Boxes) -> None:
    """What the gripper carries swings too."""
    stick = boxes.box("stick", (0.02, 0.02, 0.6), model.tip_pose(HOME)[:3])
    free, held = collision_model(model, boxes.snapshot(stick)), collision_model(model, boxes.snapshot(stick, attached=("stick",)))
    assert np.all(reach(held) > reach(free) + 0.1)


def test_keeping_away_is_a_distance(model: RobotModel, boxes: Boxes) -> None:
    """A configuration keeps away by what `distances` measures, whatever was asked before."""
    collision = collision_model(model, boxes.snapshot(boxes.screen(), *boxes.cubes(4)))
    for q in np.random.default_rng(1).uniform(model.limits.lower, model.limits.upper, (150, 7)):
        nearest = collision.distances(q)[0].distance
        for level in (0.002, 0.03, 0.1):
            if abs(nearest - level) > 1e-4:
                assert collision.keeps_away(q, level) == (nearest > level)


@pytest.mark.parametrize("offset", [0.0, 0.01, 0.017])
def test_a_needle_between_the_samples_is_found(model: RobotModel, boxes: Boxes, offset: float) -> None:
    """A thin post that samples may step over is never certified."""
    tip = model.tip_pose(HOME + [0.3 + offset, 0, 0, 0, 0, 0, 0])[:3]
    world = boxes.snapshot(boxes.box("needle", (0.0005, 0.0005, 0.5), tip))
    collision = collision_model(model, world)
    collision.begin(HOME)
    path = along(np.array([HOME, HOME + [0.8, 0, 0, 0, 0, 0, 0]]), 1.0)
    assert certify(path, collision).doubt is not None


def test_a_clear_way_is_certified_with_few_checks(model: RobotModel, boxes: Boxes) -> None:
    """Far from everything, few configurations prove a long way."""
    collision = collision_model(model, boxes.snapshot())
    collision.begin(HOME)
    proof = certify(along(np.array([HOME, HOME + [1.0, 0, 0, 0, 0, 0, 0]]), 1.0), collision)
    assert proof.doubt is None
    assert proof.checks < 200


def test_certified_plans_touch_nothing_anywhere(model: RobotModel, boxes: Boxes) -> None:
    """Accepted motions are looked at every 2e-3 rad; the report says that they were proven."""
    world = boxes.snapshot(boxes.screen(), *boxes.cubes(5))
    planner, collision = MotionPlanner(model), collision_model(model, world)
    planner.update(world)
    for seed in range(3):
        plan = planner.plan_to_configuration(
            HOME - [0.8, 0, 0, 0, 0, 0, 0], HOME + [0.8, 0, 0, 0, 0, 0, 0], rng=np.random.default_rng(seed)
        )
        assert plan.report.certified
        q = plan.trajectory.q
        steps = max(1, int(np.abs(np.diff(q, axis=0)).max() / 2e-3))
        for a, b in zip(q[:-1], q[1:], strict=True):
            assert not any(collision.in_collision(a + k / steps * (b - a)) for k in range(steps))


def test_the_proof_can_be_left_out(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """`certify=False` saves checks, and says so."""
    planner = MotionPlanner(model, PlannerConfig(certify=False))
    planner.update(boxes.snapshot())
    assert not planner.plan_to_configuration(HOME, HOME + 0.2, rng=rng).report.certified
