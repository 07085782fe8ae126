"""An environment and a scene for tests of the layer."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.scene import Scene
from rlbench.environment import Environment
from rlbench.observation_config import ObservationConfig
from rlbench.tasks import ReachTarget


def launched() -> Iterator[Environment]:
    """Yield a launched environment without pictures, and shut it down."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    environment = Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, headless=True)
    environment.launch()
    yield environment
    environment.shutdown()


def fresh_scene(environment: Environment) -> Scene:
    """Return the scene of a fresh episode."""
    np.random.seed(1)
    task = environment.get_task(ReachTarget)
    task.reset()
    scene: Scene = task._scene
    return scene
