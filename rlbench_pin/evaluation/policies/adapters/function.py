"""Functions from observations to actions, as programs for gymnasium have them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rlbench_pin.environment.actions import ActionMode
from rlbench_pin.environment.observations import ObservationConfig
from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.observation import Observation


class FunctionPolicy:
    """A policy made of a function `observations -> action`.

    The function is given what gymnasium's environments deliver: a dict of the fields that are switched on, numbers as float32 of
    shape (n,), pictures as they are.

    Args:
        function: What acts; an action is an array of shape (n,), as `action_mode` takes it.
        action_mode: What actions mean.
        obs_config: What the function is given.
        begin: Called with the instruction at the start of each episode; None where nothing is remembered.
        max_steps: Actions of an episode that it suggests.

    Raises:
        PolicySettingsError: Action mode or observations are not of this package.
    """

    def __init__(
        self,
        function: Callable[[dict[str, np.ndarray]], Any],
        action_mode: ActionMode,
        obs_config: ObservationConfig,
        begin: Callable[[str], None] | None = None,
        max_steps: int | None = None,
    ) -> None:
        PolicySettings.of(action_mode, obs_config, max_steps)
        self.action_mode, self.obs_config, self.max_steps = action_mode, obs_config, max_steps
        self._function, self._begin = as_function(function, "function"), begin
        if begin is not None:
            as_function(begin, "begin")

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Tell the function that an episode begins."""
        if self._begin is not None:
            self._begin(instruction)

    def act(self, observation: Observation) -> np.ndarray:
        """Return what the function returns."""
        return np.asarray(self._function(as_dict(observation)))


def as_function(value: Callable[..., Any], what: str) -> Callable[..., Any]:
    """Return `value`, or raise InvalidValue when it cannot be called."""
    if not callable(value):
        raise InvalidValue(what, value, "has to be a function")
    return value


def as_dict(observation: Observation) -> dict[str, np.ndarray]:
    """Return the fields of an observation that are there, numbers as float32 of shape (n,), pictures as they are."""
    fields = {name: np.asarray(value) for name, value in vars(observation).items() if value is not None and name != "misc"}
    return {name: value if value.ndim > 1 else np.atleast_1d(value).astype(np.float32) for name, value in fields.items()}
