"""Observations and actions as gymnasium spaces: what is in them, in which bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from rlbench_pin.environment.actions.mode import ActionSpec
from rlbench_pin.environment.observations.boxes import boxed
from rlbench_pin.environment.observations.config import LOW_DIM_FIELDS, Instant
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError, InvalidValue, shown
from rlbench_pin.observation import LOW_DIM, Observation
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array

VISION_CAMERAS = ("left_shoulder", "right_shoulder", "wrist", "front")
"""Cameras of vision observations unless others are asked for."""

_QUATERNION = ("qx", "qy", "qz", "qw")

GymObservation = dict[str, np.ndarray]


def observation_space(runtime: Runtime, cameras: Sequence[str], image_size: tuple[int, int]) -> spaces.Dict:
    """Return the space of the observations of a running task: float32 boxes, and a uint8 picture (h, w, 3) for each camera.

    The bounds are those of the simulation: joint torques are capped at the effort limits, joint speeds by the simulator.
    """
    instant = Instant(runtime.world, runtime.model, runtime.task)
    boxes: dict[str, spaces.Space[Any]] = {
        name: spaces.Box(*_float32(*part.bounds(instant))) for name, part in LOW_DIM_FIELDS.items() if name in LOW_DIM
    }
    width, height = image_size
    for name in cameras:
        boxes[f"{name}_rgb"] = spaces.Box(0, 255, (height, width, 3), np.uint8)
    return spaces.Dict(boxes)


def _float32(low: FloatArray, high: FloatArray) -> tuple[np.ndarray, np.ndarray]:
    return low.astype(np.float32), high.astype(np.float32)


def as_gym_observation(observation: Observation, space: spaces.Dict) -> GymObservation:
    """Return an observation as a member of its space.

    Numbers beyond their bound, which only an unstable simulation gives, are clipped. A task state that is shorter
    than the space, as when a variation has fewer objects, is filled up with zeros.

    Raises:
        TaskError: The task state is longer than the space.
    """
    return {name: _fitted(name, getattr(observation, name), box) for name, box in space.spaces.items()}  # type: ignore[arg-type]


def _fitted(name: str, value: object, box: spaces.Box) -> np.ndarray:
    return np.asarray(value) if box.dtype == np.uint8 else boxed(name, value, box.low, box.high)


def action_space(spec: ActionSpec) -> spaces.Box:
    """Return the box (n,), float32, that an action specification spans."""
    return spaces.Box(*_float32(spec.low, spec.high))


def checked_action(action: object, spec: ActionSpec) -> FloatArray:
    """Return an action as float64 (n,), its quaternion, where it has one, brought to unit length.

    A box cannot say that four numbers are a rotation, so that no policy over a box could name one.

    Raises:
        InvalidActionError: The shape is wrong, or a number is NaN or infinite. That is the caller's mistake, not the robot's.
    """
    try:
        values = as_array(action, "An action").copy()
    except InvalidValue as error:
        raise InvalidActionError(f"{error} Check the policy's output.") from error
    if values.shape != (spec.size,) or not np.isfinite(values).all():
        names = ", ".join(spec.names)
        raise InvalidActionError(
            f"An action is {spec.size} finite numbers ({names}), not {shown(action)}. Check the policy's output."
        )
    where = _quaternion_index(spec.names)
    norm = np.linalg.norm(values[where])
    if where and norm > 1e-6:
        values[where] /= norm
    return values


def _quaternion_index(names: Sequence[str]) -> list[int]:
    return [names.index(name) for name in _QUATERNION if name in names]
