"""Training of the reinforcement learning baselines, with checkpoints and learning curves."""

from __future__ import annotations

import functools
import json
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecEnv, VecNormalize

from rlbench_pin.baselines.cloning.training import (
    CHECKPOINT,
    MODEL,
    SETTINGS,
    ModelFileError,
    read_tensors,
    write_settings,
    write_tensors,
)
from rlbench_pin.baselines.reinforcement.algorithms import (
    DISCOUNT,
    WARM_UP,
    Experience,
    ImitatingSac,
    Model,
    freeze_policy,
    gather,
    make_model,
    start_from_demonstrations,
)
from rlbench_pin.baselines.reinforcement.environment import EPSILON, TICKS, VALIDATION_SEED, LearningEnv, ReinforcementConfig
from rlbench_pin.datasets import write_whole
from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.results.plots import COLORS, check_plot, write_plot
from rlbench_pin.rates import wilson

CURVE = "curve.json"
"""File of the learning curve, in the folder of the task."""


@dataclass(frozen=True)
class CurvePoint:
    """Results of one segment of a training."""

    steps: int
    """Number of training decisions so far; 0 before the first segment."""
    episodes: int
    """Number of episodes that ended in this segment."""
    reward: float | None
    """Mean reward of these episodes; None without episodes."""
    success: float | None
    """Success rate of these episodes, with exploration; None without episodes."""
    successes: int | None = None
    """Number of successful validation episodes with the most likely action; None without a validation after this segment."""
    of: int = 0
    """Number of validation episodes; their seeds do not occur in training."""

    @property
    def validation(self) -> float | None:
        """Success rate of the validation, with the most likely action; None without one."""
        return None if self.successes is None else self.successes / self.of

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % Wilson interval of the validation; None without one."""
        return None if self.successes is None else wilson(self.successes, self.of)


def write_curve(folder: Path, points: Sequence[CurvePoint]) -> None:
    """Write a curve with its confidence intervals."""
    rows = [{**asdict(point), "wilson_95": _rounded(point.interval)} for point in points]
    write_whole(folder / CURVE, (json.dumps(rows, indent=1) + "\n").encode())


def read_curve(folder: Path | str) -> list[CurvePoint]:
    """Return the curve of a training: one point before the first segment, and one per finished segment.

    Args:
        folder: Folder of the task, in the folder of the models. Without a curve the result is empty.

    Raises:
        ModelFileError: The file is damaged.
    """
    path = Path(folder) / CURVE
    if not path.exists():
        return []
    try:
        rows: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
        return [CurvePoint(**{name: value for name, value in row.items() if name != "wilson_95"}) for row in rows]
    except (ValueError, TypeError, AttributeError, OSError) as error:
        raise ModelFileError(path, f"is damaged ({error})") from error


def _rounded(interval: tuple[float, float] | None) -> list[float] | None:
    """Return the bounds of an interval with four decimals."""
    return None if interval is None else [round(end, 4) for end in interval]


_WIDTH, _HEIGHT = 6.4, 3.2
"""Size of the image [inch]."""
WINDOW = 5
"""Number of segments over which the success rate with exploration is averaged."""


def draw_curves(path: Path | str, curves: Mapping[str, Sequence[CurvePoint]]) -> Path:
    """Draw learning curves: lines for success with exploration, dots for the validation of the most likely action.

    Args:
        path: A PNG or SVG file.
        curves: 1 to 8 curves: label -> points.

    Raises:
        InvalidValue: The file has another extension, there are too many curves, or one has no points.
        StorageError: The file cannot be written.
    """
    path = check_plot(path, len(curves))
    empty = next((name for name, points in curves.items() if not points), None)
    if empty is not None:
        raise InvalidValue("curve", empty, "has no points yet: a training writes one after each segment")
    return write_plot(path, lambda: _figure(curves))


def _figure(curves: Mapping[str, Sequence[CurvePoint]]) -> Figure:
    figure = Figure(figsize=(_WIDTH, _HEIGHT), layout="constrained")
    axes = figure.add_subplot()
    for color, (name, points) in zip(COLORS, curves.items()):
        explored = [(p.steps, p.success, p.episodes) for p in points if p.success is not None]
        if explored:
            steps, successes, episodes = np.array(explored, dtype=float).T
            axes.plot(steps, _smooth(successes * episodes) / _smooth(episodes), color=color, linewidth=1.2)
        _draw_validation(axes, color, points)
        axes.plot([], [], "o-", color=color, markersize=4, label=name)
    axes.set_ylim(0.0, 1.0)
    axes.set_xlim(left=0.0)
    axes.set_yticks(np.linspace(0.0, 1.0, 6), [f"{v} %" for v in range(0, 101, 20)])
    axes.set(xlabel="decisions of training", ylabel="success (dots: without exploring)")
    axes.grid(color="#cccccc", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.legend(loc="outside upper center", ncols=min(3, len(curves)), frameon=False)
    return figure


def _draw_validation(axes: Axes, color: str, points: Sequence[CurvePoint]) -> None:
    """Draw validations as dots with vertical confidence intervals."""
    validated = [(p.steps, p.validation, *p.interval) for p in points if p.validation is not None and p.interval is not None]
    steps, rates, low, high = np.array(validated, dtype=float).reshape(-1, 4).T
    axes.vlines(steps, low, high, colors=color, linewidth=0.8, clip_on=False, zorder=3)
    axes.plot(steps, rates, "o", color=color, markersize=4, clip_on=False, zorder=3)


def _smooth(values: np.ndarray) -> np.ndarray:
    """Return for each segment the sum over the last `WINDOW` segments, shape (n,)."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    ends = np.arange(1, len(sums))
    return np.asarray(sums[ends] - sums[np.maximum(ends - WINDOW, 0)])


