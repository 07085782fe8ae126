"""The loop that trains a network: batches that follow from seed and step, checkpoints, curves for TensorBoard."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch.utils.tensorboard import SummaryWriter

from rlbench_pin.evaluation.baselines.cloning.storage import CHECKPOINT, MODEL, ModelFileError, read_tensors, write_tensors

Losses = dict[str, torch.Tensor]
"""Name -> loss; `total` is what is minimised."""
CURVE_EVERY = 20
"""Steps between points of the curves."""


@dataclass(frozen=True)
class TrainConfig:
    """How long and how a network is trained."""

    steps: int = 3000
    """Batches."""
    batch: int = 128
    """Examples in a batch."""
    rate: float = 1e-3
    """Learning rate after the first hundred steps; it falls to 0 along half a cosine."""
    decay: float = 1e-4
    """Weight decay of AdamW."""
    seed: int = 0
    """Of first weights, batches and augmentation."""
    device: str = "cpu"
    """Where torch computes: `cpu`, `cuda`, `cuda:1` ... On the CPU the same seed gives the same bytes."""
    checkpoint_every: int = 250
    """Steps between checkpoints."""


def seeded(make: Callable[[], torch.nn.Module], seed: int) -> torch.nn.Module:
    """Return a network whose first weights follow from a seed; torch's own generator is as before."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return make()


def learning_rate(config: TrainConfig, step: int) -> float:
    """Return the learning rate of a step: up over a hundred steps, then down half a cosine."""
    warm = min(1.0, (step + 1) / 100.0)
    return config.rate * warm * 0.5 * (1.0 + math.cos(math.pi * step / config.steps))


def train(
    network: torch.nn.Module,
    losses: Callable[[np.random.Generator], Losses],
    config: TrainConfig,
    folder: Path,
    on_step: Callable[[int, float], None] = lambda step, loss: None,
    stop: threading.Event | None = None,
) -> bool:
    """Train a network, write it to `model.safetensors`, and return whether it came to its end.

    What was begun goes on from its last checkpoint, and ends with the same bits as if it had never been ended.

    Args:
        network: On the device of the settings; a checkpoint's weights replace its own.
        losses: Draws a batch, from nothing but the generator that it is given, and returns its losses.
        config: How long, how fast.
        folder: Where everything is written.
        on_step: Called with how many steps are done, and the loss.
        stop: Ends the training at a checkpoint.

    Raises:
        ModelFileError: The checkpoint is damaged, or of other settings.
    """
    optimizer = torch.optim.AdamW(network.parameters(), lr=config.rate, weight_decay=config.decay)
    done = _restore(network, optimizer, config, folder)
    writer = SummaryWriter(str(folder / "curves"), purge_step=done)
    try:
        for step in range(done, config.steps):
            if (is_ending := stop is not None and stop.is_set()) or step % config.checkpoint_every == 0:
                _checkpoint(network, optimizer, config, folder, step)
            if is_ending:
                return False
            found = _step(network, optimizer, losses, config, step)
            _draw(writer, found, step + 1)
            on_step(step + 1, found["total"])
    finally:
        writer.close()
    write_tensors(folder / MODEL, network.state_dict())
    (folder / CHECKPOINT).unlink(missing_ok=True)
    return True


def _step(
    network: torch.nn.Module,
    optimizer: torch.optim.Optimizer,
    losses: Callable[[np.random.Generator], Losses],
    config: TrainConfig,
    step: int,
) -> dict[str, float]:
    for group in optimizer.param_groups:
        group["lr"] = learning_rate(config, step)
    found = losses(np.random.default_rng([config.seed, step]))
    optimizer.zero_grad(set_to_none=True)
    found["total"].backward()
    torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
    optimizer.step()
    return {name: float(value.detach()) for name, value in found.items()}


def _draw(writer: SummaryWriter, losses: dict[str, float], step: int) -> None:
    """Put the losses of every twentieth step on the curves."""
    if step % CURVE_EVERY == 0:
        for name, value in losses.items():
            writer.add_scalar(f"loss/{name}", value, step)


def _checkpoint(network: torch.nn.Module, optimizer: torch.optim.Optimizer, config: TrainConfig, folder: Path, step: int) -> None:
    tensors = {f"network/{name}": value for name, value in network.state_dict().items()}
    for index, state in optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer/{index}/{name}": torch.as_tensor(value) for name, value in state.items()}
    write_tensors(folder / CHECKPOINT, tensors, step=str(step), config=_identity(config))


def _restore(network: torch.nn.Module, optimizer: torch.optim.Optimizer, config: TrainConfig, folder: Path) -> int:
    """Load the checkpoint, if there is one, and return how many steps were done."""
    path = folder / CHECKPOINT
    if not path.exists():
        return 0
    tensors, notes = read_tensors(path)
    if notes.get("config") != _identity(config):
        raise ModelFileError(path, f"was begun with {notes.get('config')}, not {_identity(config)}; delete it to begin again")
    network.load_state_dict({n.removeprefix("network/"): t for n, t in tensors.items() if n.startswith("network/")})
    state: dict[int, dict[str, torch.Tensor]] = {}
    for name, tensor in tensors.items():
        if name.startswith("optimizer/"):
            _, index, key = name.split("/")
            state.setdefault(int(index), {})[key] = tensor
    optimizer.load_state_dict({"state": state, "param_groups": optimizer.state_dict()["param_groups"]})
    return int(notes["step"])


def _identity(config: TrainConfig) -> str:
    """Say what must be the same for training to go on."""
    return f"steps={config.steps} batch={config.batch} rate={config.rate} decay={config.decay} seed={config.seed}"
