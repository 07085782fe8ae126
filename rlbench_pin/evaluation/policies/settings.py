"""What a policy asks of an evaluation, as plain data that goes into results files and over sockets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rlbench_pin.environment.actions.mode import ActionMode
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.evaluation.policies.action_description import describe_action_mode, make_action_mode
from rlbench_pin.evaluation.policies.faults import PolicySettingsError
from rlbench_pin.evaluation.policies.observation_description import describe_observations, make_observations
from rlbench_pin.values import as_whole


@dataclass(frozen=True)
class PolicySettings:
    """What a policy asks of an evaluation. Everything in it is JSON; action modes and noise are those of this package.

    Raises:
        PolicySettingsError: The data name no action mode or observation, or a wrong value of one (also an InvalidValue).
    """

    action_mode: dict[str, Any]
    """Classes and parameters of the action mode: `mode`, `arm`, `arm_settings`, `gripper`, `gripper_settings`."""
    observation: dict[str, Any] = field(default_factory=dict)
    """What is observed: low-dimensional fields, and `cameras` with their products and sizes. What is left out is off."""
    max_steps: int | None = None
    """Actions of an episode that the policy suggests; None leaves it to the evaluation."""

    def __post_init__(self) -> None:
        """Fill in what was left out, so that equal settings are equal data."""
        object.__setattr__(self, "action_mode", describe_action_mode(make_action_mode(self.action_mode)))
        object.__setattr__(self, "observation", describe_observations(make_observations(self.observation)))
        if self.max_steps is not None:
            as_whole(self.max_steps, "max_steps of a policy", PolicySettingsError, least=1)

    @classmethod
    def of(cls, action_mode: object, obs_config: object, max_steps: object = None) -> PolicySettings:
        """Return the settings of a policy.

        Args:
            action_mode: An action mode of this package, or its plain data.
            obs_config: What it observes, or that as plain data.
            max_steps: Actions of an episode that it suggests, or None.

        Raises:
            PolicySettingsError: One of them is neither, or of the policy's own.
        """
        modes = action_mode if isinstance(action_mode, Mapping) else describe_action_mode(action_mode)  # type: ignore[arg-type]
        seen = obs_config if isinstance(obs_config, Mapping) else describe_observations(obs_config)  # type: ignore[arg-type]
        return cls(dict(modes), dict(seen), max_steps)  # type: ignore[arg-type]

    def make_action_mode(self) -> ActionMode:
        """Return a new action mode."""
        return make_action_mode(self.action_mode)

    def make_obs_config(self) -> ObservationConfig:
        """Return new settings of observations."""
        return make_observations(self.observation)
