"""A hundred planning problems with fixed seeds: shelves, open boxes, cages and crowded tables, from joint start to joint goal.

Obstacles come from the seed alone; start and goal are configurations at random grasp poses that touch nothing.
They are not chosen by whether a planner solves them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.kinematics import solve_ik
from rlbench_pin.planning.problems import PlanningProblem, solid_body
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import BodySnapshot, Shape, WorldSnapshot
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

FINGERS = np.full(2, 0.02)
PER_KIND = 25
Scene = tuple[list[BodySnapshot], Callable[[np.random.Generator], FloatArray], Callable[[np.random.Generator], FloatArray]]
"""Obstacles, and how to draw tip poses (7,) for start and goal."""


def box(name: str, size: tuple[float, ...], center: tuple[float, ...], yaw: float = 0.0) -> BodySnapshot:
    """A box at a place, turned about the vertical."""
    pose = (*center, 0.0, 0.0, float(np.sin(yaw / 2)), float(np.cos(yaw / 2)))
    return solid_body(name, [Shape("box", tuple(float(s) for s in size))], pose)


def can(name: str, radius: float, height: float, center: tuple[float, ...]) -> BodySnapshot:
    """An upright cylinder."""
    return solid_body(name, [Shape("cylinder", (radius, height))], (*center, 0.0, 0.0, 0.0, 1.0))


def table() -> BodySnapshot:
    """The table on which the arm stands."""
    return box("table", (1.6, 1.5, 0.04), (0.15, 0.0, TABLE_HEIGHT - 0.02))


def pose(position: FloatArray, pitch: float, yaw: float, roll: float = 0.0) -> FloatArray:
    """Tip pose: z forward along `yaw` for pitch 0, down for pitch pi/2; turned by `roll` about itself."""
    cos, sin = np.cos, np.sin
    z = np.array([cos(pitch) * cos(yaw), cos(pitch) * sin(yaw), -sin(pitch)])
    side = np.array([-sin(yaw), cos(yaw), 0.0])
    y = cos(roll) * side + sin(roll) * np.cross(z, side)
    matrix = np.column_stack([np.cross(y, z), y, z])
    return np.concatenate([position, _quaternion(matrix)])


def _quaternion(matrix: FloatArray) -> FloatArray:
    """Quaternion x, y, z, w of a rotation matrix."""
    return Rotation.from_matrix(matrix).as_quat()


def shelf(rng: np.random.Generator) -> Scene:
    """A shelf in front of the arm with two to three boards, divided, with objects in it; from one compartment into another."""
    depth, width, boards = rng.uniform(0.25, 0.32), rng.uniform(0.7, 1.0), int(rng.integers(2, 4))
    front, gap = rng.uniform(0.22, 0.32), rng.uniform(0.24, 0.34)
    x, low = front + depth / 2, TABLE_HEIGHT + rng.uniform(0.02, 0.12)
    bodies = [table()]
    bodies += [box(f"board{i}", (depth, width, 0.02), (x, 0.0, low + i * gap)) for i in range(boards + 1)]
    height = boards * gap
    bodies += [box(f"side{s}", (depth, 0.02, height), (x, s * width / 2, low + height / 2)) for s in (-1, 0, 1)]
    bodies += [box("back", (0.02, width, height), (front + depth, 0.0, low + height / 2))]
    cells = [(s, i) for i in range(boards) for s in (-1, 1)]
    for k, (s, i) in enumerate(cells):
        y = s * width / 4 + rng.uniform(-0.08, 0.08)
        radius, tall = rng.uniform(0.02, 0.035), rng.uniform(0.08, 0.15)
        bodies.append(can(f"can{k}", radius, tall, (x + depth * rng.uniform(0.05, 0.3), y, low + i * gap + 0.01 + tall / 2)))
    picked = rng.permutation(len(cells))[:2]

    def draw(cell: tuple[int, int]) -> Callable[[np.random.Generator], FloatArray]:
        def inside(rng: np.random.Generator) -> FloatArray:
            s, i = cell
            place = np.array(
                [front + rng.uniform(0.03, 0.14), s * width / 4 + rng.uniform(-0.1, 0.1), low + gap * (i + rng.uniform(0.4, 0.7))]
            )
            return pose(place, rng.uniform(-0.3, 0.5), rng.uniform(-0.5, 0.5), rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi]))

        return inside

    return bodies, draw(cells[picked[0]]), draw(cells[picked[1]])


def open_box(rng: np.random.Generator) -> Scene:
    """A box open at the top; from beside it, low at the table, down into it."""
    size, tall, yaw = rng.uniform(0.26, 0.4, 2), rng.uniform(0.18, 0.3), rng.uniform(-0.6, 0.6)
    center = np.array([rng.uniform(0.15, 0.35), rng.uniform(-0.15, 0.15)])
    c, s = np.cos(yaw), np.sin(yaw)
    bodies = [table()]
    for k, (dx, dy, sx, sy) in enumerate(
        [(0.5, 0, 0.015, size[1]), (-0.5, 0, 0.015, size[1]), (0, 0.5, size[0], 0.015), (0, -0.5, size[0], 0.015)]
    ):
        at = center + np.array([c * dx * size[0] - s * dy * size[1], s * dx * size[0] + c * dy * size[1]])
        bodies.append(box(f"wall{k}_", (sx, sy, tall), (at[0], at[1], TABLE_HEIGHT + tall / 2), yaw))
    bodies += _clutter(rng, 4, center, 0.35)

    def inside(rng: np.random.Generator) -> FloatArray:
        off = rng.uniform(-0.25, 0.25, 2) * size
        at = center + np.array([c * off[0] - s * off[1], s * off[0] + c * off[1]])
        return pose(
            np.array([*at, TABLE_HEIGHT + rng.uniform(0.03, 0.12)]), np.pi / 2 + rng.uniform(-0.25, 0.25), rng.uniform(-3, 3)
        )

    def beside(rng: np.random.Generator) -> FloatArray:
        side = rng.choice([-1.0, 1.0])
        place = np.array([rng.uniform(0.1, 0.45), side * rng.uniform(0.35, 0.5), TABLE_HEIGHT + rng.uniform(0.05, 0.2)])
        return pose(place, np.pi / 2 + rng.uniform(-0.4, 0.4), rng.uniform(-3, 3))

    return bodies, beside, inside


def cage(rng: np.random.Generator) -> Scene:
    """Upright bars around a place on the table with a lid of bars; the gripper enters between them and leaves to elsewhere."""
    center, radius = np.array([rng.uniform(0.22, 0.32), rng.uniform(-0.12, 0.12)]), rng.uniform(0.24, 0.3)
    count, tall, turn = int(rng.integers(5, 7)), rng.uniform(0.35, 0.5), rng.uniform(0, 2 * np.pi)
    bodies = [table()]
    for k in range(count):
        angle = turn + 2 * np.pi * k / count
        at = center + radius * np.array([np.cos(angle), np.sin(angle)])
        bodies.append(can(f"bar{k}", 0.012, tall, (at[0], at[1], TABLE_HEIGHT + tall / 2)))
    for k, offset in enumerate((-0.6, 0.6)):
        at = center + radius * offset * np.array([np.cos(turn), np.sin(turn)])
        bodies.append(box(f"lid{k}", (0.025, 2 * radius, 0.025), (at[0], at[1], TABLE_HEIGHT + tall), turn))

    def inside(rng: np.random.Generator) -> FloatArray:
        at = center + rng.uniform(-0.5, 0.5, 2) * radius
        return pose(
            np.array([*at, TABLE_HEIGHT + rng.uniform(0.05, 0.25)]),
            rng.uniform(0.0, np.pi / 2),
            rng.uniform(-1.0, 1.0),
            rng.uniform(-1.6, 1.6),
        )

    def elsewhere(rng: np.random.Generator) -> FloatArray:
        place = np.array(
            [rng.uniform(-0.05, 0.35), rng.choice([-1.0, 1.0]) * rng.uniform(0.42, 0.6), TABLE_HEIGHT + rng.uniform(0.1, 0.5)]
        )
        return pose(place, rng.uniform(0.2, np.pi / 2), rng.uniform(-1.5, 1.5))

    return bodies, elsewhere, inside


def crowded_table(rng: np.random.Generator) -> Scene:
    """Posts, blocks and cans all over the table, a beam above; from low between them on one side to the other."""
    bodies = [table(), *_clutter(rng, 14, np.array([0.3, 0.0]), 0.0)]
    bodies.append(
        box(
            "beam",
            (0.06, 0.9, 0.06),
            (rng.uniform(0.1, 0.4), 0.0, TABLE_HEIGHT + rng.uniform(0.45, 0.65)),
            rng.uniform(-0.4, 0.4),
        )
    )

    def low(side: float) -> Callable[[np.random.Generator], FloatArray]:
        def draw(rng: np.random.Generator) -> FloatArray:
            place = np.array([rng.uniform(0.15, 0.5), side * rng.uniform(0.12, 0.42), TABLE_HEIGHT + rng.uniform(0.04, 0.15)])
            return pose(place, rng.uniform(0.5, np.pi / 2 + 0.2), rng.uniform(-1.2, 1.2), rng.uniform(-1.6, 1.6))

        return draw

    return bodies, low(-1.0), low(1.0)


def _clutter(rng: np.random.Generator, count: int, center: FloatArray, clear: float) -> list[BodySnapshot]:
    """Blocks and cans on the table, not nearer to `center` than `clear`, nor to the arm's foot than 0.25 m."""
    bodies: list[BodySnapshot] = []
    while len(bodies) < count:
        at = rng.uniform([0.0, -0.6], [0.65, 0.6])
        if np.linalg.norm(at - center) < clear or np.linalg.norm(at - [-0.273, 0.0]) < 0.25:
            continue
        tall = rng.uniform(0.1, 0.4)
        where = (at[0], at[1], TABLE_HEIGHT + tall / 2)
        k = len(bodies)
        if rng.random() < 0.5:
            bodies.append(can(f"post{k}", rng.uniform(0.015, 0.04), tall, where))
        else:
            bodies.append(box(f"block{k}", (*rng.uniform(0.04, 0.12, 2), tall), where, rng.uniform(0.0, np.pi)))
    return bodies


