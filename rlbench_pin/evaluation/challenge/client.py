"""Clients of learners. A learner runs in a subprocess and adapts to each task in a new process.

Some data are withheld from learners. A request for them is refused, and observations do not contain them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, get_args

import numpy as np

from rlbench_pin.evaluation.challenge.config import find_learner
from rlbench_pin.evaluation.challenge.learner import ImageFrames
from rlbench_pin.evaluation.policies.client import RemotePolicy, SubprocessTransport
from rlbench_pin.evaluation.policies.policy import PolicyContext, PolicyFault, PolicySettingsError
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.policies.wire import decode_observation, encode_observation
from rlbench_pin.observation import Demo, Observation

LEARNER_PROCESS = "rlbench_pin.evaluation.challenge.learner_process"
"""The module that runs in the process of a learner."""
MESSAGE = 64 * 2**20
"""A message with frames of a demonstration is sent when it has at least this number of bytes."""
HIDDEN_FIELDS = ("task_low_dim_state", "ignore_collisions")
"""Fields of observations that are withheld from learners."""
HIDDEN_MISC = ("mask_names", "world_distances")
"""Entries of `misc` that are withheld from learners, in addition to those that are withheld from policies."""
IMAGES = ("_rgb", "_depth", "_point_cloud")
"""Endings of the names of fields with images."""


class LearnerClient(RemotePolicy):
    """A learner in its own process, and the policy that it makes from demonstrations.

    Args:
        reference: Reference of the learner.
        seed: Seed of the run.
        time_limit: Time limit of the policy for one answer [s].
        start_limit: Time limit for the start of the learner [s].
        adapt_limit: Time limit for the adaptation of the learner [s].
        known: Settings of the learner; None starts the learner to get them.
    """

    def __init__(
        self, reference: str, seed: int, time_limit: float, start_limit: float, adapt_limit: float,
        known: PolicySettings | None = None,
    ) -> None:  # fmt: skip
        super().__init__(SubprocessTransport(reference, find_learner(reference), LEARNER_PROCESS), time_limit, start_limit)
        self._seed, self._adapt_limit, self._settings = seed, adapt_limit, known
        self._demonstrations: Callable[[], Iterator[Demo]] | None = None
        self._learned: Mapping[str, Any] | None = None
        self._taught: object = None
        self._unteachable: PolicyFault | None = None

    @property
    def settings(self) -> PolicySettings:
        """Settings of the learner; the first access starts it.

        Raises:
            PolicySettingsError: The settings request withheld data, or are not of this package.
        """
        return validate_settings(super().settings)

    def image_frames(self) -> ImageFrames:
        """Return which frames of demonstrations need images; starts the learner if it is not running."""
        if self._channel is None:
            self._settings = self._begin()
        return self._wanted()

    def meta_train(self, tasks: Sequence[str], robot: str, limit: float) -> Mapping[str, Any] | None:
        """Let the learner train on the meta-training tasks, and return the result of its `meta_train`.

        Args:
            tasks: Names of the tasks.
            robot: Name of the arm.
            limit: Time limit [s].

        Raises:
            PolicyFault: The learner failed.
        """
        if self._channel is None or self._settings is None:
            self._settings = self._begin()
        validate_settings(self._settings)
        learned = self._ask({"call": "meta_train", "tasks": list(tasks), "robot": robot}, limit)
        if learned is not None and not isinstance(learned, dict):
            raise PolicyFault("wrong answer", f"`meta_train` returned a {type(learned).__name__}; it must return a map or None.")
        return learned

    def show(self, demonstrations: Callable[[], Iterator[Demo]], learned: Mapping[str, Any] | None) -> None:
        """Begin another task, in a new process.

        Args:
            demonstrations: Reads the demonstrations of the task.
            learned: Result of `meta_train`.
        """
        self.close()
        self._demonstrations, self._learned, self._unteachable = demonstrations, learned, None

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode. A learner in a new process adapts first; if the adaptation failed, it is not repeated."""
        if self._unteachable is not None:
            raise self._unteachable
        validate_settings(self.settings)
        super().reset(instruction, visible_context(context, self._seed))

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,)."""
        return super().act(decode_observation(visible_observation(observation)))

    def _wanted(self) -> ImageFrames:
        wants = self._ask({"call": "wants"}, self._start_limit)
        frames = wants.get("pictures") if isinstance(wants, dict) else None
        if frames not in get_args(ImageFrames):
            self._fail("wrong answer", f"Its `pictures` is {frames!r}; it must be 'all' or 'first'.")
        return "first" if frames == "first" else "all"

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
        image_frames = self._wanted()
        if self._learned is not None:
            self._ask({"call": "recall", "learned": dict(self._learned)}, self._start_limit)
        for number, demo in enumerate(self._demonstrations()):
            question = {"call": "frames", "demonstration": number, "instructions": list(demo.instructions)}
            for frames in batches(
                visible_observation(seen, images=i == 0 or image_frames == "all") for i, seen in enumerate(demo)
            ):
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


def validate_settings(settings: PolicySettings) -> PolicySettings:
    """Return the settings of a learner.

    Raises:
        PolicySettingsError: The settings request data that the challenge withholds.
    """
    seen = settings.make_obs_config()
    cameras = {**seen.cameras(), **{name: extra.config for name, extra in seen.extra_cameras.items()}}
    asked = [name for name, camera in cameras.items() if camera.mask]
    what = f"masks ({asked[0]})" if asked else ""
    what = "task_low_dim_state" if seen.task_low_dim_state else what
    what = "model.world_distances" if seen.model.world_distances else what
    if what:
        hint = "Use colour images, depth, point clouds and measurements of the arm."
        raise PolicySettingsError("An observation of a learner", what, "is withheld in the challenge", hint)
    return settings


def visible_observation(observation: Observation, *, images: bool = True) -> dict[str, Any]:
    """Return the part of an observation of a test task that a learner gets, as a map.

    Args:
        observation: The whole observation.
        images: Whether images are included.
    """
    sent = encode_observation(observation)
    cut = {
        name: value for name, value in sent.items() if name not in HIDDEN_FIELDS and not name.endswith("_mask") and name != "misc"
    }
    if not images:
        cut = {name: value for name, value in cut.items() if not name.endswith(IMAGES)}
    misc: Mapping[str, Any] = sent["misc"]
    return {**cut, "misc": {name: value for name, value in misc.items() if name not in HIDDEN_MISC}}


def visible_context(context: PolicyContext, seed: int) -> PolicyContext:
    """Return the context of a learner's policy: without the task name, and with one seed for all episodes.

    A seed for each episode would be a hash of task name and number, which would reveal the task to a search over all names.

    Args:
        context: Context for a policy that is not a learner's.
        seed: Seed of the run.
    """
    digest = hashlib.sha256(f"rlbench_pin challenge policy/{seed}".encode()).digest()
    return replace(context, task="", seed=int.from_bytes(digest[:8], "big") >> 11)
