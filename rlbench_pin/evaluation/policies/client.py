"""Policies as an evaluation sees them, wherever they run."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from rlbench_pin.evaluation.policies.faults import PolicyFault, PolicyReferenceError
from rlbench_pin.evaluation.policies.links.here import PolicyHere
from rlbench_pin.evaluation.policies.links.hosted import HostedPolicy
from rlbench_pin.evaluation.policies.links.loading import make_policy
from rlbench_pin.evaluation.policies.links.remote import RemotePolicy
from rlbench_pin.evaluation.policies.links.served import ServedPolicy
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext
from rlbench_pin.evaluation.policies.policy_server import NoPolicy
from rlbench_pin.evaluation.policies.references import FORMS, find_policy
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.observation import Observation
from rlbench_pin.values import as_number


class PolicyClient(Protocol):
    """A policy that runs somewhere: here, in a process of its own, or behind a socket.

    A `PolicyFault` costs the episode. After one the policy is started again, or connected again, at the next `reset`.
    """

    @property
    def settings(self) -> PolicySettings:
        """What it asks of the evaluation; the first time, this starts it."""
        ...

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode.

        Raises:
            PolicyFault: It crashed, hung or cannot be reached.
        """
        ...

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,), finite. How many numbers there are is for the caller to check.

        Raises:
            PolicyFault: It crashed, hung, cannot be reached, or what it returned is no action.
        """
        ...

    def close(self) -> None:
        """End it; may be called again, and `reset` starts it anew."""
        ...


def open_policy(reference: str | Policy, *, time_limit: float = 30.0, start_limit: float = 300.0) -> PolicyClient:
    """Return a policy, which starts when it is first asked for something.

    Args:
        reference: What it is called, see `find_policy`; or an object with the methods of `Policy`, which runs in this process.
        time_limit: How long `reset` and `act` may take [s]. A policy in this process is not stopped.
        start_limit: How long it may take to start and to say what it asks for [s].

    Raises:
        UnknownName: No policy of this package is called so.
        PolicyReferenceError: There is no such module, file or factory.
        MissingExtra: The library that it needs is not installed.
    """
    time_limit = as_number(time_limit, "time_limit", above=0.0, most=1e6)
    start_limit = as_number(start_limit, "start_limit", above=0.0, most=1e6)
    if not isinstance(reference, str):
        if isinstance(reference, type) or not isinstance(reference, Policy):
            raise PolicyReferenceError(reference, f"is an object with reset, act, action_mode and obs_config, or {FORMS}")
        return PolicyHere(reference)
    found = find_policy(reference)
    if found.place == "here":
        try:
            return PolicyHere(make_policy(found.target))
        except NoPolicy as error:
            raise PolicyReferenceError(reference, f"cannot be made: {error}") from error
    link = ServedPolicy(found.target) if found.place == "socket" else HostedPolicy(reference, found.target)
    return RemotePolicy(link, time_limit, start_limit)


__all__ = ["PolicyClient", "PolicyFault", "PolicySettings", "open_policy"]
