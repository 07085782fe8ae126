"""A program of a user with types everywhere: `test_typing.py` lets mypy check it, and nothing runs it."""

from __future__ import annotations

from pathlib import Path
from typing import assert_type

import gymnasium
import numpy as np
from numpy.typing import NDArray

import rlbench_pin
from rlbench_pin import (
    Demo,
    Discrete,
    Environment,
    JointVelocity,
    MoveArmThenGripper,
    Observation,
    ObservationConfig,
    TaskEnvironment,
)
from rlbench_pin.control import DifferentialIK, SafeCommand, SafetyFilter, TrajectoryFollower, VelocityFollowing
from rlbench_pin.datasets import Episode, EpisodeEntry, read_demo, read_manifest
from rlbench_pin.evaluation import (
    Comparison,
    EvaluationConfig,
    PolicyContext,
    Results,
    compare,
    evaluate,
    load_protocol,
    read_results,
    verify_results,
)
from rlbench_pin.gym import gym_id
from rlbench_pin.planning import MotionPlanner, Plan
from rlbench_pin.recording import ImageConfig, RecordConfig, record
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.scene import SceneSpec
from rlbench_pin.tasks import Task, find_task, task_scene


class HoldStill:
    """A policy: it stays where it is."""

    def __init__(self) -> None:
        self.action_mode = MoveArmThenGripper(JointVelocity(), Discrete())
        self.obs_config = ObservationConfig()

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode."""
        self.size = len(context.action_low)

    def act(self, observation: Observation) -> NDArray[np.float64]:
        """Return an action of zeros."""
        return np.zeros(self.size)


def play(policy: HoldStill) -> list[Demo]:
    """Reset, step, and ask for demonstrations."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.front_camera.image_size = (64, 64)
    with Environment(policy.action_mode, obs_config=config, robot_setup="panda", seed=0) as environment:
        task = environment.get_task("open_drawer")
        assert_type(task, TaskEnvironment)
        descriptions, observation = task.reset(seed=7)
        assert_type(descriptions, list[str])
        assert_type(observation, Observation)
        low, high = task.action_bounds()
        for _ in range(3):
            observation, reward, terminate = task.step(np.clip(policy.act(observation), low, high))
            assert_type(reward, float)
            assert_type(terminate, bool)
        if observation.joint_positions is not None:
            total: float = float(observation.joint_positions.sum())
            print(total, observation.misc.get("descriptions"))
        demos = task.get_demos(2, live_demos=True, seed=3)
    for demo in demos:
        print(len(demo), demo.task_name, demo.task_version, demo.variation_number, demo[-1].gripper_pose)
    return demos


def play_with_gymnasium() -> None:
    """Make an environment by its id, and step it."""
    env = gymnasium.make(gym_id("open_drawer", "state"), max_episode_steps=100)
    observation, info = env.reset(seed=1, options={"variation": 0})
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    print(observation, float(reward), terminated or truncated, info["success"])
    env.close()


def control(target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Follow a tip pose within the limits."""
    model = RobotModel(robot_description("panda"))
    policy, guard = DifferentialIK(model), SafetyFilter(model)
    q, v = model.home.copy(), np.zeros(model.size)
    for _ in range(10):
        command = guard.filter(q, v, policy.velocity_to_pose(q, v, target))
        q, v = q + 0.05 * command.velocity, command.velocity
        assert_type(command, SafeCommand)
        print(command.stopped, model.tip_pose(q)[:3], model.jacobian(q).shape)
    plan = MotionPlanner(model).plan_to_pose(q, target, rng=np.random.default_rng(0))
    assert_type(plan, Plan)
    follower = TrajectoryFollower(plan.trajectory, VelocityFollowing(model.limits, 0.05))
    assert_type(follower.time, float)
    return q


def data(folder: Path) -> tuple[EpisodeEntry, ...]:
    """Record and read a dataset."""
    record(RecordConfig(tasks=("open_drawer",), episodes=2, images=ImageConfig(cameras=("front",))), folder)
    entries = read_manifest(folder, "open_drawer")
    for entry in entries:
        path = folder / "open_drawer" / entry.file
        print(entry.task_version, len(read_demo(path, sha256=entry.sha256)))
        with Episode(path) as episode:
            joints: NDArray[np.float64] = episode.array("joint_positions")
            print(joints.shape, episode.task_version)
    return entries


def compare_policies(folder: Path) -> Comparison:
    """Evaluate by a protocol, verify, and compare."""
    config = EvaluationConfig.of_protocol("noop", load_protocol("peract18"))
    first = evaluate(config, folder / "noop.json")
    assert_type(first, Results)
    verified = verify_results(first, 0.05, np.random.default_rng(0))
    print(verified.played, [difference.fields for difference in verified.differences], first.version_of("open_drawer"))
    return compare(first, read_results(folder / "other.json"), np.random.default_rng(0))


def version(name: str) -> int:
    """Return the version of a task."""
    task = find_task(name)
    assert_type(task, type[Task])
    scene = task_scene(task)
    assert_type(scene, SceneSpec)
    return scene.version


if __name__ == "__main__":
    print(rlbench_pin.__version__, rlbench_pin.task_names(), version("open_drawer"), play(HoldStill()))
