"""What differs under the known names: programs, environments, actions; rows of `docs/compatibility.md`."""

from __future__ import annotations

import importlib
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rlbench
import rlbench_pin
from pyrep import PyRep
from pyrep.errors import UnsupportedCall
from rlbench import Environment, ObservationConfig, RandomizeEvery, VisualRandomizationConfig, dataset_generator
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import EndEffectorPoseViaPlanning, ERJointViaIK, JointTorque, JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete, GripperJointPosition
from rlbench.backend.const import TTT_FILE
from rlbench.backend.exceptions import InvalidActionError
from rlbench.environment import DIR_PATH
from rlbench.task_environment import TaskEnvironment
from rlbench.tasks import ReachTarget, TakeLidOffSaucepan
from rlbench_pin.errors import TaskError

DOWN = [0.0, 1.0, 0.0, 0.0]
TYPED = """
from rlbench.backend.task import Task

class Typed(Task):
    pass
"""


def low_dim() -> ObservationConfig:
    """All low-dimensional data, no images."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.set_all_low_dim(True)
    return config


def make(**settings: Any) -> Environment:
    """Return an environment of joint velocities."""
    return Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=low_dim(), **settings)


@pytest.fixture(scope="module")
def task() -> Iterator[TaskEnvironment]:
    """The reach task in an environment that asks for a window."""
    with make(headless=False) as environment:
        yield environment.get_task(ReachTarget)


@pytest.fixture
def scene(task: TaskEnvironment) -> Any:
    """The scene of a fresh episode."""
    np.random.seed(1)
    task.reset()
    return task._scene


# Programs and import names ----------------------------------------------------------------------------------------------


def test_a_typed_class_has_no_scene(task: TaskEnvironment) -> None:
    """The error asks for a file."""
    namespace: dict[str, Any] = {"__name__": "a_notebook"}
    exec(TYPED, namespace)  # as a notebook does
    with pytest.raises(TaskError, match=r"Typed was not read from a file.*\.toml"):
        task._scene.load(namespace["Typed"](task._pyrep, task._robot))


def test_no_c_functions() -> None:
    """Whatever is called, the error names what to use."""
    sim = importlib.import_module("pyrep.backend.sim")
    with pytest.raises(UnsupportedCall, match="simGetObjectHandle.*pyrep.objects"):
        sim.simGetObjectHandle("Panda")


def test_other_modules_of_pyrep_are_missing() -> None:
    """Mobile robots and signals cannot be imported."""
    for name in ("pyrep.robots.mobiles.youbot", "pyrep.misc.signals"):
        with pytest.raises(ModuleNotFoundError):
            importlib.import_module(name)


def test_the_base_scene_is_a_name() -> None:
    """There is no such file; the simulator takes the name, and no other."""
    assert not (Path(DIR_PATH) / TTT_FILE).exists()
    pyrep = PyRep()
    with pytest.raises(UnsupportedCall):
        pyrep.launch("other.ttt")


def test_versions_and_lists() -> None:
    """The version is that of this package, and the list has its tasks only."""
    assert rlbench.__version__ == rlbench_pin.__version__
    assert [f"{name}.py" for name in sorted(rlbench_pin.task_names())] == rlbench.TASKS


def test_the_generator_is_no_command() -> None:
    """The package installs one command of its own; variations are kept apart unless asked for."""
    settings = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))
    assert list(settings["project"]["scripts"]) == ["rlbench-pin"]
    assert callable(dataset_generator.main) and not dataset_generator.parse_args([]).all_variations


# Environment ------------------------------------------------------------------------------------------------------------


def test_an_episode_takes_one_number_of_the_global_generator(task: TaskEnvironment) -> None:
    """Its seed; what follows in the program is the second number."""
    np.random.seed(8)
    np.random.randint(2**31)
    expected = np.random.rand()
    np.random.seed(8)
    task.reset()
    assert np.random.rand() == expected


def test_reset_to_demo_sets_no_generator(task: TaskEnvironment) -> None:
    """The start is the demo's; what is drawn afterwards goes on as the program seeded it."""
    np.random.seed(2)
    demo = task.get_demos(1, live_demos=True)[0]
    draws = []
    for seed in (5, 6):
        np.random.seed(seed)
        _, start = task.reset_to_demo(demo)
        assert np.array_equal(start.task_low_dim_state, demo[0].task_low_dim_state)  # type: ignore[arg-type]
        draws.append(np.random.rand())
    assert draws[0] != draws[1]
    demo.restore_state()
    seeded = np.random.rand()
    demo.restore_state()
    assert np.random.rand() == seeded


