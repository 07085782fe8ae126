"""Measurements of an arm: agreement of its models, inverse kinematics, gripper, limits and demonstrations.

Each measurement is a function of a robot description. `check_arm` compares the measurements with bounds that all arms of the
catalogue meet.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from rlbench_pin.datasets import encode_demo
from rlbench_pin.environment import Environment
from rlbench_pin.environment.actions import Discrete, JointVelocity, MoveArmThenGripper, SafeArm
from rlbench_pin.environment.observations.config import CameraConfig
from rlbench_pin.environment.observations.observe import camera_view
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import NoIkSolution, PlanningError, RlbenchPinError
from rlbench_pin.observation import Demo
from rlbench_pin.planning.kinematics import solve_ik
from rlbench_pin.robot import CollisionModel, RobotDescription, RobotModel
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import Body, World
from rlbench_pin.sim.client import bullet
from rlbench_pin.spatial import FloatArray, above_table, rotation_distance
from rlbench_pin.values import as_record, as_whole

POSITION, ROTATION, TORQUE = 1e-6, 1e-6, 1e-6
"""Maximum differences between simulation and model [m], [rad], and as a fraction of the largest torque."""
SOLVED = 0.995
"""Minimum fraction of reachable poses that inverse kinematics solves."""
DEPTH = 0.002
"""Largest penetration of the pads into a cube after the gripper closed on it [m]."""
SUNK = 0.005
"""Largest distance by which a cube of 1 kg may sink in the gripper [m]."""
POINTS_DOWN = -0.98
"""The z axis of the tip points down when its vertical component is below this."""
WORKSPACE = ((0.15, -0.25, 0.1), (0.35, 0.25, 0.3))
"""Lower and upper corner of the box of tip positions; heights are above the table [m]."""
SEEN = 0.3
"""Minimum fraction of the wrist camera image that must show the table."""
TASKS = ("reach_target", "pick_and_lift")
"""Tasks whose demonstrations are checked."""


@dataclass(frozen=True)
class ArmCheck:
    """One line of the report on an arm."""

    name: str
    """Name of the check."""
    figure: str
    """The measured figure, with its unit."""
    passed: bool | None
    """Whether the check passed; None for a check that only informs."""
    advice: str = ""
    """The next step when the check failed."""


def check_arm(description: RobotDescription, actions: int = 300) -> Iterator[ArmCheck]:
    """Yield the result of each of the `len(CHECKS)` checks of an arm as soon as it is available.

    Args:
        description: The arm.
        actions: Number of random actions that are sent through the safety filter.
    """
    as_record(description, RobotDescription, "description")
    as_whole(actions, "actions", least=1)
    for name, check, advice in CHECKS:
        try:
            figure, passed = check(description, actions)
        except RlbenchPinError as error:
            figure, passed = str(error), False
        yield ArmCheck(name, figure, passed, "" if passed is not False else advice)


# Models ---------------------------------------------------------------------------------------------------------------


def random_configurations(model: RobotModel, count: int, turn: float = 2.0 * np.pi) -> FloatArray:
    """Return random configurations (count, n) [rad] within the joint limits and within -`turn` to `turn` [rad]."""
    low, high = np.maximum(model.limits.lower, -turn), np.minimum(model.limits.upper, turn)
    return np.random.default_rng(0).uniform(low, high, (count, model.size))


def tip_deviation(model: RobotModel, configurations: FloatArray, opening: float = 1.0) -> tuple[float, float]:
    """Return the largest difference between the tip poses of simulation and model [m], [rad].

    Args:
        model: The arm.
        configurations: Joint positions, shape (count, n), [rad].
        opening: Opening of the gripper, 0 closed to 1 open.
    """
    far, turned = 0.0, 0.0
    opened = [opening * model.description.gripper_open] * 2
    with World(SceneSpec(format=1), model.description) as world:
        for q in configurations:
            world.robot.reset_configuration(q, opened)
            simulated, analytic = world.robot.tip_pose(), model.tip_pose(q)
            far = max(far, float(np.abs(simulated[:3] - analytic[:3]).max()))
            turned = max(turned, rotation_distance(simulated, analytic))
    return far, turned


def gravity_deviation(model: RobotModel, configurations: FloatArray) -> float:
    """Return the largest difference between the gravity torques of simulation and model.

    The difference is a share of the largest torque of the configuration, or of 1 N m if that is larger.
    """
    description, hand = model.description, fingers_of(model.description)
    opened = dict(zip(hand.joints, hand.joint_values(np.full(2, description.gripper_open)), strict=True))
    worst = 0.0
    with World(SceneSpec(format=1), description) as world:
        uid, client = world.robot.model.uid, world.client.id
        joints = [bullet.getJointInfo(uid, k, client) for k in range(bullet.getNumJoints(uid, client))]
        names = [joint[1].decode() for joint in joints if joint[2] != bullet.JOINT_FIXED]
        arm, rest = [names.index(name) for name in description.arm_joints], [0.0] * len(names)
        for q in configurations:
            values = opened | dict(zip(description.arm_joints, q, strict=True))
            full = bullet.calculateInverseDynamics(uid, [values[name] for name in names], rest, rest, physicsClientId=client)
            analytic = model.gravity(q)
            worst = max(worst, float(np.abs(np.array(full)[arm] - analytic).max() / max(1.0, np.abs(analytic).max())))
    return worst


def solved_poses(model: RobotModel, count: int = 1000) -> int:
    """Return how many tip poses of `count` random configurations inverse kinematics solves, starting from home."""
    rng, solved = np.random.default_rng(2), 0
    low, high = np.maximum(model.limits.lower, -np.pi), np.minimum(model.limits.upper, np.pi)
    for q in rng.uniform(low, high, (count, model.size)):
        pose = model.tip_pose(q)
        with suppress(NoIkSolution):
            (found, *_) = solve_ik(model, pose, model.home, rng)
            solved += bool(np.abs(model.tip_pose(found)[:3] - pose[:3]).max() < 1e-4)
    return solved


def reached_places(model: RobotModel, count: int = 20) -> int:
    """Return how many of `count` random positions of the workspace the gripper reaches from above without self-collision."""
    collision, rng, reached = CollisionModel(model), np.random.default_rng(1), 0
    for _ in range(count):
        x, y, z = rng.uniform(*WORKSPACE)
        with suppress(PlanningError):
            found = solve_ik(model, [x, y, above_table(z), 0.0, 1.0, 0.0, 0.0], model.home, rng, collision=collision)
            reached += bool(np.abs(model.tip_pose(found[0])[:3] - [x, y, above_table(z)]).max() < 1e-4)
    return reached


# Simulation -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Grip:
    """Result of closing the gripper on a cube of 40 mm, and of holding such a cube of 1 kg by friction alone."""

    opened: float
    """Smaller distance of the two pads from the middle with the gripper open [m]."""
    shut: float
    """Larger distance of the two pads from the middle with the gripper closed, without an object [m]."""
    depth: float
    """Larger penetration of the two pads into the cube after the gripper closed on it [m]."""
    held: bool
    """Whether the cube is between the fingers after 2 s."""
    sunk: float
    """Distance by which the cube has sunk after 2 s [m]."""
    falls: bool
    """Whether the cube falls when the gripper opens."""


def grip_of(description: RobotDescription) -> Grip:
    """Return how the gripper opens, closes, holds a cube and releases it."""
    spec = SceneSpec(format=1, body=[BodySpec(name="cube", asset="objects/cube_small/cube_small.urdf")])
    with World(spec, description) as world:
        cube, gripper = world.body("cube"), world.gripper
        world.robot.reset_configuration(RobotModel(description).home)
        opened = float(world.robot.fingers.min())
        gripper.set_target(0.0)
        _play(world, 40)
        shut = float(world.robot.fingers.max())
        world.robot.reset_configuration(RobotModel(description).home)
        cube.graspable = True
        world.dynamics_overrides.set_mass(cube.model, -1, 1.0)
        gripper.rely_on_friction()
        height = _open_and_shut_on(world, cube)
        _play(world, 40)
        held, sunk = gripper.held == ("cube",), float(height - cube.position[2])
        gripper.set_target(1.0)
        _play(world, 20)
        falls = bool(cube.position[2] < height - 0.1)
    with World(spec, description) as world:
        world.robot.reset_configuration(RobotModel(description).home)
        world.body("cube").graspable = True
        _open_and_shut_on(world, world.body("cube"))
        depth = 0.02 - float(world.robot.fingers.min())
    return Grip(opened, shut, depth, held, sunk, falls)


def _open_and_shut_on(world: World, cube: Body) -> float:
    """Open the gripper, close it on a cube that floats between the pads until they hold it, and return the cube's height [m]."""
    world.gripper.set_target(1.0)
    _play(world, 20)
    cube.set_pose(world.robot.tip_pose())
    height = float(cube.position[2])
    world.gripper.set_target(0.0)
    for _ in range(40):
        world.step()
        if not world.gripper.between_fingers():
            cube.set_pose(world.robot.tip_pose())
    return height


