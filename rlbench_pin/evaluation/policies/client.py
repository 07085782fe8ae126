"""Clients of policies: in this process, in a subprocess, or behind a socket."""

from __future__ import annotations

import socket
import time
from typing import Any, NoReturn, Protocol

import numpy as np

from rlbench_pin.evaluation.policies.policy import (
    LONGEST_DETAIL,
    FaultKind,
    Policy,
    PolicyContext,
    PolicyFault,
    PolicyReferenceError,
)
from rlbench_pin.evaluation.policies.policy_server import VERSION, Channel, NoPolicy, WireError, describe_error, split_tcp
from rlbench_pin.evaluation.policies.references import FORMS, find_policy, make_policy
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.policies.wire import (
    decode_observation,
    encode_context,
    encode_observation,
    validate_action,
    visible_fields,
)
from rlbench_pin.evaluation.policies.wires import WirePolicy, parse_address
from rlbench_pin.observation import Observation
from rlbench_pin.processes.child import ChildProcess
from rlbench_pin.values import as_number

GRACE = 5.0
"""Time limit for a process to end after its connection has ended [s]."""
CONNECT_LIMIT = 10.0
"""Time limit for a connection to a socket [s]."""


class PolicyClient(Protocol):
    """A policy that runs in this process, in a subprocess, or behind a socket.

    A `PolicyFault` fails the episode. The next `reset` starts the policy again, or connects again.
    """

    @property
    def settings(self) -> PolicySettings:
        """Settings of the policy; the first access starts the policy."""
        ...

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode.

        Raises:
            PolicyFault: The policy crashed, did not answer in time, or cannot be reached.
        """
        ...

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,), finite. The caller checks n.

        Raises:
            PolicyFault: The policy crashed, did not answer in time, cannot be reached, or returned no action.
        """
        ...

    def close(self) -> None:
        """End the policy. Several calls are allowed, and `reset` starts it again."""
        ...


def open_policy(reference: str | Policy, *, time_limit: float = 30.0, start_limit: float = 300.0) -> PolicyClient:
    """Return a client of a policy. The policy starts at the first access to its settings.

    Args:
        reference: Reference, see `find_policy`, or an object with the methods of `Policy`, which runs in this process.
        time_limit: Time limit for `reset` and `act` [s]. It does not apply to a policy in this process.
        start_limit: Time limit for the start of the policy, until it has returned its settings [s].

    Raises:
        UnknownName: No policy of this package has this name.
        PolicyReferenceError: There is no such module, file or factory.
        MissingExtra: The library of the policy is not installed.
    """
    time_limit = as_number(time_limit, "time_limit", above=0.0, most=1e6)
    start_limit = as_number(start_limit, "start_limit", above=0.0, most=1e6)
    if not isinstance(reference, str):
        if isinstance(reference, type) or not isinstance(reference, Policy):
            raise PolicyReferenceError(reference, f"has to be an object with reset, act, action_mode and obs_config, or {FORMS}")
        return InProcessPolicy(reference)
    found = find_policy(reference)
    if found.place == "in-process":
        try:
            return InProcessPolicy(make_policy(found.target))
        except NoPolicy as error:
            raise PolicyReferenceError(reference, f"cannot be made: {str(error).rstrip('.')}") from error
    if found.place == "websocket":
        return WirePolicy(parse_address(found.target), time_limit, start_limit)
    socketed = found.place == "socket"
    transport: Transport = SocketTransport(found.target) if socketed else SubprocessTransport(reference, found.target)
    return RemotePolicy(transport, time_limit, start_limit)


class InProcessPolicy:
    """A policy in this process. It has no time limit, and it shares the memory of this process.

    Args:
        policy: The policy.

    Raises:
        PolicySettingsError: Its action mode or its observations are not of this package.
    """

    def __init__(self, policy: Policy) -> None:
        self._policy = policy
        self.settings = PolicySettings.of_policy(policy)

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode."""
        try:
            self._policy.reset(instruction, context)
        except Exception as error:  # whatever the policy raises
            raise _crash(error) from error

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,)."""
        try:
            action = self._policy.act(decode_observation(visible_fields(observation)))
        except Exception as error:  # whatever the policy raises
            raise _crash(error) from error
        return validate_action(action)

    def close(self) -> None:
        """Do nothing: no process was started."""


def _crash(error: Exception) -> PolicyFault:
    return PolicyFault("crashed", describe_error(error)[:LONGEST_DETAIL])


class Transport(Protocol):
    """Connection to a policy."""

    reference: str
    """Reference of the policy."""
    lost: FaultKind
    """Kind of fault when the connection is lost."""

    def open(self, timeout: float) -> Channel:
        """Start or connect, and return the channel.

        Raises:
            PolicyFault: The policy cannot be reached.
        """
        ...

    def close(self, patience: float = 0.0) -> str:
        """Close the connection, wait up to `patience` [s] for the policy to end by itself, and return a sentence how it ended."""
        ...

    def printed(self) -> str:
        """Return the last lines that the policy printed; empty if they are not available."""
        ...


