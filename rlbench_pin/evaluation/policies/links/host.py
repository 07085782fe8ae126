"""What runs in the process of a policy: `python -m rlbench_pin.evaluation.policies.links.host SOCKET PIPE module:factory`."""

from __future__ import annotations

import fcntl
import os
import select
import socket
import sys
from collections.abc import Mapping
from typing import Any

from rlbench_pin.evaluation.policies.exchange import received_context, received_observation
from rlbench_pin.evaluation.policies.faults import PolicySettingsError
from rlbench_pin.evaluation.policies.links.loading import make_policy
from rlbench_pin.evaluation.policies.policy import Policy
from rlbench_pin.evaluation.policies.policy_server import Answers, Channel, NoPolicy, converse
from rlbench_pin.evaluation.policies.settings import PolicySettings


def settings_of(policy: Policy) -> Mapping[str, Any]:
    """Return the settings of a policy as plain data; that they are of this package is looked at here and by who receives them."""
    try:
        return vars(PolicySettings.of(policy.action_mode, policy.obs_config, getattr(policy, "max_steps", None)))
    except PolicySettingsError as error:
        raise NoPolicy(str(error)) from error


def answers_for(target: str) -> Answers:
    """Return what answers for the policy that a reference names."""
    return Answers(lambda: make_policy(target), settings_of, received_observation, received_context)


def end_with_owner(pipe: int) -> None:
    """Let this process and those that it starts end when the owner does, whatever they are at and however it ends.

    The owner holds the other end of the pipe. When that is closed, by the system if need be, the system sends SIGIO to the
    group of this process, which ends all in it.

    Args:
        pipe: Descriptor of the end to read from.
    """
    fcntl.fcntl(pipe, fcntl.F_SETOWN, -os.getpgrp())
    fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
    if select.select([pipe], [], [], 0.0)[0]:  # it is gone already
        os._exit(1)


def main() -> None:
    """Answer until the owner closes the socket."""
    end_with_owner(int(sys.argv[2]))
    converse(Channel(socket.socket(fileno=int(sys.argv[1]))), answers_for(sys.argv[3]))


if __name__ == "__main__":
    main()