def test_default_configs_are_not_shared() -> None:
    """Switching a camera off in one environment leaves the next one alone."""
    mode = MoveArmThenGripper(JointVelocity(), Discrete())
    first, second = Environment(mode), Environment(mode)
    first._obs_config.set_all(False)
    assert second._obs_config.front_camera.rgb and second._obs_config.joint_positions


def test_no_window_opens(task: TaskEnvironment, monkeypatch: pytest.MonkeyPatch) -> None:
    """The environment of these tests was made with `headless=False`; it works without a screen."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with make(headless=False) as environment:
        assert not environment._headless and environment.action_shape == (8,)


def test_grasping_is_left_to_the_environment(scene: Any) -> None:
    """By default; an explicit setting of a mode takes precedence."""
    runtime = scene.runtime
    for choice in (True, False):
        runtime.gripper.attaches = choice
        assert Discrete().attaches(runtime) is choice and GripperJointPosition().attaches(runtime) is choice
        assert Discrete(attach_grasped_objects=True).attaches(runtime)
        assert not Discrete(False).attaches(runtime)
    runtime.gripper.attaches = True


def test_randomization_of_programs() -> None:
    """Textures are paths, drawn without the global generator; events are words; lights stay."""
    config = VisualRandomizationConfig()
    np.random.seed(3)
    expected = np.random.rand()
    np.random.seed(3)
    assert all(isinstance(texture, Path) for texture in config.sample(3))
    assert np.random.rand() == expected and config.light == 0.0
    assert RandomizeEvery.VARIATION is not RandomizeEvery.TRANSITION
    with pytest.raises(ValueError):
        RandomizeEvery(0)


def test_leaving_the_block_shuts_down() -> None:
    """`with` launches and frees."""
    with make() as environment:
        assert environment._pyrep is not None
    assert environment._pyrep is None


# Actions ----------------------------------------------------------------------------------------------------------------


def test_joint_torque_has_its_own_sign_and_stops(scene: Any) -> None:
    """Torques beyond gravity turn a joint their way; in ticks without a torque action the arm brakes."""
    arm, gravity = scene.robot.arm, scene.runtime.model.gravity
    mode = JointTorque()
    mode.set_control_mode(scene.robot)
    for sign in (1.0, -1.0):
        mode.action(scene, gravity(np.array(arm.get_joint_positions())) + [sign * 4.0, 0, 0, 0, 0, 0, 0])
        assert sign * arm.get_joint_velocities()[0] > 0.02
        for _ in range(3):
            scene.step()
        assert np.abs(arm.get_joint_velocities()).max() < 0.01


def test_the_arm_keeps_the_speed_limits_of_its_joints(scene: Any) -> None:
    """A hundred radians per second are asked for."""
    arm = scene.robot.arm
    before = arm.get_joint_positions()[0]
    JointVelocity().action(scene, [100.0, 0, 0, 0, 0, 0, 0])
    limit = arm.get_joint_upper_velocity_limits()[0]
    assert 0.0 < arm.get_joint_positions()[0] - before <= 0.05 * limit * 1.05


def test_ticks_of_the_hand_are_steps_of_the_scene(scene: Any) -> None:
    """A callback is called for each; opening settles for ten ticks more."""
    calls: list[int] = []
    scene.register_step_callback(lambda: calls.append(scene.runtime.world.ticks))
    before = scene.runtime.world.ticks
    Discrete().action(scene, [0.0])
    Discrete().action(scene, [1.0])
    scene.register_step_callback(None)
    assert calls == list(range(before + 1, scene.runtime.world.ticks + 1)) and len(calls) > 15


def test_differences_of_fingers_are_added(scene: Any) -> None:
    """One centimetre less than measured."""
    before = scene.robot.gripper.get_joint_positions()[0]
    GripperJointPosition(absolute_mode=False).action(scene, [-0.008])
    assert scene.robot.gripper.get_joint_positions()[0] - before == pytest.approx(-0.008, abs=2e-3)


def test_delta_angles_need_relative_mode() -> None:
    """The error is that of actions, not an assertion."""
    with pytest.raises(InvalidActionError, match="absolute_mode=False"):
        ERJointViaIK(absolute_mode=True, delta_angle=True)


def test_a_motion_is_planned_alike_again(scene: Any) -> None:
    """From the same place to the same pose, over the same points."""
    arm, runtime = scene.robot.arm, scene.runtime
    tip = arm.get_tip().get_pose()
    paths = [arm.get_nonlinear_path(tip[:3] + [0.1, 0.3, -0.3], quaternion=tip[3:])._path_points for _ in range(2)]
    assert np.array_equal(*paths)
    assert runtime.planning_rng.random() == runtime.planning_rng.random()


def test_the_tip_at_the_known_start_joints(scene: Any) -> None:
    """Lower and less tilted than published; the direction is the known one."""
    arm = scene.robot.arm
    arm.set_joint_positions([0.0, 0.175, 0.0, -0.873, 0.0, 1.222, 0.785])
    position, quaternion = arm.get_tip().get_position(), arm.get_tip().get_quaternion()
    published = np.array([0.0, 0.993, 0.0, 0.121])
    assert position == pytest.approx([0.278, 0.0, 1.453], abs=1.5e-3)
    assert 1.472 - position[2] == pytest.approx(0.019, abs=1.5e-3)
    between = 2.0 * np.arccos(abs(float(quaternion @ published / np.linalg.norm(published))))
    assert np.rad2deg(between) == pytest.approx(4.0, abs=0.6)


def test_the_hand_may_arrive_turned(task: TaskEnvironment) -> None:
    """At the knob of the lid, which looks the same from four sides, in some episodes; the place is that of the waypoint."""
    lid: Any = TaskEnvironment(task._pyrep, task._robot, task._scene, TakeLidOffSaucepan(task._pyrep, task._robot),
                               task._action_mode, "", task._obs_config)  # fmt: skip
    turns = []
    for seed in range(3):
        np.random.seed(seed)
        lid.reset()
        waypoint = lid._task.get_waypoints()[0]
        tip, wanted = lid.runtime.model.tip_pose(waypoint.get_path()[-1]), waypoint.get_waypoint_object().get_pose()
        assert tip[:3] == pytest.approx(wanted[:3], abs=1e-3)
        turns.append(round(np.rad2deg(2.0 * np.arccos(min(1.0, abs(float(tip[3:] @ wanted[3:])))))))
    assert set(turns) <= {0, 90, 180} and max(turns) > 0
    task._scene.unload()
    task._scene.load(task._task)


def test_poses_by_planning_take_a_fallback_only_from_the_ninth_value(scene: Any) -> None:
    """Without it nothing is given up: the setting of the mode counts."""
    mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(collision_checking=True), Discrete())
    low = [0.3, 0.1, 0.754, *DOWN, 1.0]
    with pytest.raises(InvalidActionError, match="table"):
        mode.action(scene, low)
    mode.action(scene, [*low, 0.0])
    assert scene.robot.arm.get_tip().get_position()[2] < 0.77
