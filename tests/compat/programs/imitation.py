"""Someone who clones behaviour: live demonstrations, a small network in numpy from the front image to joint velocities."""

import numpy as np

from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.environment import Environment
from rlbench.noise_model import GaussianNoise
from rlbench.observation_config import ObservationConfig
from rlbench.tasks import ReachTarget


class ImitationLearning(object):
    """Two layers, squared error, gradient descent."""

    def __init__(self, inputs, outputs, hidden=32, seed=0):
        random = np.random.RandomState(seed)
        self.first = random.normal(0.0, 1.0 / np.sqrt(inputs), (inputs, hidden))
        self.second = random.normal(0.0, 1.0 / np.sqrt(hidden), (hidden, outputs))

    def predict(self, x):
        return np.tanh(x @ self.first) @ self.second

    def fit_step(self, x, y, rate=0.02):
        hidden = np.tanh(x @ self.first)
        error = hidden @ self.second - y
        gradient = (error @ self.second.T) * (1.0 - hidden**2)
        self.second -= rate * hidden.T @ error / len(x)
        self.first -= rate * x.T @ gradient / len(x)
        return float((error**2).mean())


def features(observation):
    image = observation.front_rgb.astype(np.float64).mean(axis=2)[::4, ::4].ravel() / 255.0 - 0.5
    return np.concatenate([image, observation.joint_positions, [1.0]])


def main():
    np.random.seed(7)
    obs_config = ObservationConfig(joint_velocities_noise=GaussianNoise(0.001))
    obs_config.set_all(False)
    obs_config.front_camera.rgb = True
    obs_config.front_camera.image_size = (64, 64)
    obs_config.joint_velocities = True
    obs_config.joint_positions = True
    obs_config.gripper_open = True

    env = Environment(action_mode=MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=obs_config, headless=True)
    env.launch()
    task = env.get_task(ReachTarget)
    task.set_variation(3)
    steps = []
    demos = task.get_demos(3, live_demos=True, callable_each_step=steps.append)
    assert len(steps) >= sum(len(demo) for demo in demos)
    demos = np.array([list(demo) for demo in demos], dtype=object) if len({len(d) for d in demos}) == 1 else demos
    frames = [obs for demo in demos for obs in demo]
    assert frames[0].front_depth is None and frames[0].gripper_pose is None

    x = np.array([features(obs) for obs in frames[:-1]])
    y = np.array([obs.joint_velocities for obs in frames[1:]])
    learner = ImitationLearning(x.shape[1], y.shape[1])
    losses = [learner.fit_step(x, y) for _ in range(800)]
    assert losses[-1] < 0.7 * losses[0], (losses[0], losses[-1])

    descriptions, obs = task.reset()
    start = obs.joint_positions
    for _ in range(20):
        action = learner.predict(features(obs)[None])[0]
        obs, reward, terminate = task.step(np.concatenate([np.clip(action, -1.0, 1.0), [1.0]]))
        if terminate:
            break
    travelled = np.linalg.norm(obs.joint_positions - start)
    assert travelled > 0.02, travelled
    print("cloned %d frames: loss %.4f -> %.4f, then moved %.2f rad" % (len(frames), losses[0], losses[-1], travelled))
    env.shutdown()


if __name__ == "__main__":
    main()
