"""The network of key frames: every point of the cloud votes where the tip has to go, and says how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from rlbench_pin.evaluation.baselines.key_frames.sights import CONTEXT, POINT

WIDTH = 64
MODES = 2
"""Votes of each point; a hand with two fingers can often come from either side."""


@dataclass(frozen=True)
class Scales:
    """What is large and what is small to a network."""

    position: float
    """Scale of the Laplace densities around votes [m]."""
    axes: float
    """The same in entries of the two rotated axes."""
    scene: float
    """Size of what it sees [m]."""
    gap: float
    """Distance of neighbouring points [m]."""
    rest: tuple[float, ...]
    """Axes of a hand to begin from (6,)."""


COARSE = Scales(0.015, 0.15, 0.5, 0.05, (1.0, 0.0, 0.0, 0.0, 0.0, -1.0))
FINE = Scales(0.004, 0.04, 0.1, 0.02, (1.0, 0.0, 0.0, 0.0, 0.0, 1.0))
"""Of the network that sees the whole scene, and of the one that sees the surroundings of what the first has found."""


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
    scales: Scales
    """Of the densities."""

    def log_density(self, position: Tensor, axes: Tensor) -> Tensor:
        """Return the logarithm of the mixture density, up to a constant, at tip poses: positions (b, 3) and axes (b, 6)."""
        far = (self.position - position[:, None]).abs().sum(-1) / self.scales.position
        turned = (self.axes - axes[:, None]).abs().sum(-1) / self.scales.axes
        return (self.weight - far - turned).logsumexp(dim=1)


class VoteNetwork(nn.Module):
    """Convolutions over neighbouring points (Wang et al. 2019), told what to do by sentence, hand and number of the step.

    Args:
        scales: What is large and small to it.
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
        """Return the votes on a batch of sights: points (b, n, POINT), neighbours (b, n, k), contexts (b, CONTEXT)."""
        where, rest = points[..., :3], points[..., 3:]
        away = (where - where[:, -1:]) / self.scales.scene
        x = self.first(torch.cat([where / self.scales.scene, rest, away, away.norm(dim=-1, keepdim=True)], dim=-1))
        told = self.context(context)
        place = where / self.scales.gap
        x = self.layers[0](x, place, neighbours, told)
        x = self.layers[1](x, place, neighbours, told)
        x, _ = self.look[0](x, told)
        x = self.layers[2](x, place, neighbours, told)
        x, seen = self.look[1](x, told)
        out = self.votes(x).unflatten(-1, (MODES, 10))
        position = (where[:, :, None] + 0.4 * self.scales.scene * out[..., 1:4]).flatten(1, 2)
        axes = (out[..., 4:] + out.new_tensor(self.scales.rest)).flatten(1, 2)
        hand = self.hand(torch.cat([seen, told], dim=-1))
        return Votes(out[..., 0].flatten(1).log_softmax(dim=1), position, axes, hand, self.scales)


class _EdgeLayer(nn.Module):
    """x + max over neighbours of relu(A x_i + B x_j + C (p_j - p_i)), scaled and shifted by what is to be done."""

    def __init__(self) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(WIDTH)
        self.own, self.other = nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, WIDTH, bias=False)
        self.offset = nn.Linear(3, WIDTH, bias=False)
        self.told = nn.Linear(128, 2 * WIDTH)
        self.out = nn.Linear(WIDTH, WIDTH)

    def forward(self, x: Tensor, place: Tensor, neighbours: Tensor, told: Tensor) -> Tensor:
        """Return the features after the layer, (b, n, WIDTH)."""
        normed, at = self.norm(x), self.offset(place)
        pooled = torch.relu(strongest_neighbour(self.other(normed) + at, neighbours) + self.own(normed) - at)
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


def strongest_neighbour(values: Tensor, rows: Tensor) -> Tensor:
    """Return the largest of values (b, n, w) among rows (b, n, k <= 8), (b, n, w).

    Gradients need only the row that is strongest. To find it, the last three bits of a number say which neighbour it is from:
    half the time of a maximum with indices on a CPU.
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
