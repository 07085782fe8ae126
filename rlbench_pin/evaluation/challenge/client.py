"""Learners as the challenge sees them: in a subprocess, adapted again for each task, without what is withheld.

Data withheld from learners are refused when they ask for them, and left out of observations.
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
"""Bytes of the frames of a demonstration from which on a message is sent."""
HIDDEN_FIELDS = ("task_low_dim_state", "ignore_collisions")
"""Fields of observations that no learner is given."""
HIDDEN_MISC = ("mask_names", "world_distances")
"""Likewise, entries of `misc` beside those that no policy is given."""
IMAGES = ("_rgb", "_depth", "_point_cloud")
"""Endings of the names of fields with images."""


class LearnerClient(RemotePolicy):
    """A learner in a process of its own, and the policy that it makes of demonstrations.

    Args:
        reference: What the learner is called.
        seed: Seed of the run.
        time_limit: How long one answer of the policy may take [s].
        start_limit: How long the learner may take to start [s].
        adapt_limit: How long it may take to adapt [s].
        known: What it asks for, where that is known; otherwise it is started to say so.
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
        """Settings that the learner asks for; the first access starts it.

        Raises:
            PolicySettingsError: It asks for what is withheld, or is not of this package.
        """
        return validate_settings(super().settings)

    def image_frames(self) -> ImageFrames:
        """Return which frames of demonstrations need images; starts the learner when it is not there."""
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
        validate_settings(self._settings)
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
        validate_settings(self.settings)
        super().reset(instruction, visible_context(context, self._seed))

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, float64 (n,)."""
        return super().act(decode_observation(visible_observation(observation)))

    def _wanted(self) -> ImageFrames:
        wants = self._ask({"call": "wants"}, self._start_limit)
        frames = wants.get("pictures") if isinstance(wants, dict) else None
        if frames not in get_args(ImageFrames):
            self._fail("wrong answer", f"Its `pictures` is {frames!r}; it is 'all' or 'first'.")
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
        PolicySettingsError: It asks for what the challenge withholds.
    """
    seen = settings.make_obs_config()
    cameras = {**seen.cameras(), **{name: extra.config for name, extra in seen.extra_cameras.items()}}
    asked = [name for name, camera in cameras.items() if camera.mask]
    what = f"masks ({asked[0]})" if asked else ""
    what = "task_low_dim_state" if seen.task_low_dim_state else what
    what = "model.world_distances" if seen.model.world_distances else what
    if what:
        hint = "The challenge gives images, depth, point clouds and what the arm measures."
        raise PolicySettingsError("What a learner observes", what, "is withheld in the challenge", hint)
    return settings


def visible_observation(observation: Observation, *, images: bool = True) -> dict[str, Any]:
    """Return what a learner is given of an observation of a test task, as a map.

    Args:
        observation: All of it.
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
    """Return the context of a learner's policy: without the task, and with one seed for all episodes.

    A seed for each episode would be a hash of task and number, from which the task could be found by trying all names.

    Args:
        context: Context of other policies.
        seed: Seed of the run.
    """
    digest = hashlib.sha256(f"rlbench_pin challenge policy/{seed}".encode()).digest()
    return replace(context, task="", seed=int.from_bytes(digest[:8], "big") >> 11)