KIND = "reinforcement {}"
"""Kind of the model in `settings.json`, with the algorithm."""
_ROWS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
"""Arrays of a replay buffer in a checkpoint."""
_SHOWN = ("seen", "then", "actions", "rewards", "ends")
"""Arrays of its demonstrations in a checkpoint, named as in `Experience`."""

Tensors = dict[str, torch.Tensor]


def write_checkpoint(folder: Path, config: ReinforcementConfig, model: Model, env: VecNormalize, segments: int) -> None:
    """Write the state of a training, from which it can be resumed.

    Args:
        folder: Folder of the task.
        config: Settings of the training.
        model: The current model.
        env: Environments of the model, with the statistics for normalization.
        segments: Number of finished segments.
    """
    tensors = {**_learned(model), **_statistics(env)}
    if isinstance(model, ImitatingSac):
        tensors["log_ent_coef"] = model.log_ent_coef  # type: ignore[assignment]
        tensors |= _buffer(model.replay_buffer)
    state = {"segments": segments, "steps": model.num_timesteps, "config": config.identity()}
    write_tensors(folder / CHECKPOINT, tensors, state=json.dumps(state, sort_keys=True))  # several notes have no fixed order


def read_checkpoint(folder: Path, config: ReinforcementConfig, model: Model, env: VecNormalize) -> int:
    """Restore a model from the checkpoint, and return the number of finished segments; 0 without a checkpoint.

    Raises:
        ModelFileError: The file is damaged, or was written with other settings.
    """
    path = folder / CHECKPOINT
    if not path.exists():
        return 0
    tensors, notes = read_tensors(path)
    try:
        state = json.loads(notes.get("state", "{}"))
        if state["config"] != config.identity():
            raise ModelFileError(path, f"was begun with {state['config']}, not {config.identity()}; name another --out")
        model.set_parameters(_nested(model, tensors), device=config.device)
        if isinstance(model, ImitatingSac):
            with torch.no_grad():
                model.log_ent_coef.copy_(tensors["log_ent_coef"])  # type: ignore[union-attr]
            _fill(model, tensors)
        for name, statistics in (("seen", env.obs_rms), ("returns", env.ret_rms)):
            statistics.mean, statistics.var = (tensors[f"{name}/{key}"].numpy() for key in ("mean", "var"))  # type: ignore[union-attr]
            statistics.count = float(tensors[f"{name}/count"])  # type: ignore[union-attr]
        model.num_timesteps = int(state["steps"])
        return int(state["segments"])
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        raise ModelFileError(path, f"does not fit this task or version ({error})") from error


