"""Training of the cloning baseline on recorded demonstrations, and its model files."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load, save
from torch.utils.tensorboard import SummaryWriter

from rlbench_pin.baselines.cloning.model import CHUNK, SENTENCE_SIZE, ChunkNetwork, ChunkSizes, Examples, read_examples
from rlbench_pin.datasets import write_whole
from rlbench_pin.datasets.manifest import digest
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.spatial import FloatArray

MODEL, SETTINGS, CHECKPOINT = "model.safetensors", "settings.json", "checkpoint.safetensors"
FORMAT = 1
"""Version of the format of `settings.json`."""


class ModelFileError(RlbenchPinError):
    """A trained model is missing, damaged, or of another kind; the message has the file and the command that trains one."""

    def __init__(self, path: Path, why: str) -> None:
        self.path = path
        super().__init__(f"'{path}' {why}. `rlbench-pin train` writes a folder with models.")


def write_tensors(path: Path, tensors: Mapping[str, torch.Tensor], **notes: str) -> None:
    """Write tensors and texts to one file, atomically."""
    plain = {name: tensor.detach().to("cpu").contiguous() for name, tensor in tensors.items()}
    write_whole(path, save(plain, metadata=notes))


def read_tensors(path: Path) -> tuple[dict[str, torch.Tensor], dict[str, str]]:
    """Return the tensors and texts of a file.

    Raises:
        ModelFileError: The file is missing or damaged.
    """
    if not path.is_file():
        raise ModelFileError(path, "does not exist")
    try:
        with safe_open(path, framework="pt") as file:
            notes = dict(file.metadata() or {})
        return load(path.read_bytes()), notes
    except (SafetensorError, OSError) as error:
        raise ModelFileError(path, f"is damaged ({error})") from error


def write_settings(path: Path, kind: str, settings: Mapping[str, Any]) -> None:
    """Write the settings of a model and its training as JSON."""
    content = {"format": FORMAT, "kind": kind, **settings}
    write_whole(path, (json.dumps(content, indent=1, sort_keys=True) + "\n").encode())


def read_settings(path: Path, kind: str) -> dict[str, Any]:
    """Return the settings that `write_settings` wrote.

    Raises:
        ModelFileError: The file is missing, damaged, or about another kind of model.
    """
    if not path.is_file():
        raise ModelFileError(path, "does not exist")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, OSError) as error:
        raise ModelFileError(path, f"is damaged ({error})") from error
    if not isinstance(content, dict) or (content.pop("format", None), content.pop("kind", None)) != (FORMAT, kind):
        raise ModelFileError(path, f"is not about a model of kind '{kind}'")
    return content


def fill_network(network: torch.nn.Module, path: Path) -> None:
    """Load the tensors of a file into a network.

    Raises:
        ModelFileError: The file is missing, damaged, or belongs to another network.
    """
    tensors, _ = read_tensors(path)
    try:
        network.load_state_dict(tensors)
    except RuntimeError as error:
        raise ModelFileError(path, "does not match the settings in its folder") from error


def trained_tasks(folder: Path, kind: str) -> dict[str, dict[str, Any]]:
    """Return the settings of the models in a folder by task; each model is in a folder with the name of its task.

    Raises:
        ModelFileError: The folder contains no model of this kind.
    """
    found = {p.parent.name: read_settings(p, kind) for p in sorted(Path(folder).glob(f"*/{SETTINGS}"))}
    if not found:
        raise ModelFileError(Path(folder), f"contains no model of kind '{kind}'")
    return found


def trained_joints(folder: Path, trained: Mapping[str, Mapping[str, Any]]) -> tuple[str, ...]:
    """Return the names of the arm joints that the models of a folder were trained for; empty if unknown.

    Args:
        folder: The folder.
        trained: The settings of its models by task, from `trained_tasks`.

    Raises:
        ModelFileError: The models were trained for different arms.
    """
    found = {tuple(settings["joint_names"]) for settings in trained.values() if settings.get("joint_names")}
    if len(found) > 1:
        raise ModelFileError(folder, f"contains models for different arms: {sorted(found)}")
    return next(iter(found), ())


Losses = dict[str, torch.Tensor]
"""Name -> loss; `total` is the minimised loss."""
ModuleT = TypeVar("ModuleT", bound=torch.nn.Module)
CURVE_EVERY = 20
"""Number of steps between points of the curves."""


@dataclass(frozen=True)
class TrainConfig:
    """Settings of the training of a network."""

    steps: int = 3000
    """Number of batches."""
    batch: int = 128
    """Number of examples in a batch."""
    rate: float = 1e-3
    """Learning rate after the first hundred steps; it falls to 0 along half a cosine."""
    decay: float = 1e-4
    """Weight decay of AdamW."""
    seed: int = 0
    """Seed of initial weights, batches and augmentation."""
    device: str = "cpu"
    """Device of torch: `cpu`, `cuda`, `cuda:1` ... On the CPU, the same seed gives byte-identical weights."""
    checkpoint_every: int = 250
    """Number of steps between checkpoints."""


class Learner(Protocol):
    """A network that learns from examples."""

    @property
    def network(self) -> torch.nn.Module:
        """The network, on the device of the training."""
        ...

    def losses(self, rng: np.random.Generator, batch: int) -> Losses:
        """Draw a batch and return its losses."""
        ...

    def settings(self) -> dict[str, Any]:
        """Return the settings that the policy needs in addition to the weights, for JSON."""
        ...


def seeded(make: Callable[[], ModuleT], seed: int) -> ModuleT:
    """Return a network whose initial weights depend on a seed; the global generator of torch does not change."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return make()


