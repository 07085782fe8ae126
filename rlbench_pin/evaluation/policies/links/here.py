"""A policy that runs in this process: an object, or one of those that are too simple to go wrong."""

from __future__ import annotations

import traceback

import numpy as np

from rlbench_pin.evaluation.policies.exchange import checked_action, shown_observation
from rlbench_pin.evaluation.policies.faults import LONGEST_DETAIL, PolicyFault
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.observation import Observation


class PolicyHere:
    """A policy in this process. Nothing can end it when it hangs, and its memory is ours.

    Args:
        policy: The policy.

    Raises:
        PolicySettingsError: Its action mode or what it observes is not of this package.
    """

    def __init__(self, policy: Policy) -> None:
        self._policy = policy
        self.settings = PolicySettings.of(policy.action_mode, policy.obs_config, getattr(policy, "max_steps", None))

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode."""
        try:
            self._policy.reset(instruction, context)
        except Exception as error:  # whatever the policy raises
            raise _crash(error) from error

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,)."""
        try:
            action = self._policy.act(shown_observation(observation))
        except Exception as error:  # whatever the policy raises
            raise _crash(error) from error
        return checked_action(action)

    def close(self) -> None:
        """Nothing was started."""


def _crash(error: Exception) -> PolicyFault:
    return PolicyFault("crashed", "".join(traceback.format_exception_only(error)).strip()[:LONGEST_DETAIL])
