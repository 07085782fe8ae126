"""Behaviour cloning of one task: batches of examples, disturbed a little, and what the network loses on them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from rlbench_pin.evaluation.baselines.cloning.chunks import CHUNK, Examples, read_examples
from rlbench_pin.evaluation.baselines.cloning.network import ChunkNetwork, ChunkSizes
from rlbench_pin.evaluation.baselines.cloning.sentences import SENTENCE_SIZE
from rlbench_pin.evaluation.baselines.cloning.storage import MODEL, SETTINGS, fill_network, read_settings, write_settings
from rlbench_pin.evaluation.baselines.cloning.training import Losses, TrainConfig, seeded, train
from rlbench_pin.spatial import FloatArray

KIND = "cloning"
JOINT_NOISE = 0.02
"""Spread of what is added to the joints that are seen [rad]. The commands stay, so the network learns to come back."""
STATE_NOISE = 0.002
"""Spread of what is added to the numbers that describe objects, in [m] or [rad]."""
TIME_NOISE = 0.1
"""Spread of what is added to the time [s]."""
SHIFT = 2
"""Pixels that pictures are moved by at most, of `PICTURE`."""
LEAST_SPREAD = 0.02
"""Numbers that vary less are divided by this, so that what is constant in the demonstrations stays near 0."""


class ChunkLearner:
    """Examples on a device, and losses of a network on batches of them."""

    def __init__(self, examples: Examples, cameras: Sequence[str] = (), device: str = "cpu", seed: int = 0) -> None:
        """Put examples on a device and make a network for them."""
        self._examples, self._device = examples, torch.device(device)
        width, state = examples.joints.shape[1], examples.task_state.shape[1]
        sizes = ChunkSizes(width, state, SENTENCE_SIZE, tuple(cameras), CHUNK)
        network = seeded(lambda: ChunkNetwork(sizes), seed)
        assert isinstance(network, ChunkNetwork)
        self.network = network.to(self._device)
        numbers = np.concatenate([examples.joints, examples.opening, examples.time, examples.task_state], axis=1)
        steps = examples.targets - examples.joints[:, None]
        self._fill(self.network.mean, numbers.mean(axis=0))
        self._fill(self.network.spread, np.maximum(numbers.std(axis=0), LEAST_SPREAD))
        self._fill(self.network.reach, np.maximum(steps.std(axis=0), LEAST_SPREAD))
        self._numbers, width = numbers, examples.joints.shape[1]
        self._noise = np.r_[np.full(width, JOINT_NOISE), 0.0, TIME_NOISE, np.full(state, STATE_NOISE)]

    def losses(self, rng: np.random.Generator, batch: int) -> Losses:
        """Draw a batch and return the mean errors of commands, in units of their spread, and of the hand."""
        data = self._examples
        rows = rng.integers(len(self._numbers), size=batch)
        numbers = self._numbers[rows] + rng.normal(size=(batch, len(self._noise))) * self._noise
        steps = data.targets[rows] - numbers[:, None, : data.joints.shape[1]]
        said = [data.sentences[e] for e in data.episode[rows]]
        sentence = np.stack([each[rng.integers(len(each))] for each in said])
        seen = as_pictures(shifted(data.pictures[rows], rng), self._device)
        found, hand = self.network(self._tensor(numbers), self._tensor(sentence), seen)
        arm = torch.nn.functional.smooth_l1_loss(found / self.network.reach, self._tensor(steps) / self.network.reach, beta=0.1)
        grip = torch.nn.functional.binary_cross_entropy_with_logits(hand, self._tensor(data.hand[rows]).clamp(0.0, 1.0))
        return {"total": arm + 0.1 * grip, "arm": arm, "hand": grip}

    def _tensor(self, values: FloatArray) -> torch.Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=self._device)

    def _fill(self, buffer: torch.Tensor, values: FloatArray) -> None:
        buffer.copy_(self._tensor(values))


def shifted(pictures: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return pictures (b, cameras, h, w, 3), each moved by up to `SHIFT` pixels either way; borders are repeated."""
    batch, cameras, height, width = pictures.shape[:4]
    down, right = rng.integers(-SHIFT, SHIFT + 1, size=(2, batch, cameras, 1))
    rows = np.clip(np.arange(height) + down, 0, height - 1)[..., None]
    columns = np.clip(np.arange(width) + right, 0, width - 1)[:, :, None]
    return pictures[np.arange(batch)[:, None, None, None], np.arange(cameras)[:, None, None], rows, columns]


def as_pictures(pictures: np.ndarray, device: torch.device) -> torch.Tensor:
    """Return uint8 pictures (b, cameras, h, w, 3) as a network sees them: (b, cameras, 3, h, w), 0..1."""
    return torch.as_tensor(pictures, device=device).movedim(-1, 2).float() / 255.0


def train_cloning(
    roots: Sequence[Path],
    task: str,
    folder: Path,
    config: TrainConfig,
    *,
    demos: int = -1,
    cameras: Sequence[str] = (),
    on_step: Callable[[int, float], None] = lambda step, loss: None,
    stop: threading.Event | None = None,
) -> bool:
    """Train behaviour cloning of one task and write it to `folder/task`; what was begun there goes on.

    Args:
        roots: Folders of datasets; the first that holds the task is read.
        task: Its name.
        folder: Where the folder of its model is made.
        config: How long, how fast.
        demos: Demonstrations to learn from; -1 is all.
        cameras: Cameras to learn from in place of the task state.
        on_step: Called with how many steps are done, and the loss.
        stop: When set, the training ends at a checkpoint.

    Returns:
        Whether it is finished.
    """
    place = Path(folder) / task
    if (place / MODEL).exists() and (place / SETTINGS).exists():
        return True
    root = next((r for r in roots if (Path(r) / task).is_dir()), roots[0])
    examples = read_examples(Path(root), task, demos, cameras)
    learner = ChunkLearner(examples, cameras, config.device, config.seed)
    finished = train(learner.network, lambda rng: learner.losses(rng, config.batch), config, place, on_step, stop)
    if finished:
        write_settings(place / SETTINGS, KIND, _settings(task, learner.network.sizes, examples, config))
    return finished


def _settings(task: str, sizes: ChunkSizes, examples: Examples, config: TrainConfig) -> dict[str, Any]:
    return {
        "task": task,
        "sizes": asdict(sizes),
        "instructions": list(examples.instructions),
        "demonstrations": len(examples.sentences),
        "longest": float(examples.time.max()),
        "train": asdict(replace(config, device="cpu")),
    }


def load_cloning(folder: Path, device: str = "cpu") -> tuple[ChunkNetwork, float]:
    """Return the network in a folder, and the longest time that it has seen [s].

    Raises:
        ModelFileError: A file is missing or damaged.
    """
    settings = read_settings(folder / SETTINGS, KIND)
    sizes = dict(settings["sizes"])
    network = ChunkNetwork(ChunkSizes(**{**sizes, "cameras": tuple(sizes["cameras"])}))
    fill_network(network, folder / MODEL)
    return network.to(device).eval(), float(settings["longest"])