def write_model(
    folder: Path, config: ReinforcementConfig, model: Model, env: VecNormalize, said: list[str], joints: Sequence[str]
) -> None:
    """Write the policy, the statistics of its observations, and its settings.

    Args:
        folder: Folder of the task.
        config: Settings of the training.
        model: The trained model.
        env: Environments of the model, with the statistics for normalization.
        said: Instructions of all variations of the task.
        joints: Names of the arm joints.
    """
    kept = model.policy if config.algorithm == "ppo" else model.policy.actor  # type: ignore[union-attr]
    weights = {f"policy/{name}": tensor for name, tensor in kept.state_dict().items()}  # type: ignore[union-attr]
    statistics = {name: tensor for name, tensor in _statistics(env).items() if name.startswith("seen/")}
    write_tensors(folder / MODEL, {**weights, **statistics})
    sizes = {"seen": int(np.prod(env.observation_space.shape)), "actions": int(np.prod(env.action_space.shape))}  # type: ignore[arg-type]
    saved = {"ticks": TICKS, "steps": model.num_timesteps, "instructions": said, "joint_names": list(joints)}
    write_settings(folder / SETTINGS, KIND.format(config.algorithm), {**config.identity(), **sizes, **saved})


def _learned(model: Model) -> Tensors:
    """Return weights and states of optimizers: `weights/policy/...`, `optimizers/<name>/<number>/<part>`."""
    tensors: Tensors = {}
    for name, state in model.get_parameters().items():
        if name.endswith("optimizer"):
            for number, parts in state["state"].items():
                tensors |= {f"optimizers/{name}/{number}/{part}": torch.as_tensor(value) for part, value in parts.items()}
        else:
            tensors |= {f"weights/{name}/{key}": tensor for key, tensor in state.items()}
    return tensors


def _nested(model: Model, tensors: Tensors) -> dict[str, Any]:
    """Return the argument of `set_parameters`; the inverse of `_learned`."""
    nested: dict[str, Any] = {}
    for name, state in model.get_parameters().items():
        if name.endswith("optimizer"):
            states: dict[int, Tensors] = {}
            for key, tensor in _below(tensors, f"optimizers/{name}/").items():
                number, part = key.split("/")
                states.setdefault(int(number), {})[part] = tensor
            nested[name] = {"state": states, "param_groups": state["param_groups"]}
        else:
            nested[name] = _below(tensors, f"weights/{name}/")
    return nested


def _below(tensors: Tensors, prefix: str) -> Tensors:
    """Return the tensors whose names start with a prefix, under the rest of their names."""
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}


def _statistics(env: VecNormalize) -> Tensors:
    """Return mean, variance and count of observations (`seen/...`) and returns (`returns/...`)."""
    tensors: Tensors = {}
    for name, statistics in (("seen", env.obs_rms), ("returns", env.ret_rms)):
        for key in ("mean", "var", "count"):
            tensors[f"{name}/{key}"] = torch.as_tensor(np.asarray(getattr(statistics, key), dtype=np.float64))
    return tensors


def _buffer(buffer: Any) -> Tensors:
    """Return the rows and the write position of a replay buffer, and the rows of its demonstrations."""
    filled = buffer.buffer_size if buffer.full else buffer.pos
    tensors = {f"buffer/{name}": torch.as_tensor(getattr(buffer, name)[:filled].copy()) for name in _ROWS}
    tensors["buffer/pos"], tensors["buffer/full"] = torch.tensor(buffer.pos), torch.tensor(buffer.full)
    shown: ReplayBuffer | None = buffer.demonstrations
    if shown is not None:
        names = zip(_SHOWN, ("observations", "next_observations", "actions", "rewards", "dones"))
        tensors |= {f"shown/{name}": torch.as_tensor(getattr(shown, row)[:, 0].copy()) for name, row in names}
    return tensors


