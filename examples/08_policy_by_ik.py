"""A policy that returns tip velocities, through gymnasium: `python 08_policy_by_ik.py --task pick_and_lift --seeds 0 20`.

observation -> goal of the tip -> velocity of the tip -> `DifferentialIK` -> joint velocities -> `env.step`

What to look for: the policy has no memory and uses only the observation; the controller keeps the limits of all joints,
so that the policy does not need them; the three tasks differ only in the function that returns the goal of the tip.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import gymnasium
import numpy as np

from rlbench_pin import Discrete, JointVelocity, MoveArmThenGripper
from rlbench_pin.control import DifferentialIK
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.spatial import FloatArray, relative

OPEN, CLOSED = 1.0, 0.0
ABOVE = 0.1  # height from which the gripper goes straight down [m]
SIDEWAYS, NEAR = 0.008, 0.008  # horizontal distance, and distance, that count as there [m]
GAIN = 3.0  # share of the way to cover per second [1/s]
FASTEST = np.array([0.25, 1.0])  # of the tip [m/s, rad/s]
STEPS = 400

Observation = dict[str, FloatArray]
Goal = tuple[FloatArray, float]  # where the tip should be (3,) [m], and the gripper


def touch(observation: Observation) -> Goal:
    """Return the goal of reach_target, whose state is the position of the ball."""
    return observation["task_low_dim_state"], OPEN


def push(observation: Observation) -> Goal:
    """Return the goal of push_button, whose state is the pose of the button. The closed gripper presses the cap from above."""
    return from_above(observation, observation["task_low_dim_state"][:3] + [0.0, 0.0, 0.045]), CLOSED


def pick(observation: Observation) -> Goal:
    """Return the goal of pick_and_lift, whose state is block and marker positions; once grasped, the goal is the marker."""
    block, marker = observation["task_low_dim_state"].reshape(2, 3)
    if np.linalg.norm(block - observation["gripper_pose"][:3]) > NEAR:
        return from_above(observation, block), OPEN
    is_grasped = observation["gripper_open"].item() < 0.5
    return (marker if is_grasped else block), CLOSED


def from_above(observation: Observation, place: FloatArray) -> FloatArray:
    """Return `place` (3,) if the tip is directly above it, otherwise a point above it [m]."""
    sideways = np.linalg.norm(place[:2] - observation["gripper_pose"][:2])
    return place if sideways < SIDEWAYS else place + [0.0, 0.0, ABOVE]


TASKS: dict[str, Callable[[Observation], Goal]] = {"reach_target": touch, "push_button": push, "pick_and_lift": pick}


def twist_to(place: FloatArray, tip: FloatArray) -> FloatArray:
    """Return the twist (6,) in tip axes that moves the tip to `place` (3,) with the gripper pointing down.

    Args:
        place: Target position of the tip [m].
        tip: Pose of the tip (7,).
    """
    error = relative([*place, 0.0, 1.0, 0.0, 0.0], tip)  # pose of the goal, seen from the tip
    linear, angular = GAIN * error[:3], GAIN * 2.0 * error[3:6]  # a small rotation is twice the vector of its quaternion
    slower = np.maximum(1.0, np.array([np.linalg.norm(linear), np.linalg.norm(angular)]) / FASTEST)
    return np.concatenate([linear / slower[0], angular / slower[1]])


def play(env: gymnasium.Env, controller: DifferentialIK, goal: Callable[[Observation], Goal], seed: int) -> tuple[bool, int]:
    """Play one episode; return its success and its number of steps."""
    observation, info = env.reset(seed=seed)
    for step in range(STEPS):
        place, gripper = goal(observation)
        twist = twist_to(place, observation["gripper_pose"])
        q, v = observation["joint_positions"], observation["joint_velocities"]
        velocity = controller.velocity_for_twist(q, v, twist, frame="tip")
        observation, _, terminated, truncated, info = env.step(np.append(velocity, gripper))
        if terminated or truncated:
            return info["success"], step + 1
    return False, STEPS


def main() -> None:
    """Play the seeds of the command line, one episode each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--task", choices=TASKS, default="reach_target")
    parser.add_argument("--seeds", nargs=2, type=int, default=[0, 3], metavar=("FIRST", "END"), help="seeds FIRST to END - 1")
    asked = parser.parse_args()
    controller = DifferentialIK(RobotModel(robot_description("panda")))
    env = gymnasium.make(
        f"rlbench_pin.gym:rlbench_pin/{asked.task}-state-v0",
        max_episode_steps=STEPS,
        action_mode=MoveArmThenGripper(JointVelocity(), Discrete()),
    )
    results = []
    for seed in range(*asked.seeds):
        results.append(play(env, controller, TASKS[asked.task], seed))
        print(f"seed {seed}: {'solved' if results[-1][0] else 'FAILED'} after {results[-1][1]} steps")
    env.close()
    print(f"{asked.task}: solved {sum(success for success, _ in results)} of {len(results)}")


if __name__ == "__main__":
    main()
