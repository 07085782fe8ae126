"""What differs from the known interface in the package itself; rows of `docs/compatibility.md`."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import rlbench_pin
from rlbench_pin import (
    Discrete,
    EndEffectorPoseViaPlanning,
    Environment,
    JointVelocity,
    MoveArmThenGripper,
    ObservationConfig,
    TaskEnvironment,
)
from rlbench_pin.environment import CameraConfig, ERJointViaIK, GaussianNoise, GripperJointPosition, RelativeFrame
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.environment.randomization import RandomizeEvery, VisualRandomizationConfig
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.tasks import task_class, task_names
from rlbench_pin.tasks.library.reach_target import ReachTarget

LID = "take_lid_off_saucepan"


def make(config: ObservationConfig | None = None, **settings: float) -> Environment:
    """An environment of joint velocities."""
    mode = MoveArmThenGripper(JointVelocity(), Discrete())
    return Environment(mode, obs_config=config or low_dim_config(), seed=0, **settings)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    """An environment that is asked for a window."""
    with make(headless=False) as environment:
        yield environment


@pytest.fixture
def lid(environment: Environment) -> TaskEnvironment:
    """The lid, at the start of an episode."""
    task = environment.get_task(LID)
    task.reset(seed=1)
    return task


def test_there_is_a_runtime_and_no_scene(lid: TaskEnvironment) -> None:
    """It holds world, task, model and planner, and action modes take it."""
    runtime = lid.runtime
    assert isinstance(runtime, Runtime) and runtime.world is lid.world and runtime.task is lid.task
    assert runtime.planner.model is runtime.model and not [n for n in ("_scene", "_task", "_robot") if hasattr(lid, n)]
    Discrete().action(runtime, [1.0])


def test_no_global_generator_is_read_or_set(environment: Environment) -> None:
    """A reset, a demonstration and a reset to it draw nothing that a program would miss."""
    task = environment.get_task("reach_target")
    starts = []
    for seed in (1, 2):
        np.random.seed(seed)  # noqa: NPY002
        random.seed(seed)
        before = np.random.get_state()[1].tobytes(), random.getstate()  # type: ignore[union-attr]  # noqa: NPY002
        _, start = task.reset(seed=5)
        task.reset_to_demo(task.get_demos(1, live_demos=True, seed=6)[0])
        assert (np.random.get_state()[1].tobytes(), random.getstate()) == before  # type: ignore[union-attr]  # noqa: NPY002
        starts.append(start.get_low_dim_data())
    assert np.array_equal(*starts)


def test_a_task_is_a_class_or_a_name(environment: Environment) -> None:
    """Either gives the same task."""
    assert type(environment.get_task("reach_target").task) is type(environment.get_task(ReachTarget).task) is ReachTarget


def test_grasping_is_left_to_the_environment(lid: TaskEnvironment) -> None:
    """By default; a mode that was told decides itself."""
    for choice in (True, False):
        lid.runtime.gripper.attaches = choice
        for mode in (Discrete, GripperJointPosition):
            assert (
                mode().attaches(lid.runtime) is choice
                and mode(True).attaches(lid.runtime)
                and not mode(False).attaches(lid.runtime)
            )
    with make(attach_grasped_objects=False) as environment:
        assert not Discrete().attaches(environment.get_task("reach_target").runtime)


def test_lights_change_by_default() -> None:
    """With the patterns that come with the package; `light=0.0` leaves them alone."""
    config = VisualRandomizationConfig()
    assert config.image_directory.is_dir() and config.light == 1.0
    lights = []
    for light in (1.0, 0.0):
        visual = VisualRandomizationConfig(light=light, textures=False)
        mode = MoveArmThenGripper(JointVelocity(), Discrete())
        with Environment(
            mode, "", low_dim_config(), randomize_every=RandomizeEvery.EPISODE, visual_randomization_config=visual, seed=0
        ) as environment:
            task = environment.get_task("reach_target")
            task.reset(seed=1)
            lights.append(task.runtime.observer.appearance.lighting)
    assert lights[0] not in (None, ObservationConfig().lighting) and lights[1] in (None, ObservationConfig().lighting)


def test_the_arm_keeps_the_speed_limits_of_its_joints(lid: TaskEnvironment) -> None:
    """A hundred radians per second are asked for."""
    before = lid.get_observation().joint_positions
    after = lid.step([100.0, 0, 0, 0, 0, 0, 0, 1.0])[0].joint_positions
    assert before is not None and after is not None
    assert 0.0 < after[0] - before[0] <= 0.05 * lid.runtime.model.limits.velocity[0] * 1.05


def test_a_refused_hand_stops_the_arm_as_well(lid: TaskEnvironment) -> None:
    """Both parts are looked at before anything moves; numbers that are none are refused, too."""
    ticks = lid.world.ticks
    for action in ([0.5] * 7 + [1.5], [np.nan] * 7 + [1.0], [np.inf] * 7 + [1.0]):
        with pytest.raises(InvalidActionError):
            lid.step(action)
    assert lid.world.ticks == ticks


def test_ticks_of_the_hand_are_steps_of_the_runtime(lid: TaskEnvironment) -> None:
    """A callback is called for each; opening settles for ten ticks more."""
    calls: list[int] = []
    lid.runtime.register_step_callback(count := lambda: calls.append(lid.world.ticks))
    before = lid.world.ticks
    Discrete().action(lid.runtime, [0.0])
    Discrete().action(lid.runtime, [1.0])
    lid.runtime.remove_step_callback(count)
    assert calls == list(range(before + 1, lid.world.ticks + 1)) and len(calls) > 15


def test_delta_angles_and_words_for_frames() -> None:
    """Misuse is an error of actions, not an assertion; a frame may be said by its word."""
    with pytest.raises(InvalidActionError, match="absolute_mode=False"):
        ERJointViaIK(absolute_mode=True, delta_angle=True)
    assert EndEffectorPoseViaPlanning(frame="end effector").frame is RelativeFrame.EE
    assert EndEffectorPoseViaPlanning(frame="world").frame is RelativeFrame.WORLD


def test_all_plans_of_an_episode_draw_the_same_numbers(lid: TaskEnvironment) -> None:
    """Other episodes draw others."""
    here = [lid.runtime.planning_rng.random() for _ in range(2)]
    lid.reset(seed=2)
    assert here[0] == here[1] != lid.runtime.planning_rng.random()


def test_the_tip_at_the_known_start_joints(lid: TaskEnvironment) -> None:
    """19 mm lower than published, and pointing down is the known quaternion, up to the tilt."""
    x, y, z, *quaternion = lid.runtime.model.tip_pose(np.array([0.0, 0.175, 0.0, -0.873, 0.0, 1.222, 0.785]))
    assert (x, y, z) == pytest.approx((0.278, 0.0, 1.453), abs=1.5e-3)
    assert abs(quaternion[1]) > 0.99 and abs(quaternion[3]) < 0.121


def test_forces_do_not_depend_on_the_direction_of_motion(lid: TaskEnvironment) -> None:
    """The shoulder holds the arm with a negative torque, moving up or down."""
    forces = [lid.step([0, velocity, 0, 0, 0, 0, 0, 1.0])[0].joint_forces for velocity in (0.05, -0.05)]
    assert all(force is not None and force[1] < -10.0 for force in forces)


def test_a_camera_matrix_is_in_misc() -> None:
    """Where the flag asks for it."""
    config = low_dim_config()
    config.wrist_camera_matrix = True
    with make(config) as environment:
        _, observation = environment.get_task("reach_target").reset()
    assert observation.misc["wrist_camera_matrix"].shape == (4, 4)


def test_every_frame_has_a_tick_of_its_own() -> None:
    """Also at waypoints that only ignore collisions, as the last one of the lid; the first frame is the start."""
    config = low_dim_config()
    config.record_gripper_closing = True
    with make(config) as environment:
        task = environment.get_task(LID)
        ticks: list[int] = []
        outcome = task.try_demo(seed=1, on_frame=lambda frame: ticks.append(task.world.ticks))
        assert outcome.demo is not None and ticks == list(range(ticks[0], ticks[0] + len(outcome.demo)))
        _, start = task.reset(seed=1)
        assert task.world.ticks == ticks[0]
        assert np.array_equal(start.get_low_dim_data(), outcome.demo[0].get_low_dim_data())


def test_actions_of_frames_do_not_stay_behind(lid: TaskEnvironment) -> None:
    """They are in the frames of a demonstration after the first, and in no observation after it."""
    demo = lid.get_demos(1, live_demos=True, seed=1)[0]
    assert [i for i, frame in enumerate(demo) if "joint_position_action" not in frame.misc] == [0]
    assert "joint_position_action" not in lid.get_observation().misc


def test_planned_motions_keep_their_speed_along_the_path() -> None:
    """The norm of the joint velocity reaches `arm_max_velocity` and stays below; accelerations may jump."""
    with make(arm_max_velocity=0.5) as environment:
        task = environment.get_task("reach_target")
        task.reset(seed=1)
        runtime = task.runtime
        target = runtime.robot.tip_pose() + np.array([0.1, 0.2, -0.2, 0.0, 0.0, 0.0, 0.0])
        trajectory = runtime.planner.plan_to_pose(runtime.robot.joint_positions, target, rng=runtime.planning_rng).trajectory
        times = np.linspace(0.0, trajectory.duration, 400)
        speeds = [np.linalg.norm(trajectory.sample(float(t))[1]) for t in times]
    assert 0.49 < max(speeds) <= 0.5 + 1e-6


def test_joint_poses_are_without_noise() -> None:
    """Positions of joints have it where it is asked for."""
    config = low_dim_config()
    config.joint_poses, config.joint_positions_noise = True, GaussianNoise(0.2)
    with make(config) as environment:
        task = environment.get_task("reach_target")
        _, seen = task.reset(seed=1)
        q = task.runtime.robot.joint_positions
        assert seen.joint_positions is not None and np.abs(seen.joint_positions - q).max() > 0.02
        assert np.array_equal(seen.misc["joint_poses"], task.runtime.model.joint_poses(q))


def test_scenes_are_toml_and_objects_urdf() -> None:
    """Every task has a scene file, whose bodies are URDF; no model or scene of another simulator is in the package."""
    package = Path(rlbench_pin.__file__).parent
    assert [file for pattern in ("*.ttm", "*.ttt") for file in package.rglob(pattern)] == []
    specs = [task_class(name).scene_file() for name in task_names()]
    assert {file.suffix for file in specs} == {".toml"} and all(file.is_file() for file in specs)
    assert {Path(body.asset).suffix for file in specs for body in read_scene(file).body} == {".urdf"}


def test_settings_of_a_camera_go_by_name() -> None:
    """A render mode is a word."""
    with pytest.raises(TypeError):
        CameraConfig(True, None)  # type: ignore[misc]
    assert CameraConfig(render_mode="opengl3").draws_shadows and not CameraConfig(render_mode="opengl").draws_shadows


def test_a_camera_may_deliver_masks_alone() -> None:
    """It is described in `misc` as those with images are."""
    config = low_dim_config()
    config.front_camera.mask, config.front_camera.image_size = True, (16, 12)
    with make(config) as environment:
        _, seen = environment.get_task("reach_target").reset()
    assert seen.front_mask is not None and seen.front_mask.shape == (12, 16) and seen.front_rgb is None
    assert "front_camera_extrinsics" in seen.misc
