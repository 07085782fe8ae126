"""Another arm is another record: models, planning and control take all that they need from its description."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.control import (
    CartesianImpedance,
    CartesianMPC,
    DifferentialIK,
    DifferentialIKQP,
    JointImpedance,
    OperationalSpaceQP,
    PoseIK,
    SafetyFilter,
)
from rlbench_pin.errors import RobotModelError
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.robot.description import RobotDescription, robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import compose, pose_at
from rlbench_pin.urdf import read_urdf
from tests.worlds_for_tests import TABLE_TOP, Boxes


def robot_data() -> Path:
    """Return the folder of robots of example-robot-data, next to the installed cmeel packages."""
    spec = importlib.util.find_spec("cmeel") or importlib.util.find_spec("numpy")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parents[1] / "cmeel.prefix/share/example-robot-data/robots"


def ur5(folder: Path) -> RobotDescription:
    """A UR5 without a gripper, six joints; its files are copied to `folder` with paths that Coal finds."""
    source = robot_data() / "ur_description"
    text = (source / "urdf/ur5_joint_limited_robot.urdf").read_text()
    (folder / "ur5.urdf").write_text(text.replace("package://example-robot-data/robots", str(robot_data())))
    (folder / "ur5.srdf").write_text((source / "srdf/ur5.srdf").read_text())
    joints = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    return RobotDescription(
        name="ur5",
        urdf=folder / "ur5.urdf",
        srdf=folder / "ur5.srdf",
        arm_joints=tuple(f"{joint}_joint" for joint in joints),
        gripper_joints=(),
        tip_frame="tool0",
        hand_link="wrist_3_link",
        finger_links=(),
        camera_pose=(0.0, 0.08, 0.03, 0.0, 0.0, 0.0, 1.0),
        home=(0.0, -1.4, 1.7, -1.9, -1.57, 0.0),
        base_pose=(-0.3, 0.0, TABLE_TOP, 0.0, 0.0, 0.0, 1.0),
        gripper_open=0.0,
        gripper_force=0.0,
        finger_speed=0.1,
        grip_speed=0.04,
        pad_friction=1.0,
        pad_size=(0.01, 0.01),
        acceleration=(10.0,) * 6,
        reach=1.3,
        linear_speed=1.0,
        angular_speed=3.0,
        loaded_joints=3,
        loaded_share=0.5,
        joint_stiffness=(600.0, 600.0, 400.0, 150.0, 100.0, 50.0),
    )


def renamed_panda(folder: Path) -> RobotDescription:
    """The Panda with other names of joints and links, standing elsewhere and turned."""
    panda = robot_description("panda")
    for file in (panda.urdf, panda.srdf):
        text = file.read_text().replace('filename="', f'filename="{file.parent}/').replace("panda_", "other_")
        (folder / f"other{file.suffix}").write_text(text)

    def other(names: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name.replace("panda", "other") for name in names)

    return replace(
        panda,
        name="other",
        urdf=folder / "other.urdf",
        srdf=folder / "other.srdf",
        arm_joints=other(panda.arm_joints),
        gripper_joints=other(panda.gripper_joints),
        finger_links=other(panda.finger_links),
        tip_frame="other_hand_tcp",
        hand_link="other_hand",
        base_pose=tuple(pose_at((-0.2, 0.3, TABLE_TOP), yaw=-0.4).tolist()),  # type: ignore[arg-type]
    )


@pytest.fixture(scope="module", params=[ur5, renamed_panda])
def description(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> RobotDescription:
    """An arm that the catalogue does not know."""
    result: RobotDescription = request.param(tmp_path_factory.mktemp("arm"))
    return result


@pytest.fixture(scope="module")
def model(description: RobotDescription) -> RobotModel:
    """Its model."""
    return RobotModel(description)


@pytest.fixture
def boxes(tmp_path: Path) -> Boxes:
    """A maker of small worlds."""
    return Boxes(tmp_path)


def goal_pose(model: RobotModel) -> np.ndarray:
    """A tip pose near home."""
    return compose(model.tip_pose(model.home), pose_at((0.05, 0.08, 0.06), yaw=0.3))


def test_the_planner_goes_around_a_screen(model: RobotModel, boxes: Boxes) -> None:
    """A plan to a pose beyond an obstacle ends there, and nothing on its way collides."""
    tip = model.tip_pose(model.home)
    goal = compose(pose_at((0.0, 0.4, 0.0)), tip)
    screen = boxes.box("screen", (0.3, 0.02, 0.5), tip[:3] + [0.0, 0.2, -0.1], fixed=True)
    fingers = np.full(len(model.description.gripper_joints), model.description.gripper_open)
    world = replace(boxes.snapshot(screen), arm=model.home, fingers=fingers)
    planner = MotionPlanner(model)
    planner.update(world)
    plan = planner.plan_to_pose(model.home, goal, rng=np.random.default_rng(0))
    np.testing.assert_allclose(model.tip_pose(plan.trajectory.q[-1])[:3], goal[:3], atol=1e-4)
    planner.collision.clear()
    assert not any(planner.collision.in_collision(q) for q in plan.path)


@pytest.mark.parametrize("controller", [DifferentialIK, DifferentialIKQP])
def test_differential_ik_arrives(model: RobotModel, controller: type[DifferentialIK]) -> None:
    """Integrated velocities bring the tip to its goal."""
    solver, goal = controller(model), goal_pose(model)
    q, v = model.home, np.zeros(model.size)
    for _ in range(40):
        v = solver.velocity_to_pose(q, v, goal)
        q = q + solver.config.dt * v
    np.testing.assert_allclose(model.tip_pose(q)[:3], goal[:3], atol=1e-3)


def test_pose_ik_arrives(model: RobotModel) -> None:
    """A configuration is found for a pose."""
    solution = PoseIK(model).solve(goal_pose(model), model.home, np.random.default_rng(0))
    assert model.limits.contains(solution.q, 1e-9)


def test_the_safety_filter_stops_before_the_table(model: RobotModel, boxes: Boxes) -> None:
    """Driven down without end, the arm stays off the table."""
    safety, pusher = SafetyFilter(model), DifferentialIK(model)
    fingers = np.full(len(model.description.gripper_joints), model.description.gripper_open)
    safety.distances.update(replace(boxes.snapshot(), arm=model.home, fingers=fingers))
    q, v = model.home, np.zeros(model.size)
    for _ in range(80):
        command = safety.filter(q, v, pusher.velocity_for_twist(q, v, (0.0, 0.0, -0.3, 0.0, 0.0, 0.0)))
        v = command.velocity
        q = q + safety.config.dt * v
    nearest = next(d for d in safety.distances.nearest(q, 20) if d.b == "table")
    assert 0.009 < nearest.distance < 0.05


def test_torque_controllers_give_torques(model: RobotModel) -> None:
    """At rest at their targets they carry the arm's weight."""
    q, v = model.home, np.zeros(model.size)
    weight = model.gravity(q)
    joints = JointImpedance(model, model.description.joint_stiffness)
    np.testing.assert_allclose(joints.torque(q, v, q), weight, atol=1e-6)
    np.testing.assert_allclose(CartesianImpedance(model).torque(q, v, model.tip_pose(q)), weight, atol=1e-4)
    np.testing.assert_allclose(OperationalSpaceQP(model).command(q, v, model.tip_pose(q)).torque, weight, atol=1e-2)


