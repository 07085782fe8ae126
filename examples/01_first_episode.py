"""A first episode: reset, observe, act, read the reward.

What to look for: `reset` returns instructions and an observation; `step` returns observation, reward and whether the episode has
ended; the same seed gives the same episode; images, depth and masks are plain arrays.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from rlbench_pin import Discrete, EndEffectorPoseViaPlanning, Environment, MoveArmThenGripper

OUT = Path("out/examples")


def main() -> None:
    """Reach for a target with two planned motions."""
    action_mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
    with Environment(action_mode) as env:
        task = env.get_task("reach_target")
        descriptions, obs = task.reset(seed=1)
        print("The task says:", descriptions[0])
        print("The tip is at", obs.gripper_pose[:3].round(3), "and the gripper is", "open" if obs.gripper_open else "closed")

        OUT.mkdir(parents=True, exist_ok=True)
        Image.fromarray(obs.front_rgb).save(OUT / "first_episode.png")
        print("The front camera sees", obs.front_rgb.shape, obs.front_rgb.dtype, "->", OUT / "first_episode.png")

        target = task.world.body("target").position
        for height in (0.10, 0.0):  # [m] above the target
            pose = np.concatenate([target + [0.0, 0.0, height], [0.0, 1.0, 0.0, 0.0]])  # the gripper points down
            obs, reward, terminate = task.step(np.append(pose, 1.0))
            print("Tip at", obs.gripper_pose[:3].round(3), "reward", reward, "ended", terminate)


if __name__ == "__main__":
    main()
