"""The trained policy: loads weights and settings into a policy of Stable-Baselines3."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.sac.policies import SACPolicy

from rlbench_pin.baselines.cloning.model import nearest_sentence
from rlbench_pin.baselines.cloning.training import MODEL, SETTINGS, ModelFileError, read_tensors, trained_joints, trained_tasks
from rlbench_pin.baselines.reinforcement.algorithms import NETWORK
from rlbench_pin.baselines.reinforcement.environment import ALGORITHMS, EPSILON, as_command, features
from rlbench_pin.baselines.reinforcement.training import KIND
from rlbench_pin.environment import JointPositionActionMode, low_dim_config
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.evaluation.policies.policy_server import NoPolicy
from rlbench_pin.observation import Observation

CLIP = 10.0
"""Features are clipped at this number of standard deviations from their mean, as in training."""
PATIENCE = 2
"""Maximum length of an episode, as a multiple of the length in training."""
_KNOWN = {"seen": int, "actions": int, "ticks": int, "episode_steps": int, "instructions": list}
"""Required keys of `settings.json` and their types."""


class TrainedActor:
    """Trained network of one task.

    Args:
        folder: Folder of the task, in the folder of the models.
        algorithm: `ppo` or `sac`.
        settings: Content of `settings.json`.
        device: Device of torch.

    Raises:
        ModelFileError: The weights are missing, damaged, or do not fit.
    """

    def __init__(self, folder: Path, algorithm: str, settings: dict[str, Any], device: str = "cpu") -> None:
        path = folder / MODEL
        tensors, _ = read_tensors(path)
        seen = gymnasium.spaces.Box(-np.inf, np.inf, (settings["seen"],), np.float32)
        acts = gymnasium.spaces.Box(-1.0, 1.0, (settings["actions"],), np.float32)
        network: list[int] = list(NETWORK)
        if algorithm == "ppo":
            self._policy: BasePolicy = ActorCriticPolicy(seen, acts, _no_schedule, net_arch=network)
        else:
            self._policy = SACPolicy(seen, acts, _no_schedule, net_arch=network).actor
        try:
            self._policy.load_state_dict({n.removeprefix("policy/"): t for n, t in tensors.items() if n.startswith("policy/")})
            self._mean, variance = tensors["seen/mean"].numpy(), tensors["seen/var"].numpy()
        except (RuntimeError, KeyError) as error:
            raise ModelFileError(path, "does not match the settings in its folder") from error
        self._policy.to(torch.device(device)).set_training_mode(False)
        self._deviation = np.sqrt(variance + EPSILON)

    def act(self, observation: Observation) -> np.ndarray:
        """Return the most likely action, between -1 and 1, shape (joints + 1,)."""
        seen = features(observation)
        if seen.shape != self._mean.shape:
            raise NoPolicy(
                f"The model has {self._mean.size} inputs, the observation {seen.size} numbers. Use the same task and arm."
            )
        scaled = np.clip((seen - self._mean) / self._deviation, -CLIP, CLIP).astype(np.float32)
        return np.asarray(self._policy.predict(scaled, deterministic=True)[0])


class ReinforcementPolicy:
    """Joint differences from reinforcement learning; the name of the task, or the instruction, selects the network.

    Args:
        folder: Output folder of `rlbench-pin train ppo` or `sac`.
        algorithm: `ppo` or `sac`.
        device: Device of torch.

    Raises:
        NoPolicy: There is no such algorithm.
        ModelFileError: The folder contains no such model.
    """

    def __init__(self, folder: str | Path, algorithm: str, device: str = "cpu") -> None:
        if algorithm not in ALGORITHMS:
            raise NoPolicy(f"There is no algorithm '{algorithm}'. Use ppo or sac.")
        self.action_mode, self.obs_config = JointPositionActionMode(), low_dim_config()
        self._settings = _models(Path(folder), algorithm)
        self.joint_names = trained_joints(Path(folder), self._settings)
        self._folder, self._algorithm, self._device = Path(folder), algorithm, device
        self.max_steps = PATIENCE * max(s["episode_steps"] * s["ticks"] for s in self._settings.values())
        self._actors: dict[str, TrainedActor] = {}
        self._task, self._high, self._tick, self._unit = next(iter(self._settings)), np.zeros(0), 0, np.zeros(0)

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Choose the network of the task, or of the task with the most similar instruction."""
        self._task = context.task if context.task in self._settings else self._meant(instruction)
        if self._task not in self._actors:
            settings = self._settings[self._task]
            self._actors[self._task] = TrainedActor(self._folder / self._task, self._algorithm, settings, self._device)
        self._high, self._tick = np.asarray(context.action_high, dtype=float), 0

    def act(self, observation: Observation) -> np.ndarray:
        """Return joint differences [rad] and the position of a finger [m], shape (joints + 1,)."""
        if self._tick % self._settings[self._task]["ticks"] == 0:
            self._unit = self._actors[self._task].act(observation)
        self._tick += 1
        return as_command(self._unit, self._high)

    def _meant(self, instruction: str) -> str:
        """Return the task with the most similar instruction."""
        owners = [(task, said) for task, settings in self._settings.items() for said in settings["instructions"]]
        return owners[nearest_sentence(instruction, [said for _, said in owners])][0]


def _models(folder: Path, algorithm: str) -> dict[str, dict[str, Any]]:
    """Return the settings of the models in a folder by task.

    Raises:
        ModelFileError: There is no such model, or a file lacks a key.
    """
    found = trained_tasks(folder, KIND.format(algorithm))
    for task, settings in found.items():
        wrong = [name for name, kind in _KNOWN.items() if not isinstance(settings.get(name), kind) or not settings[name]]
        if wrong or not all(isinstance(said, str) for said in settings["instructions"]):
            raise ModelFileError(folder / task / SETTINGS, f"is damaged: {wrong or ['instructions']}")
    return found


def policy(folder: str, algorithm: str, device: str = "cpu") -> ReinforcementPolicy:
    """Return the policy in a folder that `rlbench-pin train ppo` or `sac` wrote."""
    return ReinforcementPolicy(folder, algorithm, device)


def _no_schedule(_: float) -> float:
    """Return the learning rate 0: the loaded policy is not trained."""
    return 0.0