KINDS: dict[str, Callable[[np.random.Generator], Scene]] = {
    "shelf": shelf, "box": open_box, "cage": cage, "table": crowded_table,
}  # fmt: skip


def generate(kind: str, seed: int, model: RobotModel | None = None) -> PlanningProblem:
    """Return the problem of a kind and seed; scenes without free start and goal poses are drawn again."""
    model = model or RobotModel(robot_description("panda"))
    rng = np.random.default_rng([seed, sorted(KINDS).index(kind)])
    while True:
        bodies, draw_start, draw_goal = KINDS[kind](rng)
        collision = CollisionModel(model)
        collision.update(WorldSnapshot(tuple(bodies), model.home, FINGERS))
        start, goal = _free(model, collision, draw_start, rng), _free(model, collision, draw_goal, rng)
        if start is not None and goal is not None:
            return PlanningProblem(f"{kind}_{seed:03d}", WorldSnapshot(tuple(bodies), start, FINGERS), goal)


def _free(
    model: RobotModel, collision: CollisionModel, draw: Callable[[np.random.Generator], FloatArray], rng: np.random.Generator
) -> FloatArray | None:
    """Draw poses until one has a configuration with 5 mm of clearance."""
    collision.clear()
    for _ in range(30):
        try:
            q = solve_ik(model, draw(rng), model.home, rng, starts=8, collision=collision)[0]
        except PlanningError:
            continue
        if collision.keeps_away(q, 0.005) and model.limits.margin(q) > 0.01:
            return q
    return None


def all_problems(per_kind: int = PER_KIND, first_seed: int = 0) -> list[PlanningProblem]:
    """Return the set: `per_kind` problems of each of the four kinds."""
    model = RobotModel(robot_description("panda"))
    return [generate(kind, seed, model) for kind in KINDS for seed in range(first_seed, first_seed + per_kind)]
