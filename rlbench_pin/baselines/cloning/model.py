"""Networks of the cloning baseline: chunks of joint commands, from state or images, with encoded instructions."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from rlbench_pin.datasets import stored_demos
from rlbench_pin.environment.stored import resize
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.spatial import FloatArray

CHUNK = 20
"""Number of ticks of a predicted chunk."""
SECONDS = 0.05
"""Control tick [s]."""
IMAGE_SIZE = 64
"""Width and height of the input images of a network [px]."""


@dataclass(frozen=True)
class Examples:
    """All ticks of some demonstrations of one task, in order."""

    joints: FloatArray
    """Joint positions at each tick, (n, 7) [rad]."""
    opening: FloatArray
    """Whether the gripper is open, (n, 1)."""
    task_state: FloatArray
    """State of the task, (n, m); m = 0 for learning from images."""
    time: FloatArray
    """Time since the start, (n, 1) [s]."""
    episode: np.ndarray
    """Index of its demonstration, (n,)."""
    sentences: tuple[FloatArray, ...]
    """Encoded instructions of each demonstration, (k, size)."""
    targets: FloatArray
    """Commanded joint positions of the next `CHUNK` ticks, (n, CHUNK, 7) [rad]; after the end the last command is repeated."""
    gripper: FloatArray
    """Commanded opening of the same ticks, (n, CHUNK)."""
    images: np.ndarray
    """uint8 (n, cameras, IMAGE_SIZE, IMAGE_SIZE, 3); no cameras where the network learns from the task state."""
    instructions: tuple[str, ...]
    """All instructions of the demonstrations."""
    joint_names: tuple[str, ...] = ()
    """Joint names of the arm of the demonstrations; empty if unknown."""


def read_examples(root: Path, task: str, demos: int = -1, cameras: Sequence[str] = ()) -> Examples:
    """Read the first demonstrations of a task, spread over its variations, as examples.

    Args:
        root: Folder of a dataset.
        task: Name of the task.
        demos: Number of demonstrations; -1 reads all.
        cameras: Cameras whose colours are read instead of the task state.

    Raises:
        DatasetError: Too few demonstrations are stored, or they lack a field.
    """
    fields = ["joint_positions", "gripper_open", *([f"{c}_rgb" for c in cameras] or ["task_low_dim_state"])]
    rng = np.random.default_rng(0)
    return make_examples(stored_demos(root, task, demos, -1, rng=rng, fields=fields), cameras)


def make_examples(demos: Sequence[Demo], cameras: Sequence[str] = ()) -> Examples:
    """Return the examples of demonstrations.

    Raises:
        DatasetError: They lack actions, the task state or a camera.
    """
    parts = [_columns(demo, index, cameras) for index, demo in enumerate(demos)]
    if not parts:
        raise DatasetError("There are no demonstrations to learn from. Record some with `rlbench-pin record`.")
    stacked = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    instructions = [tuple(str(s) for s in demo[0].misc.get("descriptions", ())) or ("",) for demo in demos]
    sentences = tuple(np.stack([encode_sentence(s) for s in each]) for each in instructions)
    said = tuple(dict.fromkeys(s for each in instructions for s in each))
    return Examples(**stacked, sentences=sentences, instructions=said, joint_names=joint_names_of(demos))


def joint_names_of(demos: Sequence[Demo]) -> tuple[str, ...]:
    """Return the names of the arm joints of demonstrations; empty if unknown.

    Raises:
        DatasetError: The demonstrations have different arms.
    """
    found = {tuple(demo.joint_names): demo.robot for demo in demos if demo.joint_names}
    if len(found) > 1:
        arms = ", ".join(sorted(found.values()))
        raise DatasetError(f"The demonstrations have different arms: {arms}. Train one model for each arm.")
    return next(iter(found), ())


def images_of(observation: Observation, cameras: Sequence[str]) -> np.ndarray:
    """Return the colours of some cameras, uint8 (cameras, IMAGE_SIZE, IMAGE_SIZE, 3).

    Raises:
        DatasetError: One of them is missing.
    """
    found = [getattr(observation, f"{camera}_rgb", None) for camera in cameras]
    if any(image is None for image in found):
        raise DatasetError(f"An observation lacks the colours of one of {list(cameras)}. Record them with `--products rgb`.")
    return np.stack([resize(np.asarray(p), (IMAGE_SIZE, IMAGE_SIZE)) for p in found]) if found else _no_images()


def _no_images() -> np.ndarray:
    """Return an empty array of images, for zero cameras."""
    return np.zeros((0, IMAGE_SIZE, IMAGE_SIZE, 3), np.uint8)


def _columns(demo: Demo, index: int, cameras: Sequence[str]) -> dict[str, np.ndarray]:
    """Return the fields of `Examples` for one demonstration; its last frame has no action, so it is not an example."""
    frames = list(demo)[:-1]
    commands = [o.misc.get("joint_position_action") for o in list(demo)[1:]]
    if not frames or any(c is None for c in commands):
        raise DatasetError(
            "A demonstration lacks `joint_position_action`, which is the training target. Record it with `rlbench-pin record`."
        )
    if not cameras and any(o.task_low_dim_state is None for o in frames):
        raise DatasetError("A demonstration lacks `task_low_dim_state`. Record it, or select cameras to learn from.")
    ahead = np.minimum(np.arange(len(frames))[:, None] + np.arange(CHUNK), len(commands) - 1)
    chunks = np.asarray(commands)[ahead]
    state = [np.zeros(0) if cameras else np.asarray(o.task_low_dim_state) for o in frames]
    return {
        "joints": np.stack([np.asarray(o.joint_positions) for o in frames]),
        "opening": np.array([[float(o.gripper_open or 0.0)] for o in frames]),
        "task_state": np.stack(state),
        "time": np.arange(len(frames))[:, None] * SECONDS,
        "episode": np.full(len(frames), index),
        "targets": chunks[..., :-1],
        "gripper": chunks[..., -1],
        "images": np.stack([images_of(o, cameras) for o in frames]),
    }


SENTENCE_SIZE = 96
"""Length of an encoded sentence."""

_WORD = re.compile(r"[a-z0-9]+")


def encode_sentence(sentence: str) -> FloatArray:
    """Return a unit vector, shape (SENTENCE_SIZE,), that encodes the words of a sentence; zero for a sentence without words.

    Feature hashing (Weinberger et al. 2009): the hash of a word gives its index and its sign. So no vocabulary is needed, and
    new sentences can be encoded too. Pairs of neighbouring words have half the weight. Case and punctuation are ignored.
    """
    words = _WORD.findall(sentence.lower())
    vector = np.zeros(SENTENCE_SIZE)
    for term, weight in [*((w, 1.0) for w in words), *((f"{a} {b}", 0.5) for a, b in zip(words, words[1:]))]:
        number = int.from_bytes(hashlib.blake2b(term.encode(), digest_size=8).digest(), "little")
        vector[number // 2 % SENTENCE_SIZE] += weight if number % 2 else -weight
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector


def nearest_sentence(sentence: str, known: Sequence[str]) -> int:
    """Return the index of the most similar known sentence, by the cosine of their vectors; the first of equal ones."""
    vectors = np.stack([encode_sentence(k) for k in known])
    return int(np.argmax(vectors @ encode_sentence(sentence)))


WIDTH = 384
"""Size of the hidden layers."""
_FEATURES = 32
"""Number of image features per camera."""


@dataclass(frozen=True)
class ChunkSizes:
    """Input and output sizes of the network."""

    joints: int = 7
    """Number of joints of the arm."""
    task_state: int = 0
    """Length of the task state."""
    sentence: int = 96
    """Length of an encoded sentence."""
    cameras: tuple[str, ...] = field(default=())
    """Names of the cameras."""
    chunk: int = 20
    """Number of predicted ticks."""


class ChunkNetwork(nn.Module):
    """Residual multilayer perceptron on normalized inputs, with a small convolutional network per camera.

    The buffers `mean` and `spread` normalize the input, `reach` scales the output; they are stored with the weights.
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

    def forward(self, numbers: Tensor, sentence: Tensor, images: Tensor) -> tuple[Tensor, Tensor]:
        """Predict a chunk of commands.

        Args:
            numbers: Joint positions, opening, time and task state, (b, n).
            sentence: Encoded instructions, (b, s).
            images: Colours from 0 to 1, (b, cameras, 3, h, w).

        Returns:
            Joint commands relative to the current joint positions, (b, chunk, joints) [rad], and logits of an open gripper,
            (b, chunk).
        """
        seen = [eye(images[:, i]) for i, eye in enumerate(self.eyes)]
        x = self.first(torch.cat([(numbers - self.mean) / self.spread, sentence, *seen], dim=1))
        for block in self.blocks:
            x = block(x)
        out = self.last(x).unflatten(1, (self.sizes.chunk, self.sizes.joints + 1))
        return out[..., :-1] * self.reach, out[..., -1]


