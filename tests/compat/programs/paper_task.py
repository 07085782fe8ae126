"""Someone who writes the paper's example of a task, the lid of the saucepan; the scene lies beside it in take_lid_off.toml."""

from typing import List

import numpy as np
from pyrep.objects.proximity_sensor import ProximitySensor
from pyrep.objects.shape import Shape

from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointPosition
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.conditions import DetectedCondition, GraspedCondition
from rlbench.backend.task import Task
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig


class TakeLidOff(Task):
    def init_task(self) -> None:
        self.lid = Shape("saucepan_lid")
        success_detector = ProximitySensor("success")
        self.register_graspable_objects([self.lid])
        self.register_success_conditions(
            [
                GraspedCondition(self.robot.gripper, self.lid),
                DetectedCondition(self.lid, success_detector),
            ]
        )

    def init_episode(self, index: int) -> List[str]:
        return ["take the lid off the saucepan", "remove the lid from the pan"]

    def variation_count(self) -> int:
        return 1


def main():
    obs_config = ObservationConfig()
    obs_config.set_all_low_dim(True)
    obs_config.set_all_high_dim(False)
    env = Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=obs_config, headless=True)
    env.launch()
    task = env.get_task(TakeLidOff)
    assert task.get_name() == "take_lid_off", task.get_name()
    assert task.variation_count() == 1

    descriptions, obs = task.reset()
    print(descriptions)
    assert descriptions == ["take the lid off the saucepan", "remove the lid from the pan"]
    lid = Shape("saucepan_lid")
    height = lid.get_position()[2]
    places = [lid.get_position()[:2]]
    task.reset()
    places.append(lid.get_position()[:2])
    assert np.abs(places[0] - places[1]).max() > 1e-3, "the task is not placed anew"

    demos = task.get_demos(2, live_demos=True)
    for demo in demos:
        assert demo[0].gripper_open == 1.0 and demo[-1].gripper_open == 0.0
        assert len(demo[0].task_low_dim_state) == len(demo[-1].task_low_dim_state) > 0
    raised = lid.get_position()[2] - height
    assert raised > 0.08, raised

    task.reset_to_demo(demos[0])
    reward = 0.0
    for frame in demos[0][1:]:
        obs, reward, terminate = task.step(frame.misc["joint_position_action"])
        if terminate:
            break
    assert reward == 1.0, "the demonstration's actions do not take the lid off again"
    print("lid raised by %.2f m; %s frames; replay reward %.1f" % (raised, [len(d) for d in demos], reward))
    env.shutdown()


if __name__ == "__main__":
    main()
