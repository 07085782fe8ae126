"""A training on disk: tensors alone, so that what goes on from it is what would have gone on; and the model that comes of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.vec_env import VecNormalize

from rlbench_pin.evaluation.baselines.cloning.storage import (
    CHECKPOINT,
    MODEL,
    SETTINGS,
    ModelFileError,
    read_tensors,
    write_settings,
    write_tensors,
)
from rlbench_pin.evaluation.baselines.reinforcement.algorithms import Model
from rlbench_pin.evaluation.baselines.reinforcement.config import ReinforcementConfig
from rlbench_pin.evaluation.baselines.reinforcement.demonstrations import Experience
from rlbench_pin.evaluation.baselines.reinforcement.features import TICKS
from rlbench_pin.evaluation.baselines.reinforcement.off_policy import ImitatingSac

KIND = "reinforcement {}"
_ROWS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
_SHOWN = ("seen", "then", "actions", "rewards", "ends")

Tensors = dict[str, torch.Tensor]


def write_checkpoint(folder: Path, config: ReinforcementConfig, model: Model, env: VecNormalize, legs: int) -> None:
    """Write everything that the training goes on from.

    Args:
        folder: Of the task.
        config: What is trained.
        model: As it is now.
        env: Its environments, with the statistics of what was seen.
        legs: How many legs are done.
    """
    tensors = {**_learned(model), **_statistics(env)}
    if isinstance(model, ImitatingSac):
        tensors["log_ent_coef"] = model.log_ent_coef  # type: ignore[assignment]
        tensors |= _buffer(model.replay_buffer)
    state = {"legs": legs, "steps": model.num_timesteps, "config": config.identity()}
    write_tensors(folder / CHECKPOINT, tensors, state=json.dumps(state, sort_keys=True))  # one note: several have no order


def read_checkpoint(folder: Path, config: ReinforcementConfig, model: Model, env: VecNormalize) -> int:
    """Bring a new model to where a training was, and return how many legs were done; 0 where there is no check point.

    Raises:
        ModelFileError: The file is damaged, or of other settings.
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
        return int(state["legs"])
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        raise ModelFileError(path, f"does not fit this task or version ({error})") from error


def write_model(folder: Path, config: ReinforcementConfig, model: Model, env: VecNormalize, said: list[str]) -> None:
    """Write the policy with the statistics of what it sees, and what it was trained on.

    Args:
        folder: Of the task.
        config: What was trained.
        model: The model.
        env: Its environments.
        said: Instructions of the task, of all variations.
    """
    kept = model.policy if config.algorithm == "ppo" else model.policy.actor  # type: ignore[union-attr]
    weights = {f"policy/{name}": tensor for name, tensor in kept.state_dict().items()}  # type: ignore[union-attr]
    statistics = {name: tensor for name, tensor in _statistics(env).items() if name.startswith("seen/")}
    write_tensors(folder / MODEL, {**weights, **statistics})
    sizes = {"seen": int(np.prod(env.observation_space.shape)), "actions": int(np.prod(env.action_space.shape))}  # type: ignore[arg-type]
    content: dict[str, Any] = {**config.identity(), **sizes, "ticks": TICKS, "steps": model.num_timesteps, "instructions": said}
    write_settings(folder / SETTINGS, KIND.format(config.algorithm), content)


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
    """Return what `set_parameters` takes."""
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
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}


def _statistics(env: VecNormalize) -> Tensors:
    tensors: Tensors = {}
    for name, statistics in (("seen", env.obs_rms), ("returns", env.ret_rms)):
        for key in ("mean", "var", "count"):
            tensors[f"{name}/{key}"] = torch.as_tensor(np.asarray(getattr(statistics, key), dtype=np.float64))
    return tensors


def _buffer(buffer: Any) -> Tensors:
    """Return what a buffer of ours holds, and where it writes next."""
    filled = buffer.buffer_size if buffer.full else buffer.pos
    tensors = {f"buffer/{name}": torch.as_tensor(getattr(buffer, name)[:filled].copy()) for name in _ROWS}
    tensors["buffer/pos"], tensors["buffer/full"] = torch.tensor(buffer.pos), torch.tensor(buffer.full)
    shown: ReplayBuffer | None = buffer.demonstrations
    if shown is not None:
        names = zip(_SHOWN, ("observations", "next_observations", "actions", "rewards", "dones"))
        tensors |= {f"shown/{name}": torch.as_tensor(getattr(shown, row)[:, 0].copy()) for name, row in names}
    return tensors


def _fill(model: ImitatingSac, tensors: Tensors) -> None:
    """Fill the buffer of a new model."""
    buffer = model.replay_buffer
    for name in _ROWS:
        rows = tensors[f"buffer/{name}"].numpy()
        getattr(buffer, name)[: len(rows)] = rows
    buffer.pos, buffer.full = int(tensors["buffer/pos"]), bool(tensors["buffer/full"])
    if "shown/seen" in tensors:
        buffer.hold(Experience(*(tensors[f"shown/{name}"].numpy() for name in _SHOWN)))