def _play(world: World, ticks: int) -> None:
    for _ in range(ticks):
        world.step()


def broken_limits(description: RobotDescription, actions: int, task_name: str = "reach_target") -> tuple[list[str], float]:
    """Play random joint velocities through the safety filter.

    Returns:
        One line for each violated limit and each contact, and the computation time of an action [s].
    """
    mode, rng, faults = MoveArmThenGripper(SafeArm(JointVelocity()), Discrete()), np.random.default_rng(3), list[str]()
    with Environment(mode, obs_config=low_dim_config(), robot_setup=description.reference) as environment:
        task = environment.get_task(task_name)
        task.reset(seed=0)
        robot, limits = task.world.robot, task.runtime.model.limits
        before, began = robot.joint_velocities, time.perf_counter()
        for number in range(actions):
            task.step(np.append(rng.uniform(-1.0, 1.0, len(limits.velocity)) * limits.velocity, 1.0))
            q, v = robot.joint_positions, robot.joint_velocities
            accelerations = np.abs(v - before) / task.world.control_dt
            wrong = {
                "positions": not limits.contains(q),
                "velocities": bool((np.abs(v) > limits.velocity + 1e-6).any()),
                "accelerations": bool((accelerations > 1.001 * np.array(robot.description.acceleration)).any()),
                f"contacts {tuple(robot.contact_forces())}": bool(robot.contact_forces()),
            }
            faults += [f"action {number}: {what}" for what, is_broken in wrong.items() if is_broken]
            before = v
        return faults, (time.perf_counter() - began) / actions


