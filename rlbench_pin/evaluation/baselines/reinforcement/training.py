"""The training of one task, in legs: after each a check point from which the next would have begun in any case."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecEnv, VecNormalize

from rlbench_pin.evaluation.baselines.reinforcement.algorithms import DISCOUNT, WARM_UP, Model, hold_still, make_model, teach
from rlbench_pin.evaluation.baselines.reinforcement.checkpoint import read_checkpoint, write_checkpoint, write_model
from rlbench_pin.evaluation.baselines.reinforcement.config import ReinforcementConfig
from rlbench_pin.evaluation.baselines.reinforcement.curve import CurvePoint, read_curve, write_curve
from rlbench_pin.evaluation.baselines.reinforcement.demonstrations import gather
from rlbench_pin.evaluation.baselines.reinforcement.drawing import draw_curves
from rlbench_pin.evaluation.baselines.reinforcement.features import EPSILON
from rlbench_pin.evaluation.baselines.reinforcement.world import VALIDATION_SEED, LearningEnv

PICTURE = "curve.png"


@dataclass(frozen=True)
class TrainingProgress:
    """Where a training is."""

    steps: int
    """Decisions so far."""
    total: int
    """Decisions in all."""
    point: CurvePoint | None
    """The last leg; None before it ends."""
    note: str = ""
    """What is done beside acting and learning."""


OnProgress = Callable[[TrainingProgress], None]


def train_reinforcement(
    config: ReinforcementConfig,
    out: Path,
    on_progress: OnProgress = lambda progress: None,
    stop: threading.Event | None = None,
) -> bool:
    """Train a task into a folder of its name, and return whether it came to its end.

    What was begun there goes on from its last check point, and on the CPU ends with the same weights as if it had never been
    ended; with more steps than before, it is prolonged.

    Args:
        config: What is trained.
        out: Folder of the models; the task's is in it.
        on_progress: Called after every step, and after each leg.
        stop: Ends the training within a step; the leg is begun again when it goes on.

    Raises:
        ModelFileError: The check point is damaged, or of other settings.
        DemoError: Too few demonstrations succeed.
        TaskEnvironmentError: The task has no shaped reward.
    """
    with _one_thread(), closing(LearningEnv(config.task, config.shaped, config.longest)) as judge, closing(_envs(config)) as env:
        training = _Training(config, Path(out) / config.task, env, judge, on_progress)
        return all(training.do(leg, stop) for leg in range(training.begin(), config.legs))


class _Training:
    """A model, its environments and its curve."""

    def __init__(
        self, config: ReinforcementConfig, folder: Path, env: VecNormalize, judge: LearningEnv, on_progress: OnProgress
    ) -> None:
        self._config, self._folder, self._env, self._judge, self._tell = config, folder, env, judge, on_progress
        self._model = make_model(config, env)
        self._total = config.legs * config.leg
        self._points: list[CurvePoint] = []
        self._instructions = _instructions(judge)

    def begin(self) -> int:
        """Read the check point, or gather demonstrations and learn from them; return how many legs are done."""
        config, model = self._config, self._model
        done = read_checkpoint(self._folder, config, model, self._env)
        self._points = read_curve(self._folder)[: done + 1] if done else []
        if done == 0:
            if config.demonstrations:
                experience = gather(self._judge, config.demonstrations, self._tell_demonstrations)
                teach(model, self._env, experience, config.imitation_steps)
            self._keep(CurvePoint(0, 0, None, None, *self._validate()))
        model.set_logger(configure(str(self._folder / "tensorboard"), ["tensorboard"]))
        return done

    def do(self, leg: int, stop: threading.Event | None) -> bool:
        """Act and learn for one leg, from new episodes, with generators that follow from seed and leg; False when stopped."""
        config, model = self._config, self._model
        watch = _Watch(self._total, self._tell, stop)
        model.set_env(self._env, force_reset=True)
        model.set_random_seed(int(np.random.SeedSequence([config.seed, leg]).generate_state(1)[0] >> 1))
        hold_still(model, config.demonstrations > 0 and leg < WARM_UP[config.algorithm])
        model.learn(config.leg, callback=watch, reset_num_timesteps=False, log_interval=4)
        if watch.is_stopped:
            return False
        looks = (leg + 1) % config.validate_every == 0 or leg + 1 == config.legs
        point = watch.point(self._validate() if looks else (None, 0))
        _log(model, point)
        self._keep(point)
        write_checkpoint(self._folder, config, model, self._env, leg + 1)
        return True

    def _keep(self, point: CurvePoint) -> None:
        """Write a point, and the model where no look before was better."""
        best = max((p.validation or 0.0 for p in self._points), default=0.0)
        self._points.append(point)
        write_curve(self._folder, self._points)
        if point.validation is not None:
            draw_curves(self._folder / PICTURE, {f"{self._config.algorithm} {self._config.task}": self._points})
            if point.validation >= best:
                write_model(self._folder, self._config, self._model, self._env, self._instructions)
        self._tell(TrainingProgress(self._model.num_timesteps, self._total, point))

    def _validate(self) -> tuple[int, int]:
        return validate(self._model, self._env, self._judge, self._config.validation_episodes)

    def _tell_demonstrations(self, found: int, wanted: int) -> None:
        self._tell(TrainingProgress(0, self._total, None, f"demonstration {found} of {wanted}"))


def validate(model: Model, env: VecNormalize, judge: LearningEnv, episodes: int) -> tuple[int, int]:
    """Return in how many episodes the most likely action succeeded, and of how many; nothing is learned from it."""
    successes = 0
    for index in range(episodes):
        seen, info = judge.reset(options={"episode": VALIDATION_SEED + index})
        over = False
        while not over:
            action, _ = model.predict(env.normalize_obs(seen), deterministic=True)  # type: ignore[arg-type]
            seen, _, ended, cut, info = judge.step(action)
            over = ended or cut
        successes += bool(info["is_success"])
    return successes, episodes


class _Watch(BaseCallback):
    """Counts steps and episodes of one leg, and ends it when asked to."""

    def __init__(self, total: int, on_progress: OnProgress, stop: threading.Event | None) -> None:
        super().__init__()
        self.is_stopped = False
        self._total, self._tell, self._stop = total, on_progress, stop
        self._rewards: list[float] = []
        self._successes: list[bool] = []

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                self._rewards.append(float(info["episode"]["r"]))
                self._successes.append(bool(info["is_success"]))
        self._tell(TrainingProgress(self.num_timesteps, self._total, None))
        self.is_stopped = self._stop is not None and self._stop.is_set()
        return not self.is_stopped

    def point(self, validation: tuple[int | None, int]) -> CurvePoint:
        """Return what the leg came to."""
        if not self._rewards:
            return CurvePoint(self.num_timesteps, 0, None, None, *validation)
        reward, success = float(np.mean(self._rewards)), float(np.mean(self._successes))
        return CurvePoint(self.num_timesteps, len(self._rewards), reward, success, *validation)


def _log(model: Model, point: CurvePoint) -> None:
    """Put a point on TensorBoard's curves."""
    for name, value in (("reward", point.reward), ("success", point.success), ("validation", point.validation)):
        if value is not None:
            model.logger.record(f"legs/{name}", value)
    model.logger.dump(point.steps)


def _envs(config: ReinforcementConfig) -> VecNormalize:
    """Return the environments, what they show brought to mean 0 and variance 1, the shaped reward of PPO to variance 1.

    With demonstrations their statistics stay as they are: others would change what the imitating policy does.
    """
    make = functools.partial(_env, config.task, config.shaped, config.longest)
    many = config.workers > 1
    envs: VecEnv = SubprocVecEnv([make] * config.workers, start_method="spawn") if many else DummyVecEnv([make])
    norm_reward, learns = config.algorithm == "ppo" and config.shaped, config.demonstrations == 0
    return VecNormalize(envs, training=learns, norm_reward=norm_reward, gamma=DISCOUNT, epsilon=EPSILON)


def _env(task: str, shaped: bool, longest: int) -> Monitor:
    return Monitor(LearningEnv(task, shaped, longest), info_keywords=("is_success",))


def _instructions(judge: LearningEnv) -> list[str]:
    """Return the instructions of a task, of every variation, each once."""
    found: dict[str, None] = {}
    for variation in range(judge.task.variation_count()):
        instructions, _ = judge.task.reset(seed=0, variation=variation)
        found |= dict.fromkeys(instructions)
    return list(found)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let torch compute in one thread: networks this small are slower in several."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