def learning_rate(config: TrainConfig, step: int) -> float:
    """Return the learning rate of a step: a linear warm-up over 100 steps times a cosine decay to 0."""
    warm = min(1.0, (step + 1) / 100.0)
    return config.rate * warm * 0.5 * (1.0 + math.cos(math.pi * step / config.steps))


def train(
    learner: Learner,
    config: TrainConfig,
    folder: Path,
    on_step: Callable[[int, float], None] = lambda step, loss: None,
    stop: threading.Event | None = None,
) -> bool:
    """Train a network, write it to `model.safetensors`, and return whether the training is complete.

    An interrupted training continues from its last checkpoint and gives byte-identical weights.

    Args:
        learner: Learner with its network on the device of the settings; the weights of a checkpoint replace its weights.
        config: Settings of the training.
        folder: Output folder.
        on_step: Function that is called with the number of completed steps, and the loss.
        stop: Event that ends the training at a checkpoint.

    Raises:
        ModelFileError: The checkpoint is damaged, or has other settings, demonstrations or cameras.
    """
    network, identity = learner.network, _identity(learner, config)
    optimizer = torch.optim.AdamW(network.parameters(), lr=config.rate, weight_decay=config.decay)
    done = _restore(network, optimizer, identity, folder)
    writer = SummaryWriter(str(folder / "curves"), purge_step=done)
    try:
        for step in range(done, config.steps):
            if (is_ending := stop is not None and stop.is_set()) or step % config.checkpoint_every == 0:
                _checkpoint(network, optimizer, identity, folder, step)
            if is_ending:
                return False
            found = _step(learner, optimizer, config, step)
            _draw(writer, found, step + 1)
            on_step(step + 1, found["total"])
    finally:
        writer.close()
    write_tensors(folder / MODEL, network.state_dict())
    (folder / CHECKPOINT).unlink(missing_ok=True)
    return True


def train_task(
    kind: str,
    make_learner: Callable[[Path], Learner],
    roots: Sequence[Path],
    task: str,
    folder: Path,
    config: TrainConfig,
    on_step: Callable[[int, float], None],
    stop: threading.Event | None,
) -> bool:
    """Train a model of one task and write it to `folder/task`; an interrupted training continues.

    Args:
        kind: The kind of the model.
        make_learner: Function that creates the learner from the dataset in a folder.
        roots: Folders of datasets; the first that contains the task is read.
        task: Name of the task.
        folder: Folder in which the folder of the model is created.
        config: Settings of the training.
        on_step: Function that is called with the number of completed steps, and the loss.
        stop: Event that ends the training at a checkpoint.

    Returns:
        Whether the training is complete.
    """
    place = Path(folder) / task
    if (place / MODEL).exists() and (place / SETTINGS).exists():
        return True
    learner = make_learner(Path(next((r for r in roots if (Path(r) / task).is_dir()), roots[0])))
    finished = train(learner, config, place, on_step, stop)
    if finished:
        how = asdict(replace(config, device="cpu"))
        write_settings(place / SETTINGS, kind, {"task": task, **learner.settings(), "train": how})
    return finished