def free_share(description: RobotDescription) -> float:
    """Return the share of the wrist camera's image that shows the table, with the arm at home."""
    with World(SceneSpec(format=1), description) as world:
        world.robot.reset_configuration(np.array(description.home))
        images = world.render(camera_view("wrist", CameraConfig(), world, description))
        assert images.mask is not None
        table = [number for number, name in world.masks.items() if name.split("/")[0] == "table"]
        return float(np.isin(images.mask, table).mean())


def demonstration(description: RobotDescription, task_name: str) -> Demo:
    """Return the demonstration of seed 0 with one attempt.

    Raises:
        DemoError: The attempt failed.
    """
    mode = MoveArmThenGripper(JointVelocity(), Discrete())
    with Environment(mode, obs_config=low_dim_config(), robot_setup=description.reference) as environment:
        return environment.get_task(task_name).get_demos(1, live_demos=True, seed=0, max_attempts=1)[0]


def encoded_demo(description: RobotDescription, task_name: str, seed: int = 1) -> bytes:
    """Return the bytes of the demonstration of a seed, in a new environment."""
    with make_environment(low_dim_config(), robot=description.reference) as environment:
        return encode_demo(environment.get_task(task_name).get_demos(1, live_demos=True, seed=seed)[0])


# The list -------------------------------------------------------------------------------------------------------------

Checked = tuple[str, bool | None]
Checker = Callable[[RobotDescription, int], Checked]
"""Function of a description and a number of actions that returns the measured figure, and whether the check passed."""


def _tip(description: RobotDescription, _: int) -> Checked:
    model = RobotModel(description)
    far, turned = tip_deviation(model, random_configurations(model, 200))
    return f"{far:.1e} m, {turned:.1e} rad", far < POSITION and turned < ROTATION


def _gravity(description: RobotDescription, _: int) -> Checked:
    model = RobotModel(description)
    worst = gravity_deviation(model, random_configurations(model, 200))
    return f"{worst:.1e} of the largest torque", worst < TORQUE


