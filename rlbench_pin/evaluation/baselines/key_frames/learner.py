"""Key-frame cloning of one task: batches of clouds, shifted and turned, and how unlikely the network finds what was done."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from rlbench_pin.evaluation.baselines.cloning.sentences import SENTENCE_SIZE, encode_sentence
from rlbench_pin.evaluation.baselines.cloning.storage import MODEL, SETTINGS, fill_network, read_settings, write_settings
from rlbench_pin.evaluation.baselines.cloning.training import Losses, TrainConfig, seeded, train
from rlbench_pin.evaluation.baselines.key_frames.examples import MOST_STEPS, KeyFrameExamples, read_key_frames
from rlbench_pin.evaluation.baselines.key_frames.network import VoteNetwork, Votes
from rlbench_pin.evaluation.baselines.key_frames.poses import axes_of, vertical_turn
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

KIND = "key_frames"
MIDDLE = np.array([0.2, 0.0, TABLE_HEIGHT + 0.2])
"""Point of the world that is the network's origin [m]."""
CONTEXT = SENTENCE_SIZE + 9 + 1 + MOST_STEPS
"""Numbers that say what to do and how the hand stands."""
SHIFT, TURN = 0.06, 0.35
"""Largest shift along x and y [m], and turn about the vertical [rad], of a scene in training."""


def context_row(sentence: FloatArray, tip: FloatArray, axes: FloatArray, opening: float, step: int) -> FloatArray:
    """Return what the network is told beside the cloud, (CONTEXT,); positions are relative to `MIDDLE`."""
    number = np.zeros(MOST_STEPS)
    number[min(step, MOST_STEPS - 1)] = 1.0
    return np.concatenate([sentence, tip, axes, [opening], number])


class KeyFrameLearner:
    """Examples on a device, and losses of a network on batches of them."""

    def __init__(self, examples: KeyFrameExamples, device: str = "cpu", seed: int = 0) -> None:
        """Keep examples and make a network for them."""
        self._examples, self._device = examples, torch.device(device)
        network = seeded(lambda: VoteNetwork(CONTEXT), seed)
        assert isinstance(network, VoteNetwork)
        self.network = network.to(self._device)
        self._sentences = [np.stack([encode_sentence(s) for s in said]) for said in examples.instructions]
        self._tip_axes = np.stack([axes_of(p) for p in examples.tip])
        self._target_axes = np.stack([axes_of(p[:7]) for p in examples.target])

    def losses(self, rng: np.random.Generator, batch: int) -> Losses:
        """Draw a batch and return the negative logarithm of the density at the key frames, and the error of the hand."""
        data = self._examples
        rows = rng.integers(len(data.step), size=batch)
        turned = [self._moved(row, rng) for row in rows]
        points, tip, context, position, axes = (np.stack(column) for column in zip(*turned, strict=True))
        votes: Votes = self.network(
            self._tensor(points), self._tensor(data.colors[rows]), torch.as_tensor(data.neighbours[rows], device=self._device),
            self._tensor(tip), self._tensor(context),
        )  # fmt: skip
        pose = -votes.log_density(self._tensor(position), self._tensor(axes)).mean()
        hand = torch.nn.functional.binary_cross_entropy_with_logits(votes.hand, self._tensor(data.target[rows, 7:]).clamp(0, 1))
        return {"total": pose + hand, "pose": pose, "hand": hand}

    def _moved(self, row: int, rng: np.random.Generator) -> tuple[FloatArray, ...]:
        """Return points, tip, context, target position and target axes of an example in a shifted and turned scene."""
        data = self._examples
        rotation = vertical_turn(rng.uniform(-TURN, TURN))
        shift = np.append(rng.uniform(-SHIFT, SHIFT, size=2), 0.0)
        points, tip, position = (
            (p - MIDDLE) @ rotation.T + shift for p in (data.points[row], data.tip[row, :3], data.target[row, :3])
        )
        tip_axes, axes = ((a.reshape(2, 3) @ rotation.T).ravel() for a in (self._tip_axes[row], self._target_axes[row]))
        said = self._sentences[data.episode[row]]
        sentence = said[rng.integers(len(said))]
        return points, tip, context_row(sentence, tip, tip_axes, data.opening[row], int(data.step[row])), position, axes

    def _tensor(self, values: FloatArray) -> torch.Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=self._device)


def train_key_frames(
    roots: Sequence[Path],
    task: str,
    folder: Path,
    config: TrainConfig,
    *,
    demos: int = -1,
    on_demo: Callable[[int, int], None] = lambda done, total: None,
    on_step: Callable[[int, float], None] = lambda step, loss: None,
    stop: threading.Event | None = None,
) -> bool:
    """Train key-frame cloning of one task and write it to `folder/task`; what was begun there goes on.

    Args:
        roots: Folders of datasets; the first that holds the task is read.
        task: Its name.
        folder: Where the folder of its model is made.
        config: How long, how fast.
        demos: Demonstrations to learn from; -1 is all.
        on_demo: Called while demonstrations are played again, with how many are done, and how many there are.
        on_step: Called with how many steps are done, and the loss.
        stop: When set, the training ends at a checkpoint.

    Returns:
        Whether it is finished.
    """
    place = Path(folder) / task
    if (place / MODEL).exists() and (place / SETTINGS).exists():
        return True
    root = next((r for r in roots if (Path(r) / task).is_dir()), roots[0])
    examples = read_key_frames(Path(root), task, demos, on_demo)
    learner = KeyFrameLearner(examples, config.device, config.seed)
    finished = train(learner.network, lambda rng: learner.losses(rng, config.batch), config, place, on_step, stop)
    if finished:
        write_settings(place / SETTINGS, KIND, _settings(task, examples, config))
    return finished


def _settings(task: str, examples: KeyFrameExamples, config: TrainConfig) -> dict[str, Any]:
    return {
        "task": task,
        "instructions": list(dict.fromkeys(s for said in examples.instructions for s in said)),
        "demonstrations": len(examples.instructions),
        "train": asdict(replace(config, device="cpu")),
    }


def load_key_frames(folder: Path, device: str = "cpu") -> VoteNetwork:
    """Return the network in a folder.

    Raises:
        ModelFileError: A file is missing or damaged.
    """
    read_settings(folder / SETTINGS, KIND)
    network = VoteNetwork(CONTEXT)
    fill_network(network, folder / MODEL)
    return network.to(device).eval()