def test_prediction_moves_towards_the_goal(model: RobotModel) -> None:
    """The first command of a prediction brings the tip nearer."""
    solver, goal = CartesianMPC(model), goal_pose(model)
    velocity = solver.command(model.home, np.zeros(model.size), goal).velocity
    before = np.linalg.norm(model.tip_pose(model.home)[:3] - goal[:3])
    assert np.linalg.norm(model.tip_pose(model.home + 0.05 * velocity)[:3] - goal[:3]) < before


def test_another_hand_works_in_the_simulation(tmp_path: Path) -> None:
    """Arm and fingers of another description move, and the simulated tip is where the model says."""
    arm = renamed_panda(tmp_path)
    model = RobotModel(arm)
    with World(SceneSpec(format=1), arm) as world:
        np.testing.assert_allclose(world.robot.tip_pose(), model.tip_pose(world.robot.joint_positions), atol=1e-6)
        world.gripper.set_target(0.0)
        for _ in range(30):
            world.step()
        assert world.robot.fingers.max() < 1e-3
        masked = {name.removeprefix("other/") for name in world.masks.values() if name.startswith("other/")}
        assert masked == set(read_urdf(arm.urdf).link_names)


def test_a_hand_without_two_fingers_is_refused(tmp_path: Path) -> None:
    """The simulation names the arm, what its gripper lacks, and what it is still good for."""
    with pytest.raises(RobotModelError, match="two fingers; 'ur5' has 0 gripper joints.*planning and control"):
        World(SceneSpec(format=1), ur5(tmp_path))


def test_vectors_of_a_description_fit_its_joints(tmp_path: Path) -> None:
    """One number per joint, or the record is refused."""
    with pytest.raises(RobotModelError, match="6 arm joints, but 7 numbers in 'acceleration'"):
        replace(ur5(tmp_path), acceleration=(1.0,) * 7)
