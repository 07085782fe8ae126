"""A learner as the challenge sees it: in a process of its own, taught anew for each task."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np

from rlbench_pin.evaluation.challenge.learner import Pictures
from rlbench_pin.evaluation.challenge.references import find_learner
from rlbench_pin.evaluation.challenge.withheld import check_settings, shown, shown_context
from rlbench_pin.evaluation.policies.client import RemotePolicy, SubprocessTransport
from rlbench_pin.evaluation.policies.policy import PolicyContext, PolicyFault
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.policies.wire import decode_observation
from rlbench_pin.observation import Demo, Observation

ANSWERS = "rlbench_pin.evaluation.challenge.answers"
"""The module that runs in the process of a learner."""
MESSAGE = 64 * 2**20
"""Bytes of the frames of a demonstration from which on a message is sent."""


class LearnerClient(RemotePolicy):
    """A learner in a process of its own, and the policy that it makes of demonstrations.

    Args:
        reference: What the learner is called.
        seed: Seed of the run.
        time_limit: How long one answer of the policy may take [s].
        start_limit: How long the learner may take to start [s].
        adapt_limit: How long it may take to adapt [s].
        withheld: A folder that its process is kept out of, where the system can.
        known: What it asks for, where that is known; otherwise it is started to say so.
    """

    def __init__(
        self, reference: str, seed: int, time_limit: float, start_limit: float, adapt_limit: float,
        withheld: Path | None = None, known: PolicySettings | None = None,
    ) -> None:  # fmt: skip
        super().__init__(SubprocessTransport(reference, find_learner(reference), ANSWERS), time_limit, start_limit)
        self._seed, self._adapt_limit, self._settings = seed, adapt_limit, known
        self._demonstrations: Callable[[], Iterator[Demo]] | None = None
        self._learned: Mapping[str, Any] | None = None
        self._taught: object = None
        self._unteachable: PolicyFault | None = None

    @property
    def settings(self) -> PolicySettings:
        """What the learner asks for; the first time, this starts it.

        Raises:
            PolicySettingsError: It asks for what is withheld, or is not of this package.
        """
        return check_settings(super().settings)

    def wanted_pictures(self) -> Pictures:
        """Return which frames of demonstrations need their pictures; starts the learner when it is not there."""
        if self._channel is None:
            self._settings = self._begin()
        return self._wanted()

    def meta_train(self, tasks: Sequence[str], robot: str, limit: float) -> Mapping[str, Any] | None:
        """Let the learner practise, and return what it has learned.

        Args:
            tasks: Names of the tasks.
            robot: Name of the arm.
            limit: How long it may take [s].

        Raises:
            PolicyFault: It failed.
        """
        if self._channel is None or self._settings is None:
            self._settings = self._begin()
        check_settings(self._settings)
        learned = self._ask({"call": "meta_train", "tasks": list(tasks), "robot": robot}, limit)
        if learned is not None and not isinstance(learned, dict):
            raise PolicyFault("wrong answer", f"`meta_train` returned a {type(learned).__name__}; it returns a map, or None.")
        return learned

    def show(self, demonstrations: Callable[[], Iterator[Demo]], learned: Mapping[str, Any] | None) -> None:
        """Begin another task, in a new process.

        Args:
            demonstrations: Reads the demonstrations that are shown.
            learned: What was learned from meta-training tasks.
        """
        self.close()
        self._demonstrations, self._learned, self._unteachable = demonstrations, learned, None

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode; the learner adapts first when its process is new. Where that failed, it is not asked again."""
        if self._unteachable is not None:
            raise self._unteachable
        check_settings(self.settings)
        super().reset(instruction, shown_context(context, self._seed))

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,)."""
        return super().act(decode_observation(shown(observation)))

    def _wanted(self) -> Pictures:
        wants = self._ask({"call": "wants"}, self._start_limit)
        pictures = wants.get("pictures") if isinstance(wants, dict) else None
        if pictures not in get_args(Pictures):
            self._fail("wrong answer", f"Its `pictures` is {pictures!r}; it is 'all' or 'first'.")
        return "first" if pictures == "first" else "all"

    def _prepare(self) -> None:
        if self._taught is self._channel:
            return
        try:
            self._teach()
        except PolicyFault as fault:
            self._unteachable = fault
            raise
        self._taught = self._channel

    def _teach(self) -> None:
        assert self._demonstrations is not None
        pictures = self._wanted()
        if self._learned is not None:
            self._ask({"call": "recall", "learned": dict(self._learned)}, self._start_limit)
        for number, demo in enumerate(self._demonstrations()):
            question = {"call": "frames", "demonstration": number, "instructions": list(demo.instructions)}
            for frames in batches(shown(seen, pictures=i == 0 or pictures == "all") for i, seen in enumerate(demo)):
                self._ask({**question, "observations": frames}, self._adapt_limit)
        self._ask({"call": "adapt"}, self._adapt_limit)


def batches(frames: Iterable[dict[str, Any]]) -> Iterator[list[dict[str, Any]]]:
    """Yield frames in lists that fit into messages."""
    batch: list[dict[str, Any]] = []
    size = 0
    for frame in frames:
        batch.append(frame)
        size += sum(value.nbytes for value in frame.values() if isinstance(value, np.ndarray))
        if size >= MESSAGE:
            yield batch
            batch, size = [], 0
    if batch:
        yield batch
