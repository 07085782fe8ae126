"""The policy of key-frame cloning: a cloud in, the tip pose that most votes agree on out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from rlbench_pin.environment.presets import key_frame_mode
from rlbench_pin.evaluation.baselines.cloning.sentences import encode_sentence, nearest_sentence
from rlbench_pin.evaluation.baselines.cloning.storage import trained_tasks
from rlbench_pin.evaluation.baselines.key_frames.clouds import cloud_config, make_cloud
from rlbench_pin.evaluation.baselines.key_frames.learner import KIND, MIDDLE, context_row, load_key_frames
from rlbench_pin.evaluation.baselines.key_frames.network import POSITION_SCALE, ROTATION_SCALE, VoteNetwork, Votes
from rlbench_pin.evaluation.baselines.key_frames.poses import axes_of, pose_from
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray

CANDIDATES = 256
"""Votes of most weight among which the densest is looked for."""


class KeyFramePolicy:
    """Next tip pose from a point cloud; which of its networks acts is chosen by the instruction.

    Args:
        folder: What `rlbench-pin train key-frames` wrote.
        device: Where torch computes.
    """

    def __init__(self, folder: str | Path, device: str = "cpu") -> None:
        """Read what is in the folder; networks are loaded when their task comes up."""
        self._folder, self._device = Path(folder), torch.device(device)
        self._said = {task: list(s["instructions"]) for task, s in trained_tasks(self._folder, KIND).items()}
        self.action_mode, self.obs_config = key_frame_mode(), cloud_config()
        self._networks: dict[str, VoteNetwork] = {}
        self._sentence, self._step, self._task = encode_sentence(""), 0, next(iter(self._said))

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Choose the network whose demonstrations were told something nearest to the instruction."""
        owners = [(task, said) for task, all_said in self._said.items() for said in all_said]
        self._task = owners[nearest_sentence(instruction, [said for _, said in owners])][0]
        if self._task not in self._networks:
            self._networks[self._task] = load_key_frames(self._folder / self._task, str(self._device))
        self._sentence, self._step = encode_sentence(instruction), 0

    def act(self, observation: Observation) -> np.ndarray:
        """Return tip pose, opening and whether collisions are ignored, shape (9,)."""
        cloud, pose = make_cloud(observation), np.asarray(observation.gripper_pose, dtype=float)
        tip = pose[:3] - MIDDLE
        context = context_row(self._sentence, tip, axes_of(pose), float(observation.gripper_open or 0.0), self._step)
        with torch.no_grad():
            votes = self._networks[self._task](
                self._tensor(cloud.points - MIDDLE), self._tensor(cloud.colors),
                torch.as_tensor(cloud.neighbours[None], device=self._device), self._tensor(tip), self._tensor(context),
            )  # fmt: skip
        self._step += 1
        position, axes = agreed(votes)
        return np.concatenate([pose_from(position + MIDDLE, axes), (votes.hand[0] > 0.0).double().cpu().numpy()])

    def _tensor(self, values: FloatArray) -> torch.Tensor:
        return torch.as_tensor(values[None], dtype=torch.float32, device=self._device)


def agreed(votes: Votes) -> tuple[FloatArray, FloatArray]:
    """Return position (3,) and axes (6,) on which most votes of the first cloud agree.

    The vote at which the mixture is densest, then the weighted mean of those that lie near it, so that two clusters of votes
    are never averaged.
    """
    best = votes.weight[0].topk(min(CANDIDATES, votes.weight.shape[1])).indices
    weight, position, axes = (values[0, best].double() for values in (votes.weight, votes.position, votes.axes))
    far = (position[:, None] - position).abs().sum(-1) / POSITION_SCALE + (axes[:, None] - axes).abs().sum(-1) / ROTATION_SCALE
    densest = (weight - far).logsumexp(dim=1).argmax()
    share = (weight - far[densest]).softmax(dim=0)[:, None]
    return (share * position).sum(0).cpu().numpy(), (share * axes).sum(0).cpu().numpy()


def policy(folder: str, device: str = "cpu") -> KeyFramePolicy:
    """Return the policy in a folder that `rlbench-pin train key-frames` wrote."""
    return KeyFramePolicy(folder, device)
