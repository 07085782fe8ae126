"""What `rlbench-pin serve POLICY` takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

PolicyName = Annotated[str, tyro.conf.arg(metavar="POLICY", help_behavior_hint="(required)")]
"""A policy behind a command, which says in its own words that it needs one."""
Address = Annotated[str, tyro.conf.arg(metavar="ADDRESS")]
"""A Unix socket, or host and port."""


@dataclass(frozen=True)
class Serve:
    """Serve a policy at an address until Ctrl-C; `rlbench-pin evaluate` with that address elsewhere evaluates it."""

    policy: tyro.conf.Positional[PolicyName] = ""
    """`module:factory`, `file.py:factory`, `sb3:FILE`, `lerobot:FOLDER`, or the name of a policy of this package."""

    address: Address = "tcp://127.0.0.1:5555"
    """Where: `unix:PATH`, which this user alone can open, or `tcp://HOST:PORT`."""
    anywhere: bool = False
    """Let other machines connect. Nothing is encrypted and no password asked for: do so in a network that you trust."""