def _weight(description: RobotDescription, _: int) -> Checked:
    model = RobotModel(description)
    share = np.max([np.abs(model.gravity(q)) for q in random_configurations(model, 2000)], axis=0) / model.limits.effort
    joint = description.arm_joints[int(share.argmax())]
    return f"{100.0 * share.max():.0f} % of the torque limit at most ({joint})", bool(share.max() < 1.0)


def _kinematics(description: RobotDescription, _: int) -> Checked:
    solved = solved_poses(RobotModel(description))
    return f"{solved} of 1000 poses", solved >= 1000 * SOLVED


def _home(description: RobotDescription, _: int) -> Checked:
    model = RobotModel(description)
    touches, down = CollisionModel(model).in_collision(model.home), model.tip_se3(model.home).rotation[2, 2]
    margin = model.limits.margin(model.home)
    words = f"{'in self-collision' if touches else 'free'}, tip z {down:.2f}, {margin:.2f} rad from the joint limits"
    return words, not touches and down < POINTS_DOWN


def _workspace(description: RobotDescription, _: int) -> Checked:
    return f"{reached_places(RobotModel(description), 40)} of 40 places from above", None


def _camera(description: RobotDescription, _: int) -> Checked:
    share = free_share(description)
    return f"table in {100.0 * share:.0f} % of the image", share >= SEEN


def _opens(description: RobotDescription, _: int) -> Checked:
    grip = grip_of(description)
    words = f"opens to {1000 * grip.opened:.1f} mm, closes to {1000 * grip.shut:.1f} mm, {1000 * grip.depth:.1f} mm inside a cube"
    words += f", 1 kg sinks {1000 * grip.sunk:.1f} mm"
    shuts = grip.shut < 0.002 and grip.depth < DEPTH
    good = grip.opened > 0.9 * description.gripper_open and shuts and grip.held and grip.sunk < SUNK and grip.falls
    return words + ("" if grip.held else ", not held") + ("" if grip.falls else ", not released"), good


def _safety(description: RobotDescription, actions: int) -> Checked:
    faults, tick = broken_limits(description, actions)
    first = f", first: {faults[0]}" if faults else ""
    return f"{len(faults)} violations in {actions} actions, {1000 * tick:.1f} ms each{first}", not faults


def _bytes(description: RobotDescription, _: int) -> Checked:
    same = encoded_demo(description, TASKS[0]) == encoded_demo(description, TASKS[0])
    return "byte-identical" if same else "different bytes", same


def _demonstrates(task_name: str) -> Checker:
    def check(description: RobotDescription, _: int) -> Checked:
        return f"{len(demonstration(description, task_name))} frames in the first attempt", True

    return check


_MODELS = "Simulation and model read the URDF differently: give every link an <inertial>, and put no mass on fixed frames."
_NOT_DOWN = "Change `home` in the TOML file, or search for a new one with `rlbench-pin arm new`."
_REACH = "Move `base_pose` nearer to the workspace or higher; `rlbench-pin arm new` prints how many places the gripper reaches."
CHECKS: tuple[tuple[str, Checker, str], ...] = (
    ("tip in simulation and model", _tip, _MODELS),
    ("gravity torques of both models", _gravity, _MODELS),
    ("motors carry the arm", _weight, "Look up the torques in the data sheet, and write them as <limit effort> in the URDF."),
    ("inverse kinematics", _kinematics, "Compare the limits and axes of the joints with the data sheet."),
    ("home", _home, _NOT_DOWN),
    ("workspace", _workspace, ""),
    (
        "wrist camera at home",
        _camera,
        "Change `camera_pose`: point its z (its view) along the tip's z, past the fingers.",
    ),
    ("gripper", _opens, "Check `finger_links`, `gripper_open`, `gripper_force` [N] and the friction of the pads in the URDF."),
    ("safety filter", _safety, "Lower `acceleration`. For contacts, check the SRDF: it may ignore links that can touch."),
    ("same seed, same bytes", _bytes, "Report a bug: the same seed must give the same episode."),
    *((f"demonstration of {task}", _demonstrates(task), _REACH) for task in TASKS),
)
"""Name, measurement, and next step of each check."""
