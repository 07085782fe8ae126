"""The classical baseline: it looks, recognises what the instruction names, and plays the skills of a recipe."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment.actions.action_mode import MoveArmThenGripper
from rlbench_pin.environment.actions.gripper import Discrete
from rlbench_pin.environment.actions.pose import EndEffectorPoseViaPlanning
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.evaluation.baselines.classical.errors import NothingFound
from rlbench_pin.evaluation.baselines.classical.instruction import Instruction
from rlbench_pin.evaluation.baselines.classical.perception.cloud import CAMERAS
from rlbench_pin.evaluation.baselines.classical.recipes import find_recipe
from rlbench_pin.evaluation.baselines.classical.skills import Hand, Move, Moves
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.observation import Observation
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.spatial import FloatArray

PICTURE = (256, 256)
"""Width and height of the pictures it asks for [px]."""


class ClassicalPolicy:
    """Acts by geometry alone, on colours and depth of the five cameras.

    It knows the arm, the models of the objects, and the sentence. An action is a tip pose and what the fingers do there.

    Attributes:
        action_mode: A tip pose per action, and the hand open or shut.
        obs_config: Colours and depth, joint and finger positions.
    """

    def __init__(self) -> None:
        """Prepare for episodes."""
        self.action_mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
        self.obs_config = observation_config()
        self._arm: RobotModel | None = None
        self._instruction, self._rng = Instruction(()), np.random.default_rng(0)
        self._moves: Moves | None = None
        self._last: FloatArray | None = None

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode."""
        if self._arm is None or self._arm.description.name != context.robot:
            self._arm = RobotModel(robot_description(context.robot))
        self._instruction, self._rng = Instruction.read(instruction), np.random.default_rng(context.seed)
        self._moves, self._last = None, None

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action (8,): tip pose, then 1 for an open hand and 0 for a closed one."""
        try:
            move = self._start(observation) if self._moves is None else self._moves.send(observation)
        except (StopIteration, NothingFound):
            move = None
        if move is not None:
            self._last = np.append(move.pose, float(move.is_open))
        elif self._last is None:
            self._last = np.append(np.asarray(observation.gripper_pose), 1.0)
        return self._last.copy()

    def _start(self, observation: Observation) -> Move:
        """Choose the recipe and return its first move."""
        assert self._arm is not None, "reset comes first"
        hand = Hand(self._arm, observation, self._rng)
        self._moves = find_recipe(self._instruction)(hand, self._instruction)
        return next(self._moves)


def observation_config() -> ObservationConfig:
    """Return what the policy wants to see: nothing that a real robot would not know."""
    config = ObservationConfig(joint_poses=False)
    config.set_all(False)
    for name in CAMERAS:
        camera = config.camera(name)
        camera.rgb = camera.depth = camera.depth_in_meters = True
        camera.image_size = PICTURE
    config.joint_positions = config.gripper_joint_positions = config.gripper_pose = config.gripper_open = True
    return config


def policy() -> ClassicalPolicy:
    """Return the classical baseline."""
    return ClassicalPolicy()
