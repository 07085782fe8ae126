"""Policies from files of Stable-Baselines3, for models that were trained on `rlbench_pin.gym`.

Such a file contains pickles: loading it runs the code in it. It contains the spaces of observations and actions, but not the
action mode.
"""

from __future__ import annotations

import importlib
import json
import zipfile
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from rlbench_pin.environment.actions import ActionMode
from rlbench_pin.environment.observations import ObservationConfig
from rlbench_pin.environment.observations.observe import boxed, boxed_settings, fitted
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.evaluation.policies.policy_server import NoPolicy
from rlbench_pin.evaluation.policies.settings import make_action_mode
from rlbench_pin.observation import LOW_DIM, Observation

_SIGNS = (("clip_range", "PPO"), ("target_policy_noise", "TD3"), ("target_entropy", "SAC"), ("gae_lambda", "A2C"))
"""Setting that only one algorithm has -> name of the algorithm; the first match counts."""
TOLERANCE = 1e-5
"""Relative tolerance of bounds of actions, because files contain them as float32."""


class Model(Protocol):
    """The used part of a model of Stable-Baselines3."""

    observation_space: Any
    action_space: Any

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[np.ndarray, Any]:
        """Return an action, and a state."""
        ...


def load(
    file: str, arm: str = "", gripper: str = "Discrete", algorithm: str = "", deterministic: bool = True, device: str = "cpu"
) -> Sb3Policy:
    """Load a model.

    Args:
        file: File that `model.save` wrote.
        arm: Arm mode of the training, such as `EndEffectorVelocity`, with its default settings. When empty, the default action
            mode of the environments of `rlbench_pin.gym`.
        gripper: Gripper mode of the training; used if `arm` is given.
        algorithm: `PPO`, `A2C`, `SAC`, `TD3` or `DDPG`. When empty, it is read from the file.
        deterministic: Whether to take the most likely action instead of a random one.
        device: Device of torch.

    Raises:
        NoPolicy: The file is not such a model, or the model was trained on other observations.
    """
    library = importlib.import_module("stable_baselines3")
    name = algorithm or _algorithm_of(file)
    if name not in ("PPO", "A2C", "SAC", "TD3", "DDPG"):
        raise NoPolicy(f"The algorithm '{name}' is not supported. Use PPO, A2C, SAC, TD3 or DDPG.")
    model: Model = getattr(library, name).load(file, device=device)
    parts = {"mode": "MoveArmThenGripper", "arm": arm, "gripper": gripper}
    return Sb3Policy(model, make_action_mode(parts if arm else {"mode": "JointPositionActionMode"}), deterministic)


def _algorithm_of(file: str) -> str:
    """Return the algorithm of a file from the names of its settings."""
    try:
        with zipfile.ZipFile(file) as archive:
            settings = json.loads(archive.read("data"))
        return next(name for sign, name in _SIGNS if sign in settings)
    except (zipfile.BadZipFile, KeyError, ValueError, StopIteration) as error:
        raise NoPolicy(f"'{file}' is not a model of PPO, A2C, SAC or TD3. If it is one of DDPG, add `algorithm=DDPG`.") from error


class Sb3Policy:
    """A policy with a model of Stable-Baselines3, which gets the observations of `rlbench_pin.gym`.

    Actions between -1 and 1, as from `gymnasium.wrappers.RescaleAction`, are scaled to the bounds of the action mode.

    Args:
        model: The model. Its observation space is that of an environment of `rlbench_pin.gym`, possibly flattened.
        action_mode: Action mode of the training.
        deterministic: Whether to take the most likely action.

    Raises:
        NoPolicy: The model was trained on other observations.
    """

    def __init__(self, model: Model, action_mode: ActionMode, deterministic: bool = True) -> None:
        self.action_mode, self._deterministic, self._model = action_mode, deterministic, model
        spaces = getattr(model.observation_space, "spaces", None)
        self._boxes: Mapping[str, Any] | None = spaces if isinstance(spaces, Mapping) else None
        self.obs_config = self._settings(spaces)
        self._scale: tuple[np.ndarray, np.ndarray] | None = None

    def _settings(self, spaces: object) -> ObservationConfig:
        if not isinstance(spaces, Mapping):
            if len(self._model.observation_space.shape or ()) != 1:
                raise NoPolicy(f"The model observes {self._model.observation_space}, unlike `rlbench_pin.gym`.{_HINT}")
            return boxed_settings((), (1, 1))
        images = {name: _image_size(box.shape) for name, box in spaces.items() if name.endswith("_rgb")}
        unknown = [name for name in spaces if name not in LOW_DIM and name not in images]
        if unknown or len(set(images.values())) > 1:
            raise NoPolicy(f"The model observes '{(unknown or list(images))[0]}' unlike `rlbench_pin.gym`.{_HINT}")
        return boxed_settings([name.removesuffix("_rgb") for name in images], next(iter(images.values()), (1, 1)))

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Compare the bounds of actions.

        Raises:
            NoPolicy: The bounds are not those of the training.
        """
        low, high = (np.asarray(ends, dtype=float) for ends in (context.action_low, context.action_high))
        own_low, own_high = (np.asarray(ends, dtype=float) for ends in _bounds(self._model.action_space))
        mode = type(self.action_mode.arm_action_mode).__name__
        if own_low.shape != low.shape:
            raise NoPolicy(f"The model's actions have {own_low.size} numbers, not {low.size} as {mode} on this arm.{_MODE}")
        unit = bool((own_low == -1.0).all() and (own_high == 1.0).all())
        if not unit and not (_same(own_low, low) and _same(own_high, high)):
            raise NoPolicy(f"The model's actions have other bounds than those of {mode} on this arm.{_MODE}")
        self._scale = ((high + low) / 2.0, (high - low) / 2.0) if unit else None

    def act(self, observation: Observation) -> np.ndarray:
        """Return the action that the model predicts, shape (n,)."""
        action = np.asarray(self._model.predict(self._seen(observation), deterministic=self._deterministic)[0], dtype=float)
        if self._scale is not None:
            action = self._scale[0] + self._scale[1] * action
        if hasattr(self.action_mode.arm_action_mode, "is_relative"):  # a pose: a box cannot say that four numbers are a rotation
            action[3:7] /= max(np.linalg.norm(action[3:7]), 1e-6)
        return action

    def _seen(self, observation: Observation) -> Any:
        if self._boxes is not None:
            return {name: fitted(name, getattr(observation, name), box) for name, box in self._boxes.items()}
        numbers = np.concatenate([np.atleast_1d(np.asarray(getattr(observation, name), dtype=float)) for name in sorted(LOW_DIM)])
        space = self._model.observation_space
        return boxed("the observation", numbers, space.low, space.high)


_HINT = " Write a factory that converts the observations, and use `module:factory`."
_MODE = " Pass the action mode of the training: `sb3:FILE?arm=EndEffectorVelocity&gripper=Discrete`."


def _image_size(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return width and height of images (h, w, 3), or (3, h, w) as Stable-Baselines3 turns them."""
    height, width = shape[1:] if shape[0] == 3 and shape[-1] != 3 else shape[:2]
    return int(width), int(height)


def _bounds(space: Any) -> tuple[np.ndarray, np.ndarray]:
    low, high = getattr(space, "low", None), getattr(space, "high", None)
    if low is None or high is None:
        raise NoPolicy(f"The model's actions are {space}, not numbers between bounds.{_HINT}")
    return low, high


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.allclose(a, b, rtol=TOLERANCE, atol=TOLERANCE))
