"""Checks of actions that programs call themselves."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.errors import InvalidActionError


def assert_action_shape(action: ArrayLike, expected_shape: tuple[int, ...]) -> None:
    """Raise InvalidActionError when an action has not the shape that is expected."""
    shape = np.shape(action)
    if shape != tuple(expected_shape):
        raise InvalidActionError(f"The action has shape {shape}; {tuple(expected_shape)} is needed.")
