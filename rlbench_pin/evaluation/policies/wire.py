"""Messages between an evaluation and a policy: observations and contexts as maps, and validated actions."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from typing import Any

import numpy as np

from rlbench_pin.environment.observations.config import ModelObservationConfig
from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.policies.policy import PolicyContext, PolicyFault
from rlbench_pin.observation import FIELDS, Observation
from rlbench_pin.values import as_array

SENSED = ("mask_names", "joint_poses", "wrist_camera_matrix", *(field.name for field in fields(ModelObservationConfig)))
"""Entries of `misc` that policies get, in addition to those of cameras. Policies get neither the variation nor all
instructions."""
_CAMERA = re.compile(r"\w+_camera_(extrinsics|intrinsics|near|far)")


def encode_observation(observation: Observation) -> dict[str, Any]:
    """Return the part of an observation that a policy gets, as a map of arrays, numbers and names."""
    encoded: dict[str, Any] = plain(visible_fields(observation))
    return encoded


def visible_fields(observation: Observation) -> dict[str, Any]:
    """Return the fields of an observation that a policy gets; arrays are shared."""
    misc = {name: value for name, value in observation.misc.items() if name in SENSED or _CAMERA.fullmatch(name)}
    return {**{name: value for name, value in vars(observation).items() if value is not None}, "misc": misc}


def decode_observation(sent: Mapping[str, Any]) -> Observation:
    """Return the observation in a map of fields."""
    observation = Observation(**{name: value for name, value in sent.items() if name in FIELDS or name == "misc"})
    for name in sent:
        if name not in FIELDS and name != "misc":  # images of extra cameras
            setattr(observation, name, sent[name])
    return observation


def plain(value: object) -> Any:
    """Return a value as arrays, numbers, text, lists and maps; dataclasses become maps."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    return value


def encode_context(context: PolicyContext) -> dict[str, Any]:
    """Return a context as a map."""
    return asdict(context)


def decode_context(sent: Mapping[str, Any]) -> PolicyContext:
    """Return the context in a map; entries of a later version are left out."""
    known = [field.name for field in fields(PolicyContext)]
    values: dict[str, Any] = {name: tuple(v) if isinstance(v, list) else v for name, v in sent.items() if name in known}
    return PolicyContext(**values)


def validate_action(action: object) -> np.ndarray:
    """Return an action as float64, shape (n,). The action mode checks n and the bounds.

    Raises:
        PolicyFault: The action is not a vector of finite numbers.
    """
    try:
        values = as_array(action, "An action")
    except InvalidValue as error:
        raise PolicyFault("wrong answer", f"`act` returned a {type(action).__name__}, not an array of numbers.") from error
    if values.ndim != 1 or len(values) == 0:
        raise PolicyFault("wrong answer", f"`act` returned an array of shape {values.shape}; an action has the shape (n,).")
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        where = ", ".join(map(str, bad[:8]))
        raise PolicyFault("wrong answer", f"`act` returned NaN or infinity at index {where}.")
    return np.array(values, dtype=np.float64)
