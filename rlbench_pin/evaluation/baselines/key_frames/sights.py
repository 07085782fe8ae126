"""What a network is given of one moment: a sample of the cloud in a frame, and everything else as a row of numbers."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import torch
from scipy.spatial import cKDTree

from rlbench_pin.evaluation.baselines.cloning.sentences import SENTENCE_SIZE, encode_sentence
from rlbench_pin.evaluation.baselines.key_frames.clouds import Cloud, near, thinned
from rlbench_pin.evaluation.baselines.key_frames.poses import Frame, axes_of
from rlbench_pin.evaluation.baselines.sight import PALETTE, distances
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

MOST_STEPS = 24
"""Key frames that are told apart by their number; later ones count as the last."""
CONTEXT = SENTENCE_SIZE + 9 + 1 + 3 + MOST_STEPS
"""Numbers that say what to do and how the hand stands."""
NAMED = 4
"""Colours of a sentence that count, in their order; a point is told how like it is to each."""
LIKENESS = 3.0
"""How fast likeness falls with the distance of two colours."""
POINT = 3 + 3 + NAMED + 1
"""Numbers of a point: position, colour, likeness, whether it is the tip."""
NEIGHBOURS = 8
"""Nearest points that a point is told about, itself among them."""
OVERVIEW = Frame(np.array([0.2, 0.0, TABLE_HEIGHT + 0.2]), np.eye(3))
"""From where the whole scene is seen."""
WHOLE, WHOLE_CELL = 512, 0.01
"""Points of the whole scene, and size of the grid of which each cell keeps one [m]."""
CLOSE, CLOSE_RADIUS = 256, 0.08
"""Points of the surroundings of a pose, and how far they reach [m]."""


@dataclass(frozen=True, eq=False)
class Told:
    """What is known at one moment beside the cloud."""

    sentence: str
    """What to do."""
    tip: FloatArray
    """Pose of the tip, (7,)."""
    opening: float
    """Whether the hand is open."""
    step: int
    """Number of key frames behind."""

    def row(self, frame: Frame, sentence: FloatArray) -> FloatArray:
        """Return it as numbers, as seen from a frame, (CONTEXT,), with the sentence encoded already."""
        number = np.zeros(MOST_STEPS)
        number[min(self.step, MOST_STEPS - 1)] = 1.0
        hand = [frame.points(self.tip[:3]), frame.axes(axes_of(self.tip)), [self.opening]]
        return np.concatenate([sentence, *hand, frame.rotation[2], number])


@dataclass(frozen=True, eq=False)
class Sight:
    """One input of a network; batches have one more dimension in front."""

    points: np.ndarray
    """(n, POINT), the tip last."""
    neighbours: np.ndarray
    """Numbers of near points, (n, NEIGHBOURS)."""
    context: np.ndarray
    """(CONTEXT,)."""

    @staticmethod
    def batch(sights: list[Sight], device: torch.device) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return points, neighbours and contexts of several on a device."""
        points, context = (
            torch.as_tensor(np.stack(c), dtype=torch.float32, device=device)
            for c in ([s.points for s in sights], [s.context for s in sights])
        )
        return points, torch.as_tensor(np.stack([s.neighbours for s in sights]), device=device), context


def sight(cloud: Cloud, told: Told, frame: Frame) -> Sight:
    """Return a sample of a cloud with the tip as one more point, as seen from a frame."""
    world = np.concatenate([cloud.points, told.tip[None, :3]])
    colors = np.concatenate([cloud.colors / 255.0, np.zeros((1, 3))])
    flag = np.zeros((len(world), 1))
    flag[-1] = 1.0
    rows = np.concatenate([frame.points(world), colors, likeness(colors, told.sentence), flag], axis=1)
    near_by = cKDTree(world).query(world, k=NEIGHBOURS)[1]
    return Sight(rows.astype(np.float32), near_by, told.row(frame, encode_sentence(told.sentence)))


def likeness(colors: FloatArray, sentence: str) -> FloatArray:
    """Return how like colours (n, 3) are to those that a sentence names, in its order, 0 to 1, (n, NAMED)."""
    named = [word for word in re.findall(r"[a-z]+", sentence.lower()) if word in PALETTE][:NAMED]
    like = np.zeros((len(colors), NAMED))
    for column, name in enumerate(named):
        like[:, column] = np.exp(-LIKENESS * distances(colors, name))
    return like


def overview(cloud: Cloud) -> Cloud:
    """Return the cloud with one point per cell of a coarse grid."""
    return cloud.where(thinned(cloud.points, WHOLE_CELL))


def whole(seen: Cloud, rng: np.random.Generator) -> Cloud:
    """Return a sample of an overview."""
    return seen.where(np.resize(rng.permutation(len(seen)), WHOLE - 1))


def close_up(cloud: Cloud, middle: FloatArray, rng: np.random.Generator) -> Cloud:
    """Return a sample of what is about a place (3,)."""
    return cloud.where(near(cloud.points, middle, CLOSE_RADIUS, CLOSE - 1, rng))