class _Block(nn.Module):
    """Residual block with layer norm."""

    def __init__(self) -> None:
        super().__init__()
        self.inner = nn.Sequential(nn.LayerNorm(WIDTH), nn.Linear(WIDTH, WIDTH), nn.GELU(), nn.Linear(WIDTH, WIDTH))

    def forward(self, x: Tensor) -> Tensor:
        """Return the output of the block, of the shape of `x`."""
        return x + self.inner(x)  # type: ignore[no-any-return]


class _Eye(nn.Module):
    """Convolutional network with a spatial softmax: it returns the mean image position of each feature (Levine et al. 2016)."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv2d(3, 32, 5, stride=2, padding=2),
            nn.ReLU(),
            nn.Conv2d(32, 32, 3, stride=2, padding=1),
            nn.ReLU(),
            nn.Conv2d(32, _FEATURES, 3, padding=1),
        )

    def forward(self, image: Tensor) -> Tensor:
        """Return x and y of each feature, from -1 to 1, (b, 2 * features)."""
        strong = self.layers(image)
        weight = strong.flatten(2).softmax(dim=2).view_as(strong)
        x = torch.linspace(-1.0, 1.0, strong.shape[3], device=image.device)
        y = torch.linspace(-1.0, 1.0, strong.shape[2], device=image.device)
        return torch.cat([(weight.sum(2) * x).sum(2), (weight.sum(3) * y).sum(2)], dim=1)
