"""Someone who evaluates over task sets: few-shot training and test tasks, those that are not there yet left out."""

import numpy as np

from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.utils import task_file_to_task_class
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig
from rlbench.tasks import FS10_V1, MT15_V1, MT100_V1, ReachTarget
from rlbench.utils import name_to_task_class


class Agent(object):
    def __init__(self, action_size):
        self.action_size = action_size

    def act(self, obs):
        return np.append(np.random.uniform(-0.3, 0.3, self.action_size - 1), 1.0)


def evaluate(env, agent, task_class, steps=5):
    task = env.get_task(task_class)
    task.sample_variation()
    descriptions, obs = task.reset()
    total = 0.0
    for _ in range(steps):
        obs, reward, terminate = task.step(agent.act(obs))
        total += reward
        if terminate:
            break
    return task.get_name(), task.variation_count(), descriptions[0], total


def main():
    np.random.seed(10)
    train_tasks, test_tasks = FS10_V1["train"], FS10_V1["test"]
    assert len(train_tasks) == 10 and len(test_tasks) == 5
    assert train_tasks[0] is ReachTarget and len(MT15_V1["train"]) == 15 and len(MT100_V1["train"]) == 100
    assert name_to_task_class("reach_target") is ReachTarget is task_file_to_task_class("reach_target.py")
    obs_config = ObservationConfig()
    obs_config.set_all(False)
    obs_config.set_all_low_dim(True)
    env = Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=obs_config, headless=True)
    env.launch()
    agent = Agent(env.action_shape[0])
    played, missing = [], []
    for task_class in train_tasks + test_tasks:
        try:
            name, count, text, total = evaluate(env, agent, task_class)
        except NotImplementedError as error:
            missing.append(task_class.__name__)
            print("not there yet:", error)
            continue
        played.append(name)
        print("%-32s %3d variations, return %.1f  %s" % (name, count, total, text))
    env.shutdown()
    assert {"reach_target", "close_microwave", "pick_and_lift", "open_box"} <= set(played), played
    assert len(played) + len(missing) == 15
    print("played %d of 15 tasks" % len(played))


if __name__ == "__main__":
    main()
