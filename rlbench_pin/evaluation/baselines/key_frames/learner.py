"""Key-frame cloning of one task: batches of moved scenes, and how unlikely the networks find what was done."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from rlbench_pin.errors import DatasetError
from rlbench_pin.evaluation.baselines.cloning.storage import MODEL, SETTINGS, fill_network, read_settings, write_settings
from rlbench_pin.evaluation.baselines.cloning.training import Losses, TrainConfig, seeded, train
from rlbench_pin.evaluation.baselines.key_frames.examples import Example, read_key_frames
from rlbench_pin.evaluation.baselines.key_frames.network import Votes, make_networks
from rlbench_pin.evaluation.baselines.key_frames.poses import Frame, axes_of, turn
from rlbench_pin.evaluation.baselines.key_frames.sights import OVERVIEW, Sight, Told, close_up, sight, whole
from rlbench_pin.spatial import FloatArray

KIND = "key_frames"
SHIFT, TURN = 0.06, 0.35
"""Largest shift along x and y [m], and turn about the vertical [rad], of a scene in training."""
MISSED, TILTED = 0.012, 0.08
"""How far beside the key frame the close look is in training: standard deviations along each axis [m] and about it [rad]."""


class KeyFrameLearner:
    """Examples on a device, and losses of two networks on batches of them."""

    def __init__(self, examples: Sequence[Example], device: str = "cpu", seed: int = 0) -> None:
        """Keep examples and make networks for them.

        Raises:
            DatasetError: There are none.
        """
        if not examples:
            raise DatasetError("There are no demonstrations to learn from. `rlbench-pin record` makes some.")
        self._examples, self._device = examples, torch.device(device)
        network = seeded(make_networks, seed)
        assert isinstance(network, torch.nn.ModuleDict)
        self.network = network.to(self._device)

    def losses(self, rng: np.random.Generator, batch: int) -> Losses:
        """Draw a batch and return the negative logarithms of the densities at the key frames, and the error of the hand."""
        drawn = [self._examples[row] for row in rng.integers(len(self._examples), size=batch)]
        told = [Told(e.sentences[rng.integers(len(e.sentences))], e.tip, e.opening, e.step) for e in drawn]
        frames = {"coarse": [_moved(rng) for _ in drawn], "fine": [_beside(e.target[:7], rng) for e in drawn]}
        clouds = {
            "coarse": [whole(e.whole, rng) for e in drawn],
            "fine": [close_up(e.close, f.origin, rng) for e, f in zip(drawn, frames["fine"], strict=True)],
        }
        hand = self._tensor([e.target[7:].clip(0.0, 1.0) for e in drawn])
        losses: Losses = {}
        for name, network in self.network.items():
            sights = [sight(*seen) for seen in zip(clouds[name], told, frames[name], strict=True)]
            votes: Votes = network(*Sight.batch(sights, self._device))
            position = [f.points(e.target[:3]) for e, f in zip(drawn, frames[name], strict=True)]
            axes = [f.axes(axes_of(e.target[:7])) for e, f in zip(drawn, frames[name], strict=True)]
            losses[name] = -votes.log_density(self._tensor(position), self._tensor(axes)).mean()
            losses[f"{name} hand"] = torch.nn.functional.binary_cross_entropy_with_logits(votes.hand, hand)
        return {"total": torch.stack(list(losses.values())).sum(), **losses}

    def _tensor(self, rows: Sequence[FloatArray]) -> torch.Tensor:
        return torch.as_tensor(np.stack(rows), dtype=torch.float32, device=self._device)


def _moved(rng: np.random.Generator) -> Frame:
    """Return a frame near that of the overview, so that the scene seems shifted and turned."""
    shift = np.append(rng.uniform(-SHIFT, SHIFT, size=2), 0.0)
    return Frame(OVERVIEW.origin + shift, turn(np.array([0.0, 0.0, rng.uniform(-TURN, TURN)])))


def _beside(pose: FloatArray, rng: np.random.Generator) -> Frame:
    """Return the frame of a tip pose that misses another by about as much as the first network does."""
    frame = Frame.of_tip(pose)
    return Frame(frame.origin + rng.normal(scale=MISSED, size=3), frame.rotation @ turn(rng.normal(scale=TILTED, size=3)))


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


def _settings(task: str, examples: Sequence[Example], config: TrainConfig) -> dict[str, Any]:
    lengths: dict[str, int] = {}
    for example in examples:
        for sentence in example.sentences:
            lengths[sentence] = max(lengths.get(sentence, 0), example.step + 1)
    return {
        "task": task,
        "key_frames": lengths,
        "demonstrations": sum(e.step == 0 for e in examples),
        "train": asdict(replace(config, device="cpu")),
    }


def load_key_frames(folder: Path, device: str = "cpu") -> torch.nn.ModuleDict:
    """Return the networks in a folder.

    Raises:
        ModelFileError: A file is missing or damaged.
    """
    read_settings(folder / SETTINGS, KIND)
    networks = make_networks()
    fill_network(networks, folder / MODEL)
    return networks.to(device).eval()
