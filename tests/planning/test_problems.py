"""Planning problems as files."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import ProblemFileError
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.planning.problems import (
    PlanningProblem,
    read_motion_bench,
    read_problem,
    self_contained,
    solid_body,
    write_problem,
)
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import Shape, WorldSnapshot
from rlbench_pin.spatial import pose_at
from tests.worlds_for_tests import HOME, TABLE_TOP, Boxes

SCENE = """
name: shelf
world:
  collision_objects:
    - id: Can1
      primitives:
        - {type: cylinder, dimensions: [0.2, 0.03]}
      primitive_poses:
        - {position: [0.5, 0.1, 0.3], orientation: [0, 0, 0, 1]}
    - id: shelf
      pose: {position: [0.6, 0, 0], orientation: [0, 0, 0, 1]}
      primitives:
        - {type: box, dimensions: [0.3, 0.8, 0.02]}
        - {type: sphere, dimensions: [0.05]}
      primitive_poses:
        - {position: [0.0, 0, 0.2], orientation: [0, 0, 0, 1]}
        - {position: [0.1, 0, 0.6], orientation: [0, 0, 0, 1]}
"""
REQUEST = """
start_state:
  joint_state:
    name: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7]
    position: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]
goal_constraints:
  - joint_constraints:
%s
"""
GOAL = [1.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


def yaml_files(folder: Path) -> tuple[Path, Path]:
    """Write a scene and a request."""
    scene, request = folder / "scene0001.yaml", folder / "request0001.yaml"
    joints = "\n".join(f"      - {{joint_name: panda_joint{i + 1}, position: {q}}}" for i, q in enumerate(GOAL))
    scene.write_text(SCENE)
    request.write_text(REQUEST % joints)
    return scene, request


def test_bodies_with_several_links_may_still_be_touched(model: RobotModel, boxes: Boxes, tmp_path: Path) -> None:
    """Each link becomes a body with a name of its own; all of them stay allowed."""
    parts = [
        replace(boxes.box("chest", (0.05, 0.05, 0.05), (0.5, 0.1 * k, 1.0)), name=f"chest/{part}") for k, part in enumerate("ab")
    ]
    other = boxes.box("chest2", (0.05, 0.05, 0.05), (0.4, 0.3, 1.0))
    problem = PlanningProblem("x", boxes.snapshot(*parts, other), goal=HOME, allowed=("chest",))
    for _ in range(2):
        write_problem(problem, tmp_path / "x.json")
        problem = read_problem(tmp_path / "x.json")
        assert problem.allowed == ("chest/a", "chest/b")


def test_a_world_survives_its_file(model: RobotModel, boxes: Boxes, tmp_path: Path) -> None:
    """What is read back answers all collision questions alike, to the last bit."""
    cube = boxes.box("cube", (0.05, 0.05, 0.05), model.tip_pose(HOME)[:3])
    pot = solid_body(
        "pot", [Shape("cylinder", (0.1, 0.2)), Shape("sphere", (0.1,)), Shape("capsule", (0.05, 0.4))], pose_at((0.4, 0.2, 1.0))
    )
    world = boxes.snapshot(cube, pot, boxes.screen(), opening=0.025, attached=("cube",))
    problem = PlanningProblem("test", world, poses=np.array([pose_at((0.35, 0.25, TABLE_TOP + 0.1), np.pi, 0.0, np.pi)]))
    write_problem(problem, tmp_path / "a.json")
    back = read_problem(tmp_path / "a.json")
    write_problem(back, tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    assert back.world.attached == ("cube",)
    assert [body.name for body in back.world.bodies if body.in_room] == ["table"]
    first, second = CollisionModel(model), CollisionModel(model)
    first.update(world)
    second.update(back.world)
    for q in np.random.default_rng(0).uniform(model.limits.lower, model.limits.upper, (200, 7)):
        assert first.colliding_pairs(q) == second.colliding_pairs(q)


def test_files_without_the_room_are_still_read(boxes: Boxes, tmp_path: Path) -> None:
    """In files of earlier versions, bodies belong to the room by their names."""
    file = tmp_path / "old.json"
    write_problem(PlanningProblem("old", boxes.snapshot(*boxes.cubes(1)), goal=HOME), file)
    content = json.loads(file.read_text())
    for body in content["bodies"]:
        del body["in_room"]
    file.write_text(json.dumps(content))
    assert [body.in_room for body in read_problem(file).world.bodies] == [True, False]


def test_model_files_become_shapes(boxes: Boxes) -> None:
    """A self-contained world refers to no file."""
    assert all(body.shapes for body in self_contained(boxes.snapshot(*boxes.cubes(2))).bodies)


def test_damaged_files_are_refused(tmp_path: Path) -> None:
    """The error names the file and what is wrong."""
    for text, says in (("{", "broken.json"), ("[]", "format 1"), (json.dumps({"format": 1}), "KeyError")):
        file = tmp_path / "broken.json"
        file.write_text(text)
        with pytest.raises(ProblemFileError, match=says):
            read_problem(file)
    with pytest.raises(ProblemFileError):
        read_problem(tmp_path / "nothing.json")


def test_motion_bench_files_are_read_and_solved(tmp_path: Path) -> None:
    """Shapes stand where the files say, cylinders have their height first, and the problem can be planned."""
    problem = read_motion_bench(*yaml_files(tmp_path))
    can, shelf = problem.world.bodies
    assert can.shapes[0] == Shape("cylinder", (0.03, 0.2), (0.5, 0.1, 0.3, 0.0, 0.0, 0.0, 1.0))
    assert shelf.shapes[1].pose[:3] == pytest.approx((0.7, 0.0, 0.6))
    np.testing.assert_array_equal(problem.goal, GOAL)
    model = problem.model()
    assert model.base.translation == pytest.approx([0.0, 0.0, 0.0])
    planner = MotionPlanner(model)
    planner.update(problem.world)
    plan = planner.plan_to_configuration(problem.start, problem.goal, rng=np.random.default_rng(0))  # type: ignore[arg-type]
    np.testing.assert_allclose(plan.trajectory.q[-1], GOAL, atol=1e-9)


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("type: sphere", "type: cone", "cone"),
        ("[0.05]", "[]", "1 dimensions"),
        ("primitives:", "meshes: [m]\n      primitives:", "meshes"),
    ],
)
def test_unknown_shapes_are_refused(tmp_path: Path, before: str, after: str, says: str) -> None:
    """Nothing is silently left out of a scene."""
    scene, request = yaml_files(tmp_path)
    scene.write_text(SCENE.replace(before, after))
    with pytest.raises(ProblemFileError, match=says):
        read_motion_bench(scene, request)


def test_requests_without_a_joint_are_refused(tmp_path: Path) -> None:
    """The error names the request file."""
    scene, request = yaml_files(tmp_path)
    request.write_text(request.read_text().replace("panda_joint7, position", "other, position"))
    with pytest.raises(ProblemFileError, match="request0001"):
        read_motion_bench(scene, request)


def test_an_empty_world_needs_no_objects(tmp_path: Path) -> None:
    """A scene without objects is a scene."""
    scene, request = yaml_files(tmp_path)
    scene.write_text("world: {collision_objects: []}\n")
    assert isinstance(read_motion_bench(scene, request).world, WorldSnapshot)
