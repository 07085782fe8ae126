"""Someone who has read the paper: an agent swallows two demonstrations, then acts and starts over every so many steps."""

import numpy as np

from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig
from rlbench.tasks import ReachTarget

TRAINING_STEPS = 60
EPISODE_LENGTH = 20


class Agent(object):
    def __init__(self, action_shape):
        self.action_shape = action_shape
        self.frames = []

    def ingest(self, demos):
        for demo in demos:
            self.frames.extend(demo)

    def act(self, obs):
        arm = np.random.normal(0.0, 0.1, size=(self.action_shape[0] - 1,))
        gripper = [1.0]  # always open
        return np.concatenate([arm, gripper], axis=-1)


np.random.seed(0)
obs_config = ObservationConfig()
obs_config.set_all(True)
action_mode = MoveArmThenGripper(arm_action_mode=JointVelocity(), gripper_action_mode=Discrete())
env = Environment(action_mode, "", obs_config, True)
env.launch()

task = env.get_task(ReachTarget)
demos = task.get_demos(2, live_demos=True)
agent = Agent(env.action_shape)
agent.ingest(demos)
assert env.action_shape == (8,), env.action_shape
assert len(agent.frames) == len(demos[0]) + len(demos[1]) > 40

resets = 0
obs = None
start = None
for i in range(TRAINING_STEPS):
    if i % EPISODE_LENGTH == 0:
        descriptions, obs = task.reset()
        start = obs.joint_positions
        resets += 1
        print(descriptions[0])
        assert isinstance(descriptions[0], str)
    obs, reward, terminate = task.step(agent.act(obs))
    assert reward in (0.0, 1.0) and terminate in (False, True)
    assert obs.front_rgb.shape == (128, 128, 3) and obs.front_rgb.dtype == np.uint8

assert resets == 3
assert np.abs(obs.joint_positions - start).max() > 0.01, "the arm has not moved"
print("ingested", len(agent.frames), "frames; acted", TRAINING_STEPS, "steps")
env.shutdown()
