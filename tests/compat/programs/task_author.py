"""Someone who writes a task: colours as variations, items scattered by SpawnBoundary, own state and reward, waypoint abilities.

The scene lies beside it in drop_in_zone.toml.
"""

from typing import List, Tuple

import numpy as np
from pyrep.objects.dummy import Dummy
from pyrep.objects.proximity_sensor import ProximitySensor
from pyrep.objects.shape import Shape

from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointPosition
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.conditions import ConditionSet, DetectedCondition, NothingGrasped
from rlbench.backend.spawn_boundary import SpawnBoundary
from rlbench.backend.task import Task
from rlbench.const import colors
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig

ITEMS = 3


class DropInZone(Task):
    def init_task(self) -> None:
        self.items = [Shape("item%d" % i) for i in range(ITEMS)]
        self.zone = Shape("zone")
        self.boundary = SpawnBoundary([Shape("boundary")])
        self.register_graspable_objects(self.items)
        self.success_sensor = ProximitySensor("success")
        self.register_waypoint_ability_start(0, self._approach)
        self.register_waypoint_ability_end(4, self._arrived)
        self.visited = []
        self.steps = 0

    def init_episode(self, index: int) -> List[str]:
        name, rgb = colors[index]
        self.steps = 0
        self.visited = []
        others = np.random.choice([i for i in range(len(colors)) if i != index], size=ITEMS - 1, replace=False)
        self.boundary.clear()
        for item, color in zip(self.items, [rgb] + [colors[i][1] for i in others]):
            item.set_color(color)
            self.boundary.sample(item, min_rotation=(0, 0, -np.pi / 4), max_rotation=(0, 0, np.pi / 4), min_distance=0.09)
        self.register_success_conditions(
            [ConditionSet([DetectedCondition(self.items[0], self.success_sensor), NothingGrasped(self.robot.gripper)])]
        )
        return ["drop the %s block in the zone" % name, "put the %s item where the square is" % name]

    def variation_count(self) -> int:
        return len(colors)

    def base_rotation_bounds(self) -> Tuple[Tuple[float, float, float], Tuple[float, float, float]]:
        return (0.0, 0.0, -np.pi / 6), (0.0, 0.0, np.pi / 6)

    def step(self) -> None:
        self.steps += 1

    def reward(self) -> float:
        return -float(np.linalg.norm(self.items[0].get_position() - self.zone.get_position()))

    def get_low_dim_state(self) -> np.ndarray:
        return np.concatenate([item.get_position() for item in self.items] + [self.zone.get_position()])

    def _approach(self, waypoint):
        self.visited.append(waypoint.get_waypoint_object().get_name())

    def _arrived(self, waypoint):
        self.visited.append("end")


def main():
    np.random.seed(8)
    obs_config = ObservationConfig()
    obs_config.set_all_high_dim(False)
    obs_config.task_low_dim_state = True
    obs_config.front_camera.rgb = True
    obs_config.front_camera.image_size = (64, 64)
    env = Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=obs_config, headless=True, shaped_rewards=True)
    env.launch()
    env_task = env.get_task(DropInZone)
    task = env_task._task
    assert env_task.variation_count() == 20

    colours, layouts = [], []
    for variation in (0, 4):
        env_task.set_variation(variation)
        descriptions, obs = env_task.reset()
        assert colors[variation][0] in descriptions[0], descriptions
        assert np.allclose(Shape("item0").get_color(), colors[variation][1], atol=1e-3), Shape("item0").get_color()
        colours.append(obs.front_rgb)
        layouts.append(obs.task_low_dim_state)
        positions = obs.task_low_dim_state.reshape(ITEMS + 1, 3)
        gaps = [np.linalg.norm(positions[i, :2] - positions[j, :2]) for i in range(ITEMS) for j in range(i)]
        assert min(gaps) > 0.045, gaps
    assert obs.task_low_dim_state.shape == (12,)
    assert np.abs(layouts[0] - layouts[1]).max() > 0.01
    assert abs(task.get_base().get_orientation()[2]) <= task.base_rotation_bounds()[1][2] + 1e-6
    obs, reward, terminate = env_task.step(np.append(obs.joint_positions, 1.0))
    assert reward < 0.0 and not terminate, (reward, terminate)
    assert task.steps > 0, "step() of the task is not called"

    demo = env_task.get_demos(1, live_demos=True)[0]
    assert task.visited == ["waypoint0", "end"], task.visited
    assert task.success() == (True, True)
    assert len(task.get_waypoints()) == 5 and Dummy("waypoint4").still_exists()
    distance = np.linalg.norm(Shape("item0").get_position()[:2] - Shape("zone").get_position()[:2])
    assert distance < 0.03, distance
    print("demonstration of %d frames; the item lies %.0f mm from the middle of the zone" % (len(demo), 1000 * distance))
    env.shutdown()


if __name__ == "__main__":
    main()
