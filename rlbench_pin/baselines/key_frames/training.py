"""Network and training of the key-frame baseline."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import torch
from torch import Tensor, nn

from rlbench_pin.baselines.cloning.training import (
    MODEL,
    SETTINGS,
    Losses,
    TrainConfig,
    fill_network,
    read_settings,
    seeded,
    train_task,
)
from rlbench_pin.baselines.key_frames.examples import (
    CONTEXT,
    OVERVIEW,
    POINT,
    Conditioning,
    Example,
    Frame,
    NetworkInput,
    axes_of,
    close_up,
    network_input,
    read_key_frames,
    whole,
)
from rlbench_pin.errors import DatasetError
from rlbench_pin.spatial import FloatArray

WIDTH = 64
"""Number of features of a point."""
MODES = 2
"""Number of votes of each point; a gripper with two fingers can often grasp in two orientations."""


@dataclass(frozen=True)
class Scales:
    """Length scales of a network."""

    position: float
    """Scale of the Laplace densities around votes [m]."""
    axes: float
    """The same for the components of the two axes."""
    scene: float
    """Size of the cloud [m]."""
    gap: float
    """Typical distance of neighbouring points [m]."""
    rest: tuple[float, ...]
    """Axes of the gripper to which the network adds its output (6,)."""


COARSE = Scales(0.015, 0.15, 0.5, 0.05, (1.0, 0.0, 0.0, 0.0, 0.0, -1.0))
FINE = Scales(0.004, 0.04, 0.1, 0.02, (1.0, 0.0, 0.0, 0.0, 0.0, 1.0))
"""Scales of the network for the whole scene, and of the network for the surroundings of the pose that the first predicts."""


@dataclass(frozen=True)
class Votes:
    """Predictions of the points of clouds, for b clouds and v = points * `MODES` votes."""

    weight: Tensor
    """Logarithm of the weight of each vote, (b, v); the sum of the weights is 1."""
    position: Tensor
    """Position of the tip, (b, v, 3) [m]."""
    axes: Tensor
    """x-axis and z-axis of the tip, not yet orthonormal, (b, v, 6)."""
    gripper: Tensor
    """Logits that the gripper is open and that collisions are ignored, (b, 2)."""
    scales: Scales
    """Scales of the densities."""

    def log_density(self, position: Tensor, axes: Tensor) -> Tensor:
        """Return the logarithm of the mixture density, up to a constant, at tip poses: positions (b, 3) and axes (b, 6)."""
        far = (self.position - position[:, None]).abs().sum(-1) / self.scales.position
        turned = (self.axes - axes[:, None]).abs().sum(-1) / self.scales.axes
        return (self.weight - far - turned).logsumexp(dim=1)


class VoteNetwork(nn.Module):
    """Convolutions over neighbouring points (Wang et al. 2019), conditioned on instruction, gripper and key-frame index.

    Args:
        scales: Length scales.
    """

    def __init__(self, scales: Scales) -> None:
        super().__init__()
        self.scales = scales
        self.first = nn.Linear(POINT + 4, WIDTH)
        self.context = nn.Sequential(nn.Linear(CONTEXT, 128), nn.GELU(), nn.Linear(128, 128), nn.GELU())
        self.layers = nn.ModuleList([_EdgeLayer() for _ in range(3)])
        self.look = nn.ModuleList([_Overview() for _ in range(2)])
        self.votes = nn.Sequential(nn.Linear(WIDTH, 128), nn.GELU(), nn.Linear(128, MODES * 10))
        self.hand = nn.Sequential(nn.Linear(WIDTH + 128, 64), nn.GELU(), nn.Linear(64, 2))

    def forward(self, points: Tensor, neighbours: Tensor, context: Tensor) -> Votes:
        """Return the votes for a batch of inputs: points (b, n, POINT), neighbours (b, n, k), contexts (b, CONTEXT)."""
        where, rest = points[..., :3], points[..., 3:]
        away = (where - where[:, -1:]) / self.scales.scene
        x = self.first(torch.cat([where / self.scales.scene, rest, away, away.norm(dim=-1, keepdim=True)], dim=-1))
        conditioning = self.context(context)
        place = where / self.scales.gap
        x = self.layers[0](x, place, neighbours, conditioning)
        x = self.layers[1](x, place, neighbours, conditioning)
        x, _ = self.look[0](x, conditioning)
        x = self.layers[2](x, place, neighbours, conditioning)
        x, seen = self.look[1](x, conditioning)
        out = self.votes(x).unflatten(-1, (MODES, 10))
        position = (where[:, :, None] + 0.4 * self.scales.scene * out[..., 1:4]).flatten(1, 2)
        axes = (out[..., 4:] + out.new_tensor(self.scales.rest)).flatten(1, 2)
        gripper = self.hand(torch.cat([seen, conditioning], dim=-1))
        return Votes(out[..., 0].flatten(1).log_softmax(dim=1), position, axes, gripper, self.scales)


class _EdgeLayer(nn.Module):
    """Residual layer: the maximum over neighbours of relu(A x_i + B x_j + C (p_j - p_i)), scaled and shifted by the context."""

    def __init__(self) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(WIDTH)
        self.own, self.other = nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, WIDTH, bias=False)
        self.offset = nn.Linear(3, WIDTH, bias=False)
        self.told = nn.Linear(128, 2 * WIDTH)
        self.out = nn.Linear(WIDTH, WIDTH)

    def forward(self, x: Tensor, place: Tensor, neighbours: Tensor, conditioning: Tensor) -> Tensor:
        """Return the features after the layer, (b, n, WIDTH)."""
        normed, at = self.norm(x), self.offset(place)
        pooled = torch.relu(strongest_neighbour(self.other(normed) + at, neighbours) + self.own(normed) - at)
        scale, shift = self.told(conditioning)[:, None].chunk(2, dim=-1)
        return x + self.out(torch.relu(pooled * (1.0 + scale) + shift))  # type: ignore[no-any-return]


class _Overview(nn.Module):
    """Adds a summary of all points to each point: the maximum of each feature, and features that attention selects."""

    def __init__(self) -> None:
        super().__init__()
        self.features, self.score = nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, 4)
        self.mix = nn.Sequential(nn.Linear(5 * WIDTH + 128, 128), nn.GELU(), nn.Linear(128, WIDTH))
        self.back = nn.Linear(2 * WIDTH, WIDTH)

    def forward(self, x: Tensor, conditioning: Tensor) -> tuple[Tensor, Tensor]:
        """Return the features of the points, (b, n, WIDTH), and the summary, (b, WIDTH)."""
        features = torch.relu(self.features(x))
        picked = torch.einsum("bnh,bnw->bhw", self.score(x).softmax(dim=1), features).flatten(1)
        seen = self.mix(torch.cat([features.amax(dim=1), picked, conditioning], dim=-1))
        spread = seen[:, None].expand(-1, x.shape[1], -1)
        return x + self.back(torch.relu(torch.cat([x, spread], dim=-1))), seen


def strongest_neighbour(values: Tensor, rows: Tensor) -> Tensor:
    """Return the maximum of the values (b, n, w) over the neighbours of each point, (b, n, w).

    The gradient needs the index of the maximum. It is stored in the last three bits of each number, which takes half the time
    of a maximum with indices on a CPU.

    Args:
        values: Features of the points (b, n, w).
        rows: Indices of the neighbours (b, n, k), with k at most 8.
    """
    b, n, k = rows.shape
    flat = (rows + (torch.arange(b, device=rows.device) * n)[:, None, None]).reshape(b * n, k)
    flat_values = values.reshape(b * n, -1)
    with torch.no_grad():
        marked = (flat_values.view(torch.int32) & -8).index_select(0, flat.reshape(-1)).view(b * n, k, -1)
        marked |= torch.arange(k, dtype=torch.int32, device=rows.device)[:, None]
        slot = marked.view(torch.float32).amax(dim=1).view(torch.int32) & 7
    return flat_values.gather(0, flat.gather(1, slot.long())).view(b, n, -1)


def make_networks() -> nn.ModuleDict:
    """Return the two networks of a task, `coarse` and `fine`."""
    return nn.ModuleDict({"coarse": VoteNetwork(COARSE), "fine": VoteNetwork(FINE)})


KIND = "key_frames"
SHIFT, TURN = 0.06, 0.35
"""Augmentation of the whole scene: maximum shift along x and y [m], and maximum rotation about the vertical [rad]."""
MISSED, TILTED = 0.012, 0.08
"""Noise on the frame of the close-up: standard deviations of the shift along each axis [m] and the rotation about it [rad]."""


class KeyFrameLearner:
    """The two networks for the examples of one task, and their losses on batches of them.

    Args:
        examples: Examples of the task.
        device: Device of torch.
        seed: Seed of the initial weights.

    Raises:
        DatasetError: There are no examples.
    """

    def __init__(self, examples: Sequence[Example], device: str = "cpu", seed: int = 0) -> None:
        if not examples:
            raise DatasetError("There are no demonstrations to learn from. Record some with `rlbench-pin record`.")
        self._examples, self._device = examples, torch.device(device)
        self.network = seeded(make_networks, seed).to(self._device)

    def losses(self, rng: np.random.Generator, batch: int) -> Losses:
        """Draw a batch and return its losses: negative log densities at the key frames, and cross entropies of the gripper."""
        drawn = [self._examples[row] for row in rng.integers(len(self._examples), size=batch)]
        conditioning = [Conditioning(e.sentences[rng.integers(len(e.sentences))], e.tip, e.opening, e.step) for e in drawn]
        frames = {"coarse": [_moved(rng) for _ in drawn], "fine": [_near(e.target[:7], rng) for e in drawn]}
        clouds = {
            "coarse": [whole(e.whole, rng) for e in drawn],
            "fine": [close_up(e.close, f.origin, rng) for e, f in zip(drawn, frames["fine"], strict=True)],
        }
        gripper = self._tensor([e.target[7:].clip(0.0, 1.0) for e in drawn])
        losses: Losses = {}
        for name, network in self.network.items():
            inputs = [network_input(*seen) for seen in zip(clouds[name], conditioning, frames[name], strict=True)]
            votes: Votes = network(*NetworkInput.batch(inputs, self._device))
            position = [f.points(e.target[:3]) for e, f in zip(drawn, frames[name], strict=True)]
            axes = [f.axes(axes_of(e.target[:7])) for e, f in zip(drawn, frames[name], strict=True)]
            losses[name] = -votes.log_density(self._tensor(position), self._tensor(axes)).mean()
            losses[f"{name} hand"] = torch.nn.functional.binary_cross_entropy_with_logits(votes.gripper, gripper)
        return {"total": torch.stack(list(losses.values())).sum(), **losses}

    def settings(self) -> dict[str, Any]:
        """Return the maximum number of key frames per instruction, and the number and joint names of the demonstrations."""
        lengths: dict[str, int] = {}
        for example in self._examples:
            for sentence in example.sentences:
                lengths[sentence] = max(lengths.get(sentence, 0), example.step + 1)
        demonstrations, joints = sum(e.step == 0 for e in self._examples), list(self._examples[0].joint_names)
        return {"key_frames": lengths, "demonstrations": demonstrations, "joint_names": joints}

    def _tensor(self, rows: Sequence[FloatArray]) -> torch.Tensor:
        return torch.as_tensor(np.stack(rows), dtype=torch.float32, device=self._device)


def _moved(rng: np.random.Generator) -> Frame:
    """Return the frame of the overview with a random shift and rotation, for augmentation."""
    shift = np.append(rng.uniform(-SHIFT, SHIFT, size=2), 0.0)
    return Frame(OVERVIEW.origin + shift, pin.exp3(np.array([0.0, 0.0, rng.uniform(-TURN, TURN)])))


def _near(pose: FloatArray, rng: np.random.Generator) -> Frame:
    """Return the frame of a tip pose with random errors, about as large as those of the first network."""
    frame = Frame.of_tip(pose)
    return Frame(frame.origin + rng.normal(scale=MISSED, size=3), frame.rotation @ pin.exp3(rng.normal(scale=TILTED, size=3)))


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
    """Train key-frame cloning of one task and write it to `folder/task`, see `train_task`.

    Args:
        roots: Folders of datasets; the first that contains the task is read.
        task: Name of the task.
        folder: Folder in which the folder of the model is created.
        config: Settings of the training.
        demos: Number of demonstrations to learn from; -1 uses all.
        on_demo: Function that is called during the replay with the number of completed demonstrations, and their total number.
        on_step: Function that is called with the number of completed steps, and the loss.
        stop: Event that ends the training at a checkpoint.

    Returns:
        Whether the training is complete.
    """

    def make_learner(root: Path) -> KeyFrameLearner:
        return KeyFrameLearner(read_key_frames(root, task, demos, on_demo), config.device, config.seed)

    return train_task(KIND, make_learner, roots, task, folder, config, on_step, stop)


def load_key_frames(folder: Path, device: str = "cpu") -> torch.nn.ModuleDict:
    """Return the networks in a folder.

    Raises:
        ModelFileError: A file is missing or damaged.
    """
    read_settings(folder / SETTINGS, KIND)
    networks = make_networks()
    fill_network(networks, folder / MODEL)
    return networks.to(device).eval()
