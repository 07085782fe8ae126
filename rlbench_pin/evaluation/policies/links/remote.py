"""A policy that is asked over a channel, and started or connected again after a fault."""

from __future__ import annotations

import time
from typing import Any, NoReturn, Protocol

import numpy as np

from rlbench_pin.evaluation.policies.exchange import checked_action, sent_context, sent_observation
from rlbench_pin.evaluation.policies.faults import LONGEST_DETAIL, FaultKind, PolicyFault, PolicyReferenceError
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.evaluation.policies.policy_server import VERSION, Channel, WireError
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.observation import Observation

GRACE = 5.0
"""How long a process whose connection has ended may take to end [s]."""


class Link(Protocol):
    """A way to a policy."""

    reference: str
    """What the policy was called."""
    lost: FaultKind
    """What it means that the connection is gone."""

    def open(self, timeout: float) -> Channel:
        """Start or connect, and return the channel.

        Raises:
            PolicyFault: It cannot be reached.
        """
        ...

    def close(self, patience: float = 0.0) -> str:
        """End what was opened, and say how it ended; a policy that is not at fault is given `patience` [s]."""
        ...

    def printed(self) -> str:
        """Return the end of what the policy printed, empty where that is not known."""
        ...


class RemotePolicy:
    """A policy behind a link.

    Args:
        link: The way to it.
        time_limit: How long `reset` and `act` may take [s].
        start_limit: How long it may take until the policy is there and has said what it asks for [s].
    """

    def __init__(self, link: Link, time_limit: float, start_limit: float) -> None:
        self._link, self._time_limit, self._start_limit = link, time_limit, start_limit
        self._channel: Channel | None = None
        self._settings: PolicySettings | None = None

    @property
    def settings(self) -> PolicySettings:
        """What the policy asks for; the first time, this starts it.

        Raises:
            PolicyFault: It cannot be started or reached.
            PolicyReferenceError: The reference leads to no policy.
            PolicySettingsError: What it asks for is not of this package.
        """
        if self._settings is None:
            self._settings = self._begin()
        return self._settings

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode; starts the policy when it is not there."""
        known = self.settings
        if self._channel is None and self._begin() != known:
            self._fail("wrong answer", "Started again, it asks for another action mode or other observations than before.")
        self._prepare()
        self._ask({"call": "reset", "instruction": instruction, "context": sent_context(context)}, self._time_limit)

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,)."""
        if self._channel is None:
            raise PolicyFault(self._link.lost, "It has ended.", "`reset` starts it again.")
        action = self._ask({"call": "act", "observation": sent_observation(observation)}, self._time_limit)
        try:
            if not isinstance(action, np.ndarray):
                raise PolicyFault("wrong answer", f"`act` returned a {type(action).__name__}, not an array of numbers.")
            return checked_action(action)
        except PolicyFault as fault:
            self._fail(fault.kind, fault.detail)

    def close(self) -> None:
        """End the policy, or the connection to it."""
        channel, self._channel = self._channel, None
        if channel is not None:
            channel.close()
            self._link.close(patience=2.0)

    def _begin(self) -> PolicySettings:
        """Start or connect, and ask for the settings."""
        end = time.monotonic() + self._start_limit
        self._channel = self._link.open(self._start_limit)
        said = self._ask({"call": "hello", "version": VERSION}, max(0.1, end - time.monotonic()))
        if not isinstance(said, dict) or said.get("version") != VERSION:
            self._fail("wrong answer", f"It does not speak version {VERSION} of the protocol.")
        try:
            return PolicySettings.of(said.get("action_mode"), said.get("observation"), said.get("max_steps"))
        except BaseException:
            self._drop()
            raise

    def _prepare(self) -> None:
        """Tell the policy, which has just said what it asks for or has ended an episode, what it needs for the next one."""

    def _ask(self, question: dict[str, Any], limit: float) -> Any:
        """Return what the policy answers, or end it and raise."""
        assert self._channel is not None
        call, end = question["call"], time.monotonic() + limit
        try:
            self._channel.send(question, limit)
            answer = self._channel.receive(max(0.0, end - time.monotonic()))
        except TimeoutError:
            self._fail("timed out", f"`{call}` took longer than {limit:g} s.")
        except (EOFError, OSError):
            self._fail(self._link.lost, f"The connection ended during `{call}`.", GRACE)
        except WireError as error:
            self._fail("wrong answer", str(error))
        except BaseException:  # Ctrl-C: the answer would be taken for that to the next question
            self._drop()
            raise
        if "ok" in answer:
            return answer["ok"]
        return self._refused(
            str(call), str(answer.get("error", "It says neither `ok` nor `error`."))[:LONGEST_DETAIL], answer.get("kind")
        )

    def _refused(self, call: str, problem: str, kind: object) -> NoReturn:
        """Raise what an answer with an error stands for."""
        if kind == "wrong question" and call == "hello":
            self._drop()
            raise PolicyReferenceError(self._link.reference, f"cannot be started: {problem}")
        self._fail("crashed" if kind == "crashed" else "wrong answer", problem)

    def _fail(self, kind: FaultKind, detail: str, patience: float = 0.0) -> NoReturn:
        """End the policy and raise; one that is ending by itself is given `patience` [s], so that its exit code is known."""
        ended = self._drop(patience)
        raise PolicyFault(kind, f"{detail} {ended}" if patience and ended else detail, printed=self._link.printed())

    def _drop(self, patience: float = 0.0) -> str:
        channel, self._channel = self._channel, None
        ended = self._link.close(patience)
        if channel is not None:
            channel.close()
        return ended
