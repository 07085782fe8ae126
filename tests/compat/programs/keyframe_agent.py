"""Evaluation of a keyframe agent in the nine-value dialect: stored demonstrations of all variations, reset to, poses played."""

import sys
import tempfile

import numpy as np
from pyrep.errors import ConfigurationPathError, IKError

from rlbench import dataset_generator
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import EndEffectorPoseViaPlanning
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.exceptions import InvalidActionError
from rlbench.backend.observation import Observation
from rlbench.backend.utils import task_file_to_task_class
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig

EPISODES = 2
MAX_STEPS = 25


class KeyframePolicy:
    """Stands for the network: knows the key frames of the demonstration that the episode was reset to."""

    def __init__(self, demo):
        self.targets, previous, stopped = [], demo[0].gripper_open, 0
        for i, obs in enumerate(demo):
            still = np.allclose(obs.joint_velocities, 0, atol=0.1) and 2 <= i < len(demo) - 2
            stop = stopped <= 0 and still and all(demo[j].gripper_open == obs.gripper_open for j in (i - 2, i - 1, i + 1))
            stopped = 4 if stop else stopped - 1
            if i > 0 and (obs.gripper_open != previous or i == len(demo) - 1 or stop):
                self.targets.append(obs)
            previous = obs.gripper_open

    def act(self, step):
        obs = self.targets[min(step, len(self.targets) - 1)]
        quaternion = obs.gripper_pose[3:] / np.linalg.norm(obs.gripper_pose[3:])
        ignore_collisions = 1.0 if obs.ignore_collisions is None else float(obs.ignore_collisions)
        return np.concatenate([obs.gripper_pose[:3], quaternion, [float(obs.gripper_open)], [ignore_collisions]])


def rollout(env, task, episode):
    task.set_variation(-1)
    demo = task.get_demos(1, live_demos=False, random_selection=False, from_episode_number=episode)[0]
    variation = demo.variation_number
    task.set_variation(variation)
    descriptions, obs = task.reset_to_demo(demo)
    assert isinstance(obs, Observation)
    assert np.allclose(obs.task_low_dim_state, demo[0].task_low_dim_state, atol=1e-3), "not the scene of the demonstration"
    goal = env.get_task_descriptions_with_episode(task.get_name(), episode)[0]
    assert goal in descriptions, (goal, descriptions)
    policy, reward = KeyframePolicy(demo), 0.0
    for step in range(MAX_STEPS):
        action = policy.act(step)
        assert action.shape == (9,)
        try:
            obs, reward, terminal = task.step(action)
        except (IKError, ConfigurationPathError, InvalidActionError) as error:
            print("step", step, "refused:", error)
            terminal, reward = True, 0.0
        if terminal or step >= len(policy.targets) + 2:
            break
    print(
        "%s, episode %d, variation %d: %s -> %.0f after %d keyframes"
        % (task.get_name(), episode, variation, goal, reward, step + 1)
    )
    return reward


def main():
    np.random.seed(2)
    with tempfile.TemporaryDirectory() as root:
        sys.argv = [
            "generate",
            "--save_path=" + root,
            "--tasks=push_button,open_drawer",
            "--image_size=32,32",
            "--episodes_per_task=%d" % EPISODES,
            "--processes=1",
            "--all_variations=True",
            "--seed=1",
        ]
        dataset_generator.main()
        obs_config = ObservationConfig()
        obs_config.set_all_high_dim(False)
        obs_config.set_all_low_dim(True)
        obs_config.front_camera.set_all(True)
        obs_config.front_camera.image_size = (32, 32)
        action_mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
        env = Environment(action_mode=action_mode, dataset_root=root, obs_config=obs_config, headless=True)
        env.launch()
        scores = []
        for name in ("push_button", "open_drawer"):
            task = env.get_task(task_file_to_task_class(name + ".py"))
            scores += [rollout(env, task, episode) for episode in range(EPISODES)]
        env.shutdown()
    print("success %d of %d" % (sum(scores), len(scores)))
    assert sum(scores) >= len(scores) - 1


if __name__ == "__main__":
    main()
