"""The classical baseline: it finds the objects of the instruction in the images and executes a recipe of skills."""

from __future__ import annotations

import numpy as np

from rlbench_pin.baselines.classical.recipes import Instruction, find_recipe
from rlbench_pin.baselines.classical.skills import Driver, Gripper, Moves, NothingFound
from rlbench_pin.baselines.perception import CAMERAS
from rlbench_pin.environment.actions.modes import Discrete, JointVelocity, MoveArmThenGripper
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.observation import Observation
from rlbench_pin.robot import RobotModel, robot_description

TRIES = 3
"""Number of attempts."""
PAUSE = 10
"""Time to wait for success after an attempt [ticks]."""
MAX_TICKS = 800
"""Suggested length of an episode [ticks]: three attempts."""
IMAGE_SIZE = (256, 256)
"""Width and height of the images [px]."""


class ClassicalPolicy:
    """A policy from geometry only, on colours and depth of the five cameras.

    It uses the model of the arm, the models of the objects, and the instruction. It plans motions around the
    detected obstacles, and its controllers convert them to joint velocities, one action per tick.

    Attributes:
        action_mode: Joint velocities for a tick, and an open or closed gripper.
        max_steps: Suggested length of an episode [ticks].
        obs_config: Colours and depth, joint and finger positions.
    """

    def __init__(self) -> None:
        """Prepare for episodes."""
        self.action_mode = MoveArmThenGripper(JointVelocity(), Discrete())
        self.obs_config = observation_config()
        self.max_steps = MAX_TICKS
        self._drivers: dict[tuple[str, float], Driver] = {}
        self._driver: Driver | None = None
        self._instruction, self._rng = Instruction(()), np.random.default_rng(0)
        self._moves: Moves | None = None

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Start an episode."""
        key = context.robot, context.control_period
        if key not in self._drivers:
            self._drivers[key] = Driver(RobotModel(robot_description(context.robot)), context.control_period)
        self._driver, self._moves = self._drivers[key], None
        self._instruction, self._rng = Instruction.read(instruction), np.random.default_rng(context.seed)

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action (8,): joint velocities [rad/s], then 1 for an open gripper and 0 for a closed one."""
        if self._moves is None:
            assert self._driver is not None, "call `reset` before `act`"
            self._moves = _episode(Gripper(self._driver, observation, self._rng), self._instruction)
            tick = next(self._moves)
        else:
            tick = self._moves.send(observation)
        return np.append(tick.velocity, float(tick.is_open))


def _episode(gripper: Gripper, asked: Instruction) -> Moves:
    """Follow the recipe; without success move home and retry, `TRIES` times in total, then hold the position."""
    for _ in range(TRIES):
        try:
            yield from find_recipe(asked)(gripper, asked)
            yield from gripper.rest(PAUSE)
            yield from gripper.grip(True)
            yield from gripper.go_home()
        except NothingFound:
            yield from gripper.rest(PAUSE)
    while True:
        yield from gripper.rest(1)


def observation_config() -> ObservationConfig:
    """Return the observation settings of the policy: only data that a real robot can measure."""
    config = ObservationConfig(joint_poses=False)
    config.set_all(False)
    for name in CAMERAS:
        camera = config.camera(name)
        camera.rgb = camera.depth = camera.depth_in_meters = True
        camera.image_size = IMAGE_SIZE
    config.joint_positions = config.gripper_joint_positions = config.gripper_pose = config.gripper_open = True
    return config


def policy() -> ClassicalPolicy:
    """Return the classical baseline."""
    return ClassicalPolicy()