class RemotePolicy:
    """A policy in another process, started or connected again after a fault.

    Args:
        transport: Connection to the policy.
        time_limit: Time limit for `reset` and `act` [s].
        start_limit: Time limit for the start of the policy, until it has returned its settings [s].
    """

    def __init__(self, transport: Transport, time_limit: float, start_limit: float) -> None:
        self._transport, self._time_limit, self._start_limit = transport, time_limit, start_limit
        self._channel: Channel | None = None
        self._settings: PolicySettings | None = None

    @property
    def settings(self) -> PolicySettings:
        """Settings of the policy; the first access starts the policy.

        Raises:
            PolicyFault: The policy cannot be started or reached.
            PolicyReferenceError: The reference names no policy.
            PolicySettingsError: The settings are not of this package.
        """
        if self._settings is None:
            self._settings = self._begin()
        return self._settings

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode; starts the policy if it is not running."""
        known = self.settings
        if self._channel is None and self._begin() != known:
            self._fail("wrong answer", "After its restart it has another action mode or other observations than before.")
        self._prepare()
        self._ask({"call": "reset", "instruction": instruction, "context": encode_context(context)}, self._time_limit)

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,)."""
        if self._channel is None:
            raise PolicyFault(self._transport.lost, "It has ended.", "`reset` starts it again.")
        action = self._ask({"call": "act", "observation": encode_observation(observation)}, self._time_limit)
        try:
            return validate_action(action)
        except PolicyFault as fault:
            self._fail(fault.kind, fault.detail)

    def close(self) -> None:
        """End the policy, or the connection to it."""
        channel, self._channel = self._channel, None
        if channel is not None:
            channel.close()
            self._transport.close(patience=2.0)

    def _begin(self) -> PolicySettings:
        """Start or connect, and ask for the settings."""
        end = time.monotonic() + self._start_limit
        self._channel = self._transport.open(self._start_limit)
        said = self._ask({"call": "hello", "version": VERSION}, max(0.1, end - time.monotonic()))
        if not isinstance(said, dict) or said.get("version") != VERSION:
            self._fail(
                "wrong answer",
                f"It lacks version {VERSION} of the protocol. Use the policy_server.py of this release.",
            )
        try:
            return PolicySettings.of(*(said.get(name) for name in ("action_mode", "observation", "max_steps", "joint_names")))
        except BaseException:
            self._drop()
            raise

    def _prepare(self) -> None:
        """Send data that the policy needs before the next episode."""

    def _ask(self, question: dict[str, Any], limit: float) -> Any:
        """Return the answer of the policy, or end the policy and raise PolicyFault."""
        assert self._channel is not None
        call, end = question["call"], time.monotonic() + limit
        try:
            self._channel.send(question, limit)
            answer = self._channel.receive(max(0.0, end - time.monotonic()))
        except TimeoutError:
            self._fail("timed out", f"`{call}` took longer than {limit:g} s.")
        except (EOFError, OSError):
            self._fail(self._transport.lost, f"The connection ended during `{call}`.", GRACE)
        except WireError as error:
            self._fail("wrong answer", str(error))
        except BaseException:  # Ctrl-C: the answer would be mistaken for that to the next request
            self._drop()
            raise
        if "ok" in answer:
            return answer["ok"]
        return self._refused(
            str(call), str(answer.get("error", "The answer has neither `ok` nor `error`."))[:LONGEST_DETAIL], answer.get("kind")
        )

    def _refused(self, call: str, problem: str, kind: object) -> NoReturn:
        """Raise the fault of an answer with an error."""
        if kind == "wrong question" and call == "hello":
            self._drop()
            raise PolicyReferenceError(self._transport.reference, f"cannot be started: {problem.rstrip('.')}")
        self._fail("crashed" if kind == "crashed" else "wrong answer", problem)

    def _fail(self, kind: FaultKind, detail: str, patience: float = 0.0) -> NoReturn:
        """End the policy and raise PolicyFault. Wait up to `patience` [s] for it to end by itself, to get its exit code."""
        ended = self._drop(patience)
        raise PolicyFault(kind, f"{detail} {ended}" if patience and ended else detail, printed=self._transport.printed())

    def _drop(self, patience: float = 0.0) -> str:
        channel, self._channel = self._channel, None
        ended = self._transport.close(patience)
        if channel is not None:
            channel.close()
        return ended


class SubprocessTransport:
    """A policy in a subprocess, which ends with this process.

    Args:
        reference: Reference of the policy.
        target: `module:factory` or `file.py:factory`, with its arguments.
        module: The module that runs in the subprocess.
    """

    lost: FaultKind = "crashed"

    def __init__(self, reference: str, target: str, module: str = "rlbench_pin.evaluation.policies.policy_process") -> None:
        self.reference, self._target, self._module = reference, target, module
        self._child: ChildProcess | None = None

    def open(self, timeout: float) -> Channel:
        """Start the subprocess and return the channel to it. The subprocess makes the policy at the first request."""
        self.close()
        try:
            self._child = ChildProcess(self._module, [self._target])
        except OSError as error:
            raise PolicyFault("crashed", f"Its process could not be started: {error}.", "Free memory or processes.") from error
        return Channel(self._child.connection)

    def close(self, patience: float = 0.0) -> str:
        """End the process and its descendants, and return a sentence how it ended."""
        return "" if self._child is None else self._child.end(patience)

    def printed(self) -> str:
        """Return the last lines that the policy printed."""
        return "" if self._child is None else self._child.printed()


class SocketTransport:
    """Socket of a policy at an address.

    Args:
        address: `unix:PATH` or `tcp://HOST:PORT`.
    """

    lost: FaultKind = "unreachable"

    def __init__(self, address: str) -> None:
        self.reference = address

    def open(self, timeout: float) -> Channel:
        """Connect.

        Raises:
            PolicyFault: There is no server at the address.
        """
        try:
            return Channel(self._connected(min(timeout, CONNECT_LIMIT)))
        except (OSError, ValueError) as error:  # the latter for names that no host or socket can have
            problem = f"There is no connection to {self.reference}: {error.strerror if isinstance(error, OSError) else error}."
            hint = f"Start it with `rlbench-pin serve POLICY --address {self.reference}`, or `serve` in policy_server.py."
            raise PolicyFault("unreachable", problem, hint) from error

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
        """Return an empty text: the server of the policy ends the connection."""
        return ""

    def printed(self) -> str:
        """Return an empty text: the server keeps the output of the policy."""
        return ""
