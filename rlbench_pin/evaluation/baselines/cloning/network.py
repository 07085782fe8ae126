"""The network of behaviour cloning: what is observed -> joint commands of the next ticks, relative to the joints now."""

from __future__ import annotations

from dataclasses import dataclass, field

import torch
from torch import Tensor, nn

WIDTH = 384
_FEATURES = 32


@dataclass(frozen=True)
class ChunkSizes:
    """What goes into the network and what comes out."""

    joints: int = 7
    """Joints of the arm."""
    task_state: int = 0
    """Numbers that describe the objects."""
    sentence: int = 96
    """Numbers of an encoded sentence."""
    cameras: tuple[str, ...] = field(default=())
    """Cameras whose pictures it sees."""
    chunk: int = 20
    """Ticks that it predicts."""


class ChunkNetwork(nn.Module):
    """A residual perceptron over normalised numbers, and for pictures a small convolution that says where features are.

    Buffers `mean` and `spread` normalise what goes in, `reach` what comes out; they are stored with the weights.
    """

    mean: Tensor
    spread: Tensor
    reach: Tensor

    def __init__(self, sizes: ChunkSizes) -> None:
        super().__init__()
        self.sizes = sizes
        numbers = sizes.joints + 2 + sizes.task_state
        self.register_buffer("mean", torch.zeros(numbers))
        self.register_buffer("spread", torch.ones(numbers))
        self.register_buffer("reach", torch.ones(sizes.chunk, sizes.joints))
        self.eyes = nn.ModuleList([_Eye() for _ in sizes.cameras])
        into = numbers + sizes.sentence + 2 * _FEATURES * len(sizes.cameras)
        self.first = nn.Linear(into, WIDTH)
        self.blocks = nn.ModuleList([_Block() for _ in range(3)])
        self.last = nn.Linear(WIDTH, sizes.chunk * (sizes.joints + 1))

    def forward(self, numbers: Tensor, sentence: Tensor, pictures: Tensor) -> tuple[Tensor, Tensor]:
        """Return joint commands relative to the joints now, (b, chunk, joints) [rad], and how likely the hand is open.

        Args:
            numbers: Joints, opening, time and task state, (b, n).
            sentence: Encoded instructions, (b, s).
            pictures: Colours 0..1, (b, cameras, 3, h, w).

        Returns:
            Steps, and logits (b, chunk).
        """
        seen = [eye(pictures[:, i]) for i, eye in enumerate(self.eyes)]
        x = self.first(torch.cat([(numbers - self.mean) / self.spread, sentence, *seen], dim=1))
        for block in self.blocks:
            x = block(x)
        out = self.last(x).unflatten(1, (self.sizes.chunk, self.sizes.joints + 1))
        return out[..., :-1] * self.reach, out[..., -1]


class _Block(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.inner = nn.Sequential(nn.LayerNorm(WIDTH), nn.Linear(WIDTH, WIDTH), nn.GELU(), nn.Linear(WIDTH, WIDTH))

    def forward(self, x: Tensor) -> Tensor:
        """Return x and what the block adds."""
        return x + self.inner(x)  # type: ignore[no-any-return]


class _Eye(nn.Module):
    """Convolutions, then for each feature the mean place where it is strong (Levine et al. 2016)."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv2d(3, 32, 5, stride=2, padding=2),
            nn.ReLU(),
            nn.Conv2d(32, 32, 3, stride=2, padding=1),
            nn.ReLU(),
            nn.Conv2d(32, _FEATURES, 3, padding=1),
        )

    def forward(self, picture: Tensor) -> Tensor:
        """Return (b, 2 * features): x and y of each feature in -1..1."""
        strong = self.layers(picture)
        weight = strong.flatten(2).softmax(dim=2).view_as(strong)
        x = torch.linspace(-1.0, 1.0, strong.shape[3], device=picture.device)
        y = torch.linspace(-1.0, 1.0, strong.shape[2], device=picture.device)
        return torch.cat([(weight.sum(2) * x).sum(2), (weight.sum(3) * y).sum(2)], dim=1)
