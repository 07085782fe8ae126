"""A policy that somebody serves: connected to, and connected to again."""

from __future__ import annotations

import socket

from rlbench_pin.evaluation.policies.faults import FaultKind, PolicyFault
from rlbench_pin.evaluation.policies.policy_server import Channel, split_tcp

HINT = "Start it with `rlbench-pin serve POLICY --address {address}`, or with `serve` of policy_server.py."
LONGEST_WAIT = 10.0
"""To connect takes no longer, or does not work [s]."""


class ServedPolicy:
    """A link to a policy that is served at an address.

    Args:
        address: `unix:PATH` or `tcp://HOST:PORT`.
    """

    lost: FaultKind = "unreachable"

    def __init__(self, address: str) -> None:
        self.reference = address

    def open(self, timeout: float) -> Channel:
        """Connect.

        Raises:
            PolicyFault: Nobody listens there.
        """
        try:
            return Channel(self._connected(min(timeout, LONGEST_WAIT)))
        except (OSError, ValueError) as error:  # the latter for names that no host or socket can have
            problem = f"There is no connection to {self.reference}: {error.strerror if isinstance(error, OSError) else error}."
            raise PolicyFault("unreachable", problem, HINT.format(address=self.reference)) from error

    def _connected(self, timeout: float) -> socket.socket:
        if self.reference.startswith("tcp:"):
            connection = socket.create_connection(split_tcp(self.reference), timeout)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return connection
        connection = socket.socket(socket.AF_UNIX)
        try:
            connection.settimeout(timeout)
            connection.connect(self.reference.removeprefix("unix:"))
        except BaseException:
            connection.close()
            raise
        return connection

    def close(self, patience: float = 0.0) -> str:
        """Nothing runs here; whoever serves the policy sees the connection end."""
        return ""

    def printed(self) -> str:
        """What the policy prints is where it is served."""
        return ""