def _fill(model: ImitatingSac, tensors: Tensors) -> None:
    """Fill the replay buffer of a new model; the inverse of `_buffer`."""
    buffer = model.replay_buffer
    for name in _ROWS:
        rows = tensors[f"buffer/{name}"].numpy()
        getattr(buffer, name)[: len(rows)] = rows
    buffer.pos, buffer.full = int(tensors["buffer/pos"]), bool(tensors["buffer/full"])
    if "shown/seen" in tensors:
        buffer.hold(Experience(*(tensors[f"shown/{name}"].numpy() for name in _SHOWN)))


CURVE_IMAGE = "curve.png"


@dataclass(frozen=True)
class TrainingProgress:
    """Progress of a training."""

    steps: int
    """Number of decisions so far."""
    total: int
    """Total number of decisions."""
    point: CurvePoint | None
    """Results of the last segment; None before it ends."""
    note: str = ""
    """Current work other than acting and learning."""


OnProgress = Callable[[TrainingProgress], None]


def train_reinforcement(
    config: ReinforcementConfig,
    out: Path,
    on_progress: OnProgress = lambda progress: None,
    stop: threading.Event | None = None,
) -> bool:
    """Train a policy for one task into the folder with the name of the task, and return whether the training is complete.

    An interrupted training continues from its last checkpoint; on the CPU it ends with the same weights as an uninterrupted one.
    With more steps than before, it continues after its end.

    Args:
        config: Settings of the training.
        out: Folder of the models, with one folder per task.
        on_progress: Function that is called after each step and after each segment.
        stop: Event that ends the training within a step; the interrupted segment is repeated after a restart.

    Raises:
        ModelFileError: The checkpoint is damaged, or has other settings.
        DemoError: Too few demonstrations succeed.
        TaskEnvironmentError: The task has no shaped reward.
    """
    with (
        _one_thread(),
        closing(LearningEnv(config.task, config.shaped, config.longest)) as eval_env,
        closing(_envs(config)) as env,
    ):
        training = _Training(config, Path(out) / config.task, env, eval_env, on_progress)
        return all(training.do(segment, stop) for segment in range(training.begin(), config.segments))


class _Training:
    """One training: the model, its environments and its curve."""

    def __init__(
        self, config: ReinforcementConfig, folder: Path, env: VecNormalize, eval_env: LearningEnv, on_progress: OnProgress
    ) -> None:
        self._config, self._folder, self._env, self._eval_env, self._report = (
            config,
            folder,
            env,
            eval_env,
            on_progress,
        )
        self._model = make_model(config, env)
        self._total = config.segments * config.segment
        self._points: list[CurvePoint] = []
        self._instructions = _instructions(eval_env)

    def begin(self) -> int:
        """Restore the checkpoint, or imitate demonstrations and validate; return the number of finished segments."""
        config, model = self._config, self._model
        done = read_checkpoint(self._folder, config, model, self._env)
        self._points = read_curve(self._folder)[: done + 1] if done else []
        if done == 0:
            if config.demonstrations:
                experience = gather(self._eval_env, config.demonstrations, self._report_demonstrations)
                start_from_demonstrations(model, self._env, experience, config.imitation_steps)
            self._keep(CurvePoint(0, 0, None, None, *self._validate()))
        model.set_logger(configure(str(self._folder / "tensorboard"), ["tensorboard"]))
        return done

    def do(self, segment: int, stop: threading.Event | None) -> bool:
        """Train for one segment, and return whether it was finished.

        Each segment starts new episodes and new generators, which are seeded by the seed and the segment.
        """
        config, model = self._config, self._model
        watch = _Watch(self._total, self._report, stop)
        model.set_env(self._env, force_reset=True)
        model.set_random_seed(int(np.random.SeedSequence([config.seed, segment]).generate_state(1)[0] >> 1))
        freeze_policy(model, config.demonstrations > 0 and segment < WARM_UP[config.algorithm])
        model.learn(config.segment, callback=watch, reset_num_timesteps=False, log_interval=4)
        if watch.is_stopped:
            return False
        validated = (segment + 1) % config.validate_every == 0 or segment + 1 == config.segments
        point = watch.point(self._validate() if validated else (None, 0))
        _log(model, point)
        self._keep(point)
        write_checkpoint(self._folder, config, model, self._env, segment + 1)
        return True

    def _keep(self, point: CurvePoint) -> None:
        """Append a point to the curve, and write the model if no earlier validation was better."""
        best = max((p.validation or 0.0 for p in self._points), default=0.0)
        self._points.append(point)
        write_curve(self._folder, self._points)
        if point.validation is not None:
            draw_curves(self._folder / CURVE_IMAGE, {f"{self._config.algorithm} {self._config.task}": self._points})
            if point.validation >= best:
                joints = self._eval_env.task.runtime.description.arm_joints
                write_model(self._folder, self._config, self._model, self._env, self._instructions, joints)
        self._report(TrainingProgress(self._model.num_timesteps, self._total, point))

    def _validate(self) -> tuple[int, int]:
        """Return the numbers of successful and of all validation episodes."""
        return validate(self._model, self._env, self._eval_env, self._config.validation_episodes)

    def _report_demonstrations(self, found: int, wanted: int) -> None:
        self._report(TrainingProgress(0, self._total, None, f"demonstration {found} of {wanted}"))


