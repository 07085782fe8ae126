"""The process of a policy: `python -m rlbench_pin.evaluation.policies.policy_process SOCKET PIPE module:factory`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rlbench_pin.evaluation.policies.policy import Policy, PolicySettingsError
from rlbench_pin.evaluation.policies.policy_server import Answers, Channel, NoPolicy, converse
from rlbench_pin.evaluation.policies.references import make_policy
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.policies.wire import decode_context, decode_observation
from rlbench_pin.processes.child import connect_to_owner


def settings_of(policy: Policy) -> Mapping[str, Any]:
    """Return the settings of a policy as plain data, or raise NoPolicy."""
    try:
        return PolicySettings.of_policy(policy).plain()
    except PolicySettingsError as error:
        raise NoPolicy(str(error)) from error


def answers_for(target: str) -> Answers:
    """Return the object that answers requests for the policy of a reference."""
    return Answers(lambda: make_policy(target), settings_of, decode_observation, decode_context)


def main() -> None:
    """Answer until the owner closes the socket."""
    connection, (target,) = connect_to_owner()
    converse(Channel(connection), answers_for(target))


if __name__ == "__main__":
    main()