def _step(learner: Learner, optimizer: torch.optim.Optimizer, config: TrainConfig, step: int) -> dict[str, float]:
    """Do one step of the optimizer and return the losses."""
    for group in optimizer.param_groups:
        group["lr"] = learning_rate(config, step)
    found = learner.losses(np.random.default_rng([config.seed, step]), config.batch)
    optimizer.zero_grad(set_to_none=True)
    found["total"].backward()
    torch.nn.utils.clip_grad_norm_(learner.network.parameters(), 1.0)
    optimizer.step()
    return {name: float(value.detach()) for name, value in found.items()}


def _draw(writer: SummaryWriter, losses: dict[str, float], step: int) -> None:
    """Write the losses for TensorBoard, every `CURVE_EVERY` steps."""
    if step % CURVE_EVERY == 0:
        for name, value in losses.items():
            writer.add_scalar(f"loss/{name}", value, step)


def _checkpoint(network: torch.nn.Module, optimizer: torch.optim.Optimizer, identity: str, folder: Path, step: int) -> None:
    """Write the state of network and optimizer after `step` steps."""
    tensors = {f"network/{name}": value for name, value in network.state_dict().items()}
    for index, state in optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer/{index}/{name}": torch.as_tensor(value) for name, value in state.items()}
    write_tensors(folder / CHECKPOINT, tensors, step=str(step), config=identity)


def _restore(network: torch.nn.Module, optimizer: torch.optim.Optimizer, identity: str, folder: Path) -> int:
    """Restore network and optimizer from the checkpoint and return the number of completed steps; 0 without a checkpoint."""
    path = folder / CHECKPOINT
    if not path.exists():
        return 0
    tensors, notes = read_tensors(path)
    if notes.get("config") != identity:
        raise ModelFileError(path, f"was started with {notes.get('config')}, not {identity}; delete it to restart")
    network.load_state_dict({n.removeprefix("network/"): t for n, t in tensors.items() if n.startswith("network/")})
    state: dict[int, dict[str, torch.Tensor]] = {}
    for name, tensor in tensors.items():
        if name.startswith("optimizer/"):
            _, index, key = name.split("/")
            state.setdefault(int(index), {})[key] = tensor
    optimizer.load_state_dict({"state": state, "param_groups": optimizer.state_dict()["param_groups"]})
    return int(notes["step"])


def _identity(learner: Learner, config: TrainConfig) -> str:
    """Return what a resumed training must share, as text: the settings, and what the learner says of its demonstrations."""
    examples = digest(json.dumps(learner.settings(), sort_keys=True).encode())[:8]
    settings = f"steps={config.steps} batch={config.batch} rate={config.rate} decay={config.decay} seed={config.seed}"
    return f"{settings} cameras and demonstrations={examples}"


KIND = "cloning"
JOINT_NOISE = 0.02
"""Standard deviation of the noise on joint positions [rad]. The targets have no noise, so the network learns corrections."""
STATE_NOISE = 0.002
"""Standard deviation of the noise on the task state [m] or [rad]."""
TIME_NOISE = 0.1
"""Standard deviation of the noise on the time [s]."""
SHIFT = 2
"""Maximum random shift of images of `IMAGE_SIZE` [px]."""
MIN_SPREAD = 0.02
"""Lower bound of the standard deviations for normalization, so that constant inputs stay near 0."""


