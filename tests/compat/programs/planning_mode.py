"""Someone who wants every frame between two poses: own planning mode that asks the arm for a path and walks it."""

import numpy as np
from pyrep.const import ConfigurationPathAlgorithms as Algos
from pyrep.errors import ConfigurationPathError

from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import (
    EndEffectorPoseViaPlanning,
    Scene,
    assert_action_shape,
    assert_unit_quaternion,
)
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.exceptions import InvalidActionError
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig
from rlbench.tasks import ReachTarget


class RecordingPlanning(EndEffectorPoseViaPlanning):
    """Remembers the observations on the way and does not stop early while it records."""

    def __init__(self, absolute_mode=True, collision_checking=False):
        super().__init__(absolute_mode=absolute_mode, collision_checking=collision_checking)
        self._callable_each_step = None
        self.lengths = []

    def set_callable_each_step(self, function):
        self._callable_each_step = function

    def _path(self, scene, action, ignore_collisions):
        arm = scene.robot.arm
        try:
            return arm.get_linear_path(action[:3], quaternion=action[3:], steps=50, ignore_collisions=ignore_collisions)
        except ConfigurationPathError:
            return arm.get_path(
                action[:3],
                quaternion=action[3:],
                ignore_collisions=ignore_collisions,
                trials=100,
                max_configs=10,
                max_time_ms=10,
                trials_per_goal=5,
                algorithm=Algos.RRTConnect,
            )

    def action(self, scene: Scene, action: np.ndarray, ignore_collisions: bool = True):
        assert_action_shape(action, (7,))
        assert_unit_quaternion(action[3:])
        if not scene.check_target_in_workspace(action[:3]):
            raise InvalidActionError("A path could not be found because the target is outside of workspace.")
        try:
            path = self._path(scene, action, not self._collision_checking)
        except ConfigurationPathError as error:
            raise InvalidActionError("A path could not be found.") from error
        count, done = 0, False
        while not done:
            done = path.step()
            scene.step()
            count += 1
            if self._callable_each_step is not None:
                self._callable_each_step(scene.get_observation())
            if self._callable_each_step is None and scene.task.success()[0]:
                break
        self.lengths.append(count)


def main():
    np.random.seed(3)
    obs_config = ObservationConfig()
    obs_config.set_all_high_dim(False)
    obs_config.task_low_dim_state = True
    mode = RecordingPlanning()
    env = Environment(MoveArmThenGripper(mode, Discrete()), obs_config=obs_config, headless=True)
    env.launch()
    task = env.get_task(ReachTarget)
    rewards = []
    for _ in range(2):
        _, obs = task.reset()
        tips = []
        mode.set_callable_each_step(lambda o: tips.append(o.gripper_pose))
        target = np.concatenate([obs.task_low_dim_state[:3], obs.gripper_pose[3:], [1.0]])
        obs, reward, terminate = task.step(target)
        rewards.append(reward)
        error = np.linalg.norm(obs.gripper_pose[:3] - target[:3])
        assert error < 0.01, error
        assert len(tips) == mode.lengths[-1] > 10
        steps = np.linalg.norm(np.diff(np.array(tips)[:, :3], axis=0), axis=1)
        assert steps.max() < 0.1, "the arm jumps"
    assert rewards == [1.0, 1.0] and terminate

    outside = np.array([2.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0])
    for bad in (outside, np.append(target[:3], [1.0, 1.0, 0.0, 0.0, 1.0])):
        before = task.get_observation().joint_positions
        try:
            task.step(bad)
        except InvalidActionError as error:
            print("refused as it should be:", error)
        else:
            raise AssertionError("a bad pose was accepted")
        assert np.allclose(task.get_observation().joint_positions, before, atol=1e-3)
    print("walked paths of", mode.lengths, "steps")
    env.shutdown()


if __name__ == "__main__":
    main()
