"""The network of key frames: every point of the cloud votes where the tip has to go, and says how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

WIDTH = 64
MODES = 2
"""Votes of each point; a hand with two fingers can often come from either side."""
POSITION_SCALE, ROTATION_SCALE = 0.015, 0.15
"""Scales of the Laplace densities around votes: [m], and in entries of the two rotated axes."""


@dataclass(frozen=True)
class Votes:
    """What the points of clouds say, for b clouds and v = POINTS * MODES votes."""

    weight: Tensor
    """Logarithm of the weight of each vote, (b, v); their exponentials add up to 1."""
    position: Tensor
    """Position of the tip, (b, v, 3) [m]."""
    axes: Tensor
    """x and z axis of the tip, not yet orthonormal, (b, v, 6)."""
    hand: Tensor
    """Logits that the hand is open and that collisions are ignored, (b, 2)."""

    def log_density(self, position: Tensor, axes: Tensor) -> Tensor:
        """Return the logarithm of the mixture density, up to a constant, at tip poses: positions (b, 3) and axes (b, 6)."""
        far = (self.position - position[:, None]).abs().sum(-1) / POSITION_SCALE
        turned = (self.axes - axes[:, None]).abs().sum(-1) / ROTATION_SCALE
        return (self.weight - far - turned).logsumexp(dim=1)


class VoteNetwork(nn.Module):
    """Convolutions over neighbouring points (Wang et al. 2019), told what to do by sentence, hand and number of the step.

    Args:
        context: Numbers of what is known beside the cloud.
    """

    def __init__(self, context: int) -> None:
        super().__init__()
        self.first = nn.Linear(10, WIDTH)
        self.context = nn.Sequential(nn.Linear(context, 128), nn.GELU(), nn.Linear(128, 128), nn.GELU())
        self.layers = nn.ModuleList([_EdgeLayer() for _ in range(3)])
        self.look = nn.ModuleList([_Overview() for _ in range(2)])
        self.votes = nn.Sequential(nn.Linear(WIDTH, 128), nn.GELU(), nn.Linear(128, MODES * 10))
        self.hand = nn.Sequential(nn.Linear(WIDTH + 128, 64), nn.GELU(), nn.Linear(64, 2))

    def forward(self, points: Tensor, colors: Tensor, neighbours: Tensor, tip: Tensor, context: Tensor) -> Votes:
        """Return the votes on clouds.

        Args:
            points: (b, n, 3), relative to the middle of the workspace [m].
            colors: (b, n, 3).
            neighbours: Numbers of near points, (b, n, k).
            tip: Position of the tip now, as the points, (b, 3) [m].
            context: Everything else that is known, (b, c).
        """
        away = points - tip[:, None]
        x = self.first(torch.cat([2.0 * points, 2.0 * colors - 1.0, 2.0 * away, away.norm(dim=-1, keepdim=True)], dim=-1))
        told = self.context(context)
        around = _gather(points, neighbours) - points[:, :, None]
        x = self.layers[0](x, around, neighbours, told)
        x = self.layers[1](x, around, neighbours, told)
        x, _ = self.look[0](x, told)
        x = self.layers[2](x, around, neighbours, told)
        x, seen = self.look[1](x, told)
        out = self.votes(x).unflatten(-1, (MODES, 10))
        position = (points[:, :, None] + 0.2 * out[..., 1:4]).flatten(1, 2)
        hand = self.hand(torch.cat([seen, told], dim=-1))
        return Votes(out[..., 0].flatten(1).log_softmax(dim=1), position, out[..., 4:].flatten(1, 2), hand)


class _EdgeLayer(nn.Module):
    """x + max over neighbours of relu(A x_i + B x_j + C (p_j - p_i)), scaled and shifted by what is to be done."""

    def __init__(self) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(WIDTH)
        self.own, self.other = nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, WIDTH, bias=False)
        self.offset = nn.Linear(3, WIDTH, bias=False)
        self.told = nn.Linear(128, 2 * WIDTH)
        self.out = nn.Linear(WIDTH, WIDTH)

    def forward(self, x: Tensor, around: Tensor, neighbours: Tensor, told: Tensor) -> Tensor:
        """Return the features after the layer, (b, n, WIDTH)."""
        normed = self.norm(x)
        edges = _gather(self.other(normed), neighbours) + self.offset(20.0 * around)
        pooled = torch.relu(edges.amax(dim=2) + self.own(normed))
        scale, shift = self.told(told)[:, None].chunk(2, dim=-1)
        return x + self.out(torch.relu(pooled * (1.0 + scale) + shift))  # type: ignore[no-any-return]


class _Overview(nn.Module):
    """Tell every point what all points together look like: the strongest features, and those that attention picks."""

    def __init__(self) -> None:
        super().__init__()
        self.features, self.score = nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, 4)
        self.mix = nn.Sequential(nn.Linear(5 * WIDTH + 128, 128), nn.GELU(), nn.Linear(128, WIDTH))
        self.back = nn.Linear(2 * WIDTH, WIDTH)

    def forward(self, x: Tensor, told: Tensor) -> tuple[Tensor, Tensor]:
        """Return the features of the points, (b, n, WIDTH), and the overview, (b, WIDTH)."""
        features = torch.relu(self.features(x))
        picked = torch.einsum("bnh,bnw->bhw", self.score(x).softmax(dim=1), features).flatten(1)
        seen = self.mix(torch.cat([features.amax(dim=1), picked, told], dim=-1))
        spread = seen[:, None].expand(-1, x.shape[1], -1)
        return x + self.back(torch.relu(torch.cat([x, spread], dim=-1))), seen


def _gather(values: Tensor, rows: Tensor) -> Tensor:
    """Return values (b, n, w) of rows (b, n, k) as (b, n, k, w)."""
    b, n, k = rows.shape
    flat = (rows + (torch.arange(b, device=rows.device) * n)[:, None, None]).reshape(-1)
    return values.reshape(b * n, -1).index_select(0, flat).view(b, n, k, -1)
