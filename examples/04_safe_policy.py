"""A policy that drives into the table, with and without the safety filter.

What to look for: `SafeArm` wraps the action mode, not the policy. The same actions end a centimetre above the table instead of
in it, and the filter reports how often and why it changed them. The image shows both arms at the end, the unfiltered arm left.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from PIL import Image

from rlbench_pin import Discrete, Environment, JointVelocity, MoveArmThenGripper, ObservationConfig, SafeArm

STEPS = 100
IMAGE_FILE = "safe_policy.png"


@dataclass
class Fall:
    """Result of one run."""

    touched: set[str]
    deepest: float
    """Largest penetration of the table by the arm [m]."""
    lowest: float
    """Lowest height of the tip [m]."""
    image: np.ndarray


def policy() -> Iterator[np.ndarray]:
    """Lower the shoulder and stretch the elbow, without use of the observation; swing sideways."""
    for step in range(STEPS):
        action = np.zeros(8)
        action[0], action[1], action[3], action[7] = 0.4 * np.sin(0.1 * step), 0.8, -0.4, 1.0
        yield action


def run(arm: JointVelocity | SafeArm) -> Fall:
    """Run the policy and measure contacts with the table."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.front_camera.rgb, config.front_camera.image_size = True, (256, 256)
    with Environment(MoveArmThenGripper(arm, Discrete()), obs_config=config) as env:
        task = env.get_task("reach_target")
        _, obs = task.reset(seed=0)
        touched, deepest, lowest = set[str](), 0.0, np.inf
        for action in policy():
            obs, _, _ = task.step(action)
            contacts = task.world.contacts("panda", "table")
            touched |= set(task.runtime.touching())
            deepest = max([deepest, *(-contact.distance for contact in contacts)])
            lowest = min(lowest, float(obs.gripper_pose[2]))
        return Fall(touched, deepest, lowest, obs.front_rgb)


def main() -> None:
    """Run the policy twice and draw both final states side by side."""
    guarded = SafeArm(JointVelocity())
    falls = {"without": run(JointVelocity()), "with": run(guarded)}
    for name, fall in falls.items():
        contact, depth = ", ".join(sorted(fall.touched)) or "nothing", f"{1000 * fall.deepest:.2f} mm deep at most"
        print(f"{name:>7} the filter: touched {contact}, {depth}; tip never below {fall.lowest:.3f} m")
    counts = guarded.counts
    print(f"the filter changed {counts.interventions} of {counts.ticks} commands: {counts.reasons}")
    print(f"the last one: {guarded.last}")
    Image.fromarray(np.hstack([fall.image for fall in falls.values()])).save(IMAGE_FILE)
    print(f"both arms at the end: {IMAGE_FILE}")


if __name__ == "__main__":
    main()
