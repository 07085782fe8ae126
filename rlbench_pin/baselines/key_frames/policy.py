"""The policy of key-frame cloning: it returns the tip pose with most votes for a cloud, or the next one after a failure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from rlbench_pin.baselines.cloning.model import nearest_sentence
from rlbench_pin.baselines.cloning.training import trained_joints, trained_tasks
from rlbench_pin.baselines.key_frames.examples import (
    OVERVIEW,
    Cloud,
    Conditioning,
    Frame,
    NetworkInput,
    close_up,
    cloud_config,
    make_cloud,
    network_input,
    overview,
    whole,
)
from rlbench_pin.baselines.key_frames.training import KIND, Votes, load_key_frames
from rlbench_pin.environment.presets import key_frame_mode
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.observation import Observation
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.spatial import FloatArray

CANDIDATES = 256
"""Number of votes with the largest weights that are clustered."""
CLUSTERS = 3
"""Maximum number of clusters of votes to try, the densest first."""
APART = 3.0
"""Minimum distance of two clusters, in units of the scales of the densities."""
TRIES = 6
"""Maximum number of failed poses at a key frame before the next key frame."""
RETRY_SPREAD = 0.006
"""Random shift of a pose for each failure after all clusters have failed, and for each repetition of all key frames: standard
deviation along each axis [m]."""
HOME = -1
"""Index of the step back to the start pose of the arm."""


class KeyFramePolicy:
    """Next tip pose from a point cloud; the instruction selects the networks of a task.

    If the episode continues after the last key frame, the arm returns to its start pose and repeats the key frames.

    Args:
        folder: Output folder of `rlbench-pin train key-frames`.
        device: Device of torch.
    """

    def __init__(self, folder: str | Path, device: str = "cpu") -> None:
        """Read the settings in the folder; networks are loaded at their first use."""
        self._folder, self._device = Path(folder), torch.device(device)
        trained = trained_tasks(self._folder, KIND)
        self._known = [(sentence, task, length) for task, s in trained.items() for sentence, length in s["key_frames"].items()]
        self.action_mode, self.obs_config = key_frame_mode(), cloud_config()
        self.joint_names = trained_joints(self._folder, trained)
        self._networks: dict[str, torch.nn.ModuleDict] = {}
        self._arm: RobotModel | None = None

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Select the networks whose demonstrations have the instruction most similar to this one."""
        _, self._task, self._length = self._known[nearest_sentence(instruction, [sentence for sentence, _, _ in self._known])]
        if self._task not in self._networks:
            self._networks[self._task] = load_key_frames(self._folder / self._task, str(self._device))
        if self._arm is None or self._arm.description.reference != context.robot:
            self._arm = RobotModel(robot_description(context.robot))
        self._instruction, self._rng = instruction, np.random.default_rng(context.seed)
        self._step, self._refused, self._round = 0, 0, 0
        self._joints: FloatArray | None = None
        self._home: FloatArray | None = None

    def act(self, observation: Observation) -> np.ndarray:
        """Return the tip pose, the opening, and 1 to ignore collisions, shape (9,)."""
        self._count(observation)
        if self._step == HOME:
            assert self._home is not None, "the first action is never the way back"
            return np.concatenate([self._home, [1.0, 0.0]])
        pose, gripper = self._next(observation)
        pose[:3] += self._rng.normal(scale=RETRY_SPREAD, size=3) * (self._round + max(0, self._refused - CLUSTERS + 1))
        return np.concatenate([pose, gripper])

    def _count(self, observation: Observation) -> None:
        """Update the key-frame index, and the number of failed poses at this key frame.

        An action was refused if no joint has moved since then.
        """
        joints = np.append(np.asarray(observation.joint_positions), np.asarray(observation.gripper_joint_positions))
        if self._joints is None:
            self._home = np.asarray(observation.gripper_pose, dtype=float)
        elif np.array_equal(joints, self._joints) and self._step != HOME and self._refused < TRIES:
            self._refused += 1
        else:
            self._refused, self._step = 0, self._step + 1
            if self._step == self._length:
                self._step, self._round = HOME, self._round + 1
        self._joints = joints

    def _next(self, observation: Observation) -> tuple[FloatArray, FloatArray]:
        """Return the next tip pose (7,), then whether the gripper is open and collisions are ignored (2,)."""
        assert self._arm is not None, "call `reset` before `act`"
        cloud = make_cloud(observation, self._arm)
        tip, opening = np.asarray(observation.gripper_pose, dtype=float), float(observation.gripper_open or 0.0)
        conditioning = Conditioning(self._instruction, tip, opening, self._step)
        votes = self._votes("coarse", whole(overview(cloud), np.random.default_rng(0)), conditioning, OVERVIEW)
        found = clusters(votes)
        pose = OVERVIEW.pose(*found[min(self._refused, len(found) - 1)])
        return self._close(cloud, conditioning, pose), (votes.gripper[0] > 0.0).double().cpu().numpy()

    def _close(self, cloud: Cloud, conditioning: Conditioning, pose: FloatArray) -> FloatArray:
        """Return a tip pose after two refinements by the network for its surroundings."""
        for _ in range(2):
            frame = Frame.of_tip(pose)
            votes = self._votes("fine", close_up(cloud, frame.origin, np.random.default_rng(0)), conditioning, frame)
            pose = frame.pose(*clusters(votes)[0])
        return pose

    def _votes(self, name: str, cloud: Cloud, conditioning: Conditioning, frame: Frame) -> Votes:
        """Return the votes of the network `name` for a cloud, in the coordinates of a frame."""
        with torch.no_grad():
            votes: Votes = self._networks[self._task][name](
                *NetworkInput.batch([network_input(cloud, conditioning, frame)], self._device)
            )
        return votes


def clusters(votes: Votes) -> list[tuple[FloatArray, FloatArray]]:
    """Return the centres of the clusters of votes for the first cloud: positions (3,) and axes (6,), the densest first.

    Each centre is the weighted mean of the votes near the densest vote, so that two clusters are never averaged. Votes near a
    found cluster are excluded from the search for the next one.
    """
    best = votes.weight[0].topk(min(CANDIDATES, votes.weight.shape[1])).indices
    weight, position, axes = (values[0, best].double() for values in (votes.weight, votes.position, votes.axes))
    apart = (position[:, None] - position).abs().sum(-1) / votes.scales.position
    apart += (axes[:, None] - axes).abs().sum(-1) / votes.scales.axes
    density = (weight - apart).logsumexp(dim=1)
    found: list[tuple[FloatArray, FloatArray]] = []
    while len(found) < CLUSTERS and bool(density.isfinite().any()):
        densest = density.argmax()
        share = (weight - apart[densest]).softmax(dim=0)[:, None]
        found.append(((share * position).sum(0).cpu().numpy(), (share * axes).sum(0).cpu().numpy()))
        density = density.masked_fill(apart[densest] < APART, -torch.inf)
    return found


def policy(folder: str, device: str = "cpu") -> KeyFramePolicy:
    """Return the policy in a folder that `rlbench-pin train key-frames` wrote."""
    return KeyFramePolicy(folder, device)
