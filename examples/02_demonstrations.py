"""Demonstrations: plan them, store them, read them back, replay them.

What to look for: demo i of `get_demos(..., seed=s)` belongs to seed s + i and is the same in every process; what is read back
equals what was written; `reset_to_demo` restores the very start, so the recorded joint-position actions succeed again.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rlbench_pin import Discrete, Environment, JointPosition, MoveArmThenGripper, ObservationConfig
from rlbench_pin.datasets import DatasetWriter, read_demo

ROOT = Path("out/examples/dataset")


def main() -> None:
    """Two demonstrations of lifting a block, there and back."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config) as env:
        task = env.get_task("pick_and_lift")
        demos = task.get_demos(2, live_demos=True, seed=0)
        for demo in demos:
            path = DatasetWriter(ROOT).add(demo)
            again = read_demo(path)
            equal = all(np.array_equal(a.joint_positions, b.joint_positions) for a, b in zip(demo, again))
            print(f"seed {demo.random_seed}: {len(demo)} frames, {demo.instructions[0]!r}, in {path}, read back equal: {equal}")

        task.reset_to_demo(demos[0])
        for obs in demos[0][1:]:
            _, reward, terminate = task.step(obs.misc["joint_position_action"])
            if terminate:
                break
        print("Replaying the recorded actions gives reward", reward)


if __name__ == "__main__":
    main()