def validate(model: Model, env: VecNormalize, eval_env: LearningEnv, episodes: int) -> tuple[int, int]:
    """Return the numbers of successful and of all validation episodes with the most likely action; the model does not learn."""
    successes = 0
    for index in range(episodes):
        seen, info = eval_env.reset(options={"episode": VALIDATION_SEED + index})
        over = False
        while not over:
            action, _ = model.predict(env.normalize_obs(seen), deterministic=True)  # type: ignore[arg-type]
            seen, _, ended, cut, info = eval_env.step(action)
            over = ended or cut
        successes += bool(info["is_success"])
    return successes, episodes


class _Watch(BaseCallback):
    """Counts steps and episodes of one segment, and ends it when `stop` is set."""

    def __init__(self, total: int, on_progress: OnProgress, stop: threading.Event | None) -> None:
        super().__init__()
        self.is_stopped = False
        self._total, self._report, self._stop = total, on_progress, stop
        self._rewards: list[float] = []
        self._successes: list[bool] = []

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                self._rewards.append(float(info["episode"]["r"]))
                self._successes.append(bool(info["is_success"]))
        self._report(TrainingProgress(self.num_timesteps, self._total, None))
        self.is_stopped = self._stop is not None and self._stop.is_set()
        return not self.is_stopped

    def point(self, validation: tuple[int | None, int]) -> CurvePoint:
        """Return the results of the segment."""
        if not self._rewards:
            return CurvePoint(self.num_timesteps, 0, None, None, *validation)
        reward, success = float(np.mean(self._rewards)), float(np.mean(self._successes))
        return CurvePoint(self.num_timesteps, len(self._rewards), reward, success, *validation)


def _log(model: Model, point: CurvePoint) -> None:
    """Write a point of the curve for TensorBoard."""
    for name, value in (("reward", point.reward), ("success", point.success), ("validation", point.validation)):
        if value is not None:
            model.logger.record(f"segments/{name}", value)
    model.logger.dump(point.steps)


def _envs(config: ReinforcementConfig) -> VecNormalize:
    """Return the environments with normalized observations (mean 0, variance 1); PPO gets shaped rewards of variance 1.

    With demonstrations the statistics stay fixed: new ones would change the actions of the imitating policy.
    """
    make = functools.partial(_env, config.task, config.shaped, config.longest)
    many = config.workers > 1
    envs: VecEnv = SubprocVecEnv([make] * config.workers, start_method="spawn") if many else DummyVecEnv([make])
    norm_reward, learns = config.algorithm == "ppo" and config.shaped, config.demonstrations == 0
    return VecNormalize(envs, training=learns, norm_reward=norm_reward, gamma=DISCOUNT, epsilon=EPSILON)


def _env(task: str, shaped: bool, longest: int) -> Monitor:
    return Monitor(LearningEnv(task, shaped, longest), info_keywords=("is_success",))


def _instructions(eval_env: LearningEnv) -> list[str]:
    """Return the distinct instructions of all variations of the task."""
    found: dict[str, None] = {}
    for variation in range(eval_env.task.variation_count()):
        instructions, _ = eval_env.task.reset(seed=0, variation=variation)
        found |= dict.fromkeys(instructions)
    return list(found)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Limit torch to one thread; networks of this size are slower with several."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
