"""The policy of behaviour cloning: it predicts a chunk of commands at each tick, and averages the chunks for the current tick."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from rlbench_pin.baselines.cloning.model import IMAGE_SIZE, SECONDS, ChunkNetwork, encode_sentence, images_of, nearest_sentence
from rlbench_pin.baselines.cloning.training import KIND, as_images, load_cloning, trained_joints, trained_tasks
from rlbench_pin.environment import Discrete, JointPosition, MoveArmThenGripper, ObservationConfig, image_config, low_dim_config
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray

FADE = 0.1
"""Rate [1/tick] at which the weight of older chunks decays; 0 weights all chunks equally."""


class CloningPolicy:
    """Joint commands learned from demonstrations; the instruction selects the network of a task.

    Args:
        folder: Output folder of `rlbench-pin train cloning`.
        device: Device of torch.
    """

    def __init__(self, folder: str | Path, device: str = "cpu") -> None:
        """Read the settings in the folder; networks are loaded at their first use."""
        self._folder, self._device = Path(folder), device
        trained = trained_tasks(self._folder, KIND)
        self._instructions = {task: list(s["instructions"]) for task, s in trained.items()}
        self.joint_names = trained_joints(self._folder, trained)
        cameras = {c for s in trained.values() for c in s["sizes"]["cameras"]}
        self.action_mode = MoveArmThenGripper(JointPosition(), Discrete())
        self.obs_config = _observation(tuple(sorted(cameras)))
        self._networks: dict[str, tuple[ChunkNetwork, float]] = {}
        self._chunks: list[tuple[FloatArray, FloatArray]] = []
        self._sentence, self._tick, self._task = encode_sentence(""), 0, next(iter(self._instructions))

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Select the network whose demonstrations have the instruction most similar to this one."""
        owners = [(task, sentence) for task, sentences in self._instructions.items() for sentence in sentences]
        self._task = owners[nearest_sentence(instruction, [sentence for _, sentence in owners])][0]
        if self._task not in self._networks:
            self._networks[self._task] = load_cloning(self._folder / self._task, self._device)
        self._sentence, self._tick, self._chunks = encode_sentence(instruction), 0, []

    def act(self, observation: Observation) -> np.ndarray:
        """Predict a chunk and return the weighted mean of the last chunks for this tick, shape (8,)."""
        network, longest = self._networks[self._task]
        joints, gripper = self._predict(network, longest, observation)
        self._chunks = [(joints, gripper), *self._chunks][: len(gripper)]
        self._tick += 1
        weights = np.exp(-FADE * np.arange(len(self._chunks)))
        weights /= weights.sum()
        arm = sum(w * chunk[age] for age, (w, (chunk, _)) in enumerate(zip(weights, self._chunks)))
        grip = sum(w * opening[age] for age, (w, (_, opening)) in enumerate(zip(weights, self._chunks)))
        return np.append(arm, float(grip > 0.5))

    def _predict(self, network: ChunkNetwork, longest: float, observation: Observation) -> tuple[FloatArray, FloatArray]:
        """Return joint commands (chunk, joints) [rad] and probabilities of an open gripper (chunk,)."""
        sizes = network.sizes
        joints = np.asarray(observation.joint_positions, dtype=float)
        state = np.asarray(observation.task_low_dim_state, dtype=float) if not sizes.cameras else np.zeros(0)
        numbers = np.r_[joints, float(observation.gripper_open or 0.0), min(self._tick * SECONDS, longest), state]
        images = as_images(images_of(observation, sizes.cameras)[None], torch.device(self._device))
        rows = [torch.as_tensor(v[None], dtype=torch.float32, device=self._device) for v in (numbers, self._sentence)]
        with torch.no_grad():
            steps, gripper = network(rows[0], rows[1], images)
        return joints + steps[0].double().cpu().numpy(), gripper[0].sigmoid().double().cpu().numpy()


def policy(folder: str, device: str = "cpu") -> CloningPolicy:
    """Return the policy in a folder that `rlbench-pin train cloning` wrote."""
    return CloningPolicy(folder, device)


def _observation(cameras: tuple[str, ...]) -> ObservationConfig:
    """Return the observation settings: joints, gripper, task state, and for images the colours of some cameras."""
    if not cameras:
        return low_dim_config()
    return image_config((2 * IMAGE_SIZE, 2 * IMAGE_SIZE), cameras, depth=False, mask=False)