class ChunkLearner:
    """A network for the examples of one task, and its losses on batches of them.

    Args:
        examples: Examples of the task.
        cameras: Cameras to learn from instead of the task state.
        device: Device of torch.
        seed: Seed of the initial weights.
    """

    def __init__(self, examples: Examples, cameras: Sequence[str] = (), device: str = "cpu", seed: int = 0) -> None:
        self._examples, self._device = examples, torch.device(device)
        width, state = examples.joints.shape[1], examples.task_state.shape[1]
        sizes = ChunkSizes(width, state, SENTENCE_SIZE, tuple(cameras), CHUNK)
        self.network = seeded(lambda: ChunkNetwork(sizes), seed).to(self._device)
        numbers = np.concatenate([examples.joints, examples.opening, examples.time, examples.task_state], axis=1)
        steps = examples.targets - examples.joints[:, None]
        self._fill(self.network.mean, numbers.mean(axis=0))
        self._fill(self.network.spread, np.maximum(numbers.std(axis=0), MIN_SPREAD))
        self._fill(self.network.reach, np.maximum(steps.std(axis=0), MIN_SPREAD))
        self._numbers, width = numbers, examples.joints.shape[1]
        self._noise = np.r_[np.full(width, JOINT_NOISE), 0.0, TIME_NOISE, np.full(state, STATE_NOISE)]

    def losses(self, rng: np.random.Generator, batch: int) -> Losses:
        """Draw a batch and return its losses: of the commands, divided by their standard deviation, and of the gripper."""
        data = self._examples
        rows = rng.integers(len(self._numbers), size=batch)
        numbers = self._numbers[rows] + rng.normal(size=(batch, len(self._noise))) * self._noise
        steps = data.targets[rows] - numbers[:, None, : data.joints.shape[1]]
        sentences = [data.sentences[e] for e in data.episode[rows]]
        sentence = np.stack([each[rng.integers(len(each))] for each in sentences])
        seen = as_images(shifted(data.images[rows], rng), self._device)
        found, gripper = self.network(self._tensor(numbers), self._tensor(sentence), seen)
        arm = torch.nn.functional.smooth_l1_loss(found / self.network.reach, self._tensor(steps) / self.network.reach, beta=0.1)
        grip = torch.nn.functional.binary_cross_entropy_with_logits(gripper, self._tensor(data.gripper[rows]).clamp(0.0, 1.0))
        return {"total": arm + 0.1 * grip, "arm": arm, "hand": grip}

    def settings(self) -> dict[str, Any]:
        """Return the sizes of the network, and the instructions, number, longest time and joints of its demonstrations."""
        return {
            "sizes": asdict(self.network.sizes),
            "instructions": list(self._examples.instructions),
            "demonstrations": len(self._examples.sentences),
            "longest": float(self._examples.time.max()),
            "joint_names": list(self._examples.joint_names),
        }

    def _tensor(self, values: FloatArray) -> torch.Tensor:
        return torch.as_tensor(values, dtype=torch.float32, device=self._device)

    def _fill(self, buffer: torch.Tensor, values: FloatArray) -> None:
        buffer.copy_(self._tensor(values))


def shifted(images: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return images (b, cameras, h, w, 3), each shifted at random by up to `SHIFT` pixels; border pixels are repeated."""
    batch, cameras, height, width = images.shape[:4]
    down, right = rng.integers(-SHIFT, SHIFT + 1, size=(2, batch, cameras, 1))
    rows = np.clip(np.arange(height) + down, 0, height - 1)[..., None]
    columns = np.clip(np.arange(width) + right, 0, width - 1)[:, :, None]
    return images[np.arange(batch)[:, None, None, None], np.arange(cameras)[:, None, None], rows, columns]


def as_images(images: np.ndarray, device: torch.device) -> torch.Tensor:
    """Convert uint8 images (b, cameras, h, w, 3) to the input of a network: (b, cameras, 3, h, w), from 0 to 1."""
    return torch.as_tensor(images, device=device).movedim(-1, 2).float() / 255.0


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
    """Train behaviour cloning of one task and write it to `folder/task`, see `train_task`.

    Args:
        roots: Folders of datasets; the first that contains the task is read.
        task: Name of the task.
        folder: Folder in which the folder of the model is created.
        config: Settings of the training.
        demos: Number of demonstrations to learn from; -1 uses all.
        cameras: Cameras to learn from instead of the task state.
        on_step: Function that is called with the number of completed steps, and the loss.
        stop: Event that ends the training at a checkpoint.

    Returns:
        Whether the training is complete.
    """

    def make_learner(root: Path) -> ChunkLearner:
        return ChunkLearner(read_examples(root, task, demos, cameras), cameras, config.device, config.seed)

    return train_task(KIND, make_learner, roots, task, folder, config, on_step, stop)


def load_cloning(folder: Path, device: str = "cpu") -> tuple[ChunkNetwork, float]:
    """Return the network in a folder, and the longest time in its training data [s].

    Raises:
        ModelFileError: A file is missing or damaged.
    """
    settings = read_settings(folder / SETTINGS, KIND)
    sizes = dict(settings["sizes"])
    network = ChunkNetwork(ChunkSizes(**{**sizes, "cameras": tuple(sizes["cameras"])}))
    fill_network(network, folder / MODEL)
    return network.to(device).eval(), float(settings["longest"])
