"""`rlbench-pin serve POLICY`: serve a policy to evaluations in other Python environments or on other machines."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from typing import Annotated

import tyro

from rlbench_pin.cli.pages import answer_signals
from rlbench_pin.errors import TaskEnvironmentError

PolicyName = Annotated[str, tyro.conf.arg(metavar="POLICY", help_behavior_hint="(required)")]
"""A policy as the argument of a command; the command reports a missing one."""
Address = Annotated[str, tyro.conf.arg(metavar="ADDRESS")]
"""A Unix socket, or host and port."""


@dataclass(frozen=True)
class Serve:
    """Serve a policy at an address until Ctrl-C. `rlbench-pin evaluate` takes the address as its policy."""

    policy: tyro.conf.Positional[PolicyName] = ""
    """`module:factory`, `file.py:factory`, `sb3:FILE`, `lerobot:FOLDER`, or the name of a policy of this package."""

    address: Address = "tcp://127.0.0.1:5555"
    """Address: `unix:PATH`, which only this user can open, or `tcp://HOST:PORT`."""
    anywhere: bool = False
    """Let other machines connect. There is no encryption and no authentication: use it only in a trusted network."""

    def run(self) -> int:
        """Serve until Ctrl-C."""
        from rlbench_pin.evaluation.policies.policy_process import answers_for
        from rlbench_pin.evaluation.policies.policy_server import listen, serve_answers
        from rlbench_pin.evaluation.policies.references import find_policy

        if not self.policy:
            raise TaskEnvironmentError("No policy was named. Use `rlbench-pin serve POLICY`, for example `my_policy.py:make`.")
        found = find_policy(self.policy)
        if found.place in ("socket", "websocket"):
            raise TaskEnvironmentError(
                f"'{self.policy}' is the address of a server, not a policy. Name the policy, such as `my_policy.py:make`."
            )
        try:
            listener = listen(self.address, self.anywhere)
        except (ValueError, OSError) as error:
            hint = "" if isinstance(error, ValueError) else " It may be in use: choose another `--address`."
            said = str(error).replace("anywhere=True", "`--anywhere`")
            raise TaskEnvironmentError(f"The address '{self.address}' cannot be used: {said.rstrip('.')}.{hint}") from error
        sys.path.insert(0, os.getcwd())  # the import path of `module:factory`, as with `python -m`
        answer_signals()
        print(f"{self.policy} is served at {self.address}; Ctrl-C ends it", flush=True)
        serve_answers(lambda: answers_for(found.target), listener)
        return 0
