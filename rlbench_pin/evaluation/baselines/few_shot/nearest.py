"""Few-shot by replay: the demonstration whose scene is most like this one, its key frames moved to where things are now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rlbench_pin.datasets import key_frames
from rlbench_pin.environment.observations import ObservationConfig
from rlbench_pin.environment.presets import key_frame_mode
from rlbench_pin.evaluation.baselines.few_shot.registration import Match, PlanarMotion, Scene
from rlbench_pin.evaluation.baselines.few_shot.scenes import CAMERAS, scene_points
from rlbench_pin.evaluation.challenge.learner import Demonstration, TrainingTask
from rlbench_pin.evaluation.policies.adapters import KeyFrame, KeyFramePolicy
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.evaluation.policies.settings import blank_observations
from rlbench_pin.observation import Observation

TOGETHER = 0.2
"""Key frames that follow each other within this distance belong to one part of the scene, which the hand may touch [m]."""
RADIUS = 0.15
"""A part of the scene is what is so near to its key frames [m]."""
FEWEST = 40
"""Points of a part at least; with fewer, it moves as its neighbour does."""
WORDS = 0.02
"""Cost of an instruction without a word in common [m]."""
CONSIDERED = 4
"""Demonstrations whose scenes fit best that are looked at more closely."""


def nearest_config() -> ObservationConfig:
    """Return what the learner observes: colours and points of four cameras, and the arm."""
    config = blank_observations()
    config.gripper_open = config.gripper_pose = config.joint_velocities = config.joint_poses = True
    for name in CAMERAS:
        config.camera(name).rgb = config.camera(name).point_cloud = True
    return config


@dataclass(frozen=True)
class Part:
    """Key frames that have to do with the same part of the scene."""

    frames: tuple[KeyFrame, ...]
    points: np.ndarray
    """What is around them in the first frame, shape (n, 6); nothing where there is too little."""


@dataclass(frozen=True)
class Shown:
    """A demonstration as it is remembered."""

    words: frozenset[str]
    scene: np.ndarray
    """Points of the first frame, shape (n, 6)."""
    parts: tuple[Part, ...]

    def misses(self, said: frozenset[str]) -> float:
        """Return the cost of an instruction with these words [m]."""
        return WORDS * (1.0 - len(said & self.words) / max(1, len(said | self.words)))


class Nearest:
    """Remembers demonstrations; practises nothing.

    Args:
        local: Whether parts of the scene are looked for apart; otherwise it moves as a whole.
    """

    pictures = "first"

    def __init__(self, local: bool = True) -> None:
        self.action_mode, self.obs_config, self.max_steps = key_frame_mode(), nearest_config(), 25
        self._local = local

    def meta_train(self, tasks: Sequence[TrainingTask]) -> None:
        """Practise nothing."""

    def recall(self, learned: Mapping[str, Any]) -> None:
        """Nothing was learned."""

    def adapt(self, demonstrations: Sequence[Demonstration]) -> NearestPolicy:
        """Remember the demonstrations."""
        return NearestPolicy([remembered(demonstration) for demonstration in demonstrations], self._local)


class NearestPolicy(KeyFramePolicy):
    """Replays the key frames of the demonstration that fits best; where that did not help, those of the next one.

    Args:
        shown: The demonstrations.
        local: Whether parts of the scene are looked for apart.
    """

    def __init__(self, shown: Sequence[Shown], local: bool) -> None:
        super().__init__(nearest_config())
        self._shown, self._local = shown, local
        self._plans: list[list[KeyFrame]] = []
        self._next, self._tries, self._tip = 0, 0, np.full(7, np.nan)

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode."""
        super().reset(instruction, context)
        self._plans, self._next, self._tries, self._tip = [], 0, 0, np.full(7, np.nan)

    def predict(self, observation: Observation, instruction: str) -> KeyFrame:
        """Return the next key frame. Where the arm has not moved towards the last one, that was refused."""
        assert observation.gripper_pose is not None
        if not self._plans:
            self._plans = self._looked(observation, instruction)
        plan = self._plans[self._tries % len(self._plans)]
        here, refused = observation.gripper_pose, False
        if self._next:
            way = np.linalg.norm(plan[self._next - 1].pose[:3] - here[:3])
            refused = bool(np.array_equal(here, self._tip) and way > 0.01)
        if refused or self._next == len(plan):
            self._tries, self._next = self._tries + 1, 0
            plan = self._plans[self._tries % len(self._plans)]
        self._tip, self._next = here, self._next + 1
        return plan[self._next - 1]

    def _looked(self, observation: Observation, instruction: str) -> list[list[KeyFrame]]:
        """Return the key frames of the demonstrations that fit best, moved to what is seen; each plan ends with the way back."""
        assert observation.gripper_pose is not None
        scene, home, said = Scene(scene_points(observation)), KeyFrame(observation.gripper_pose, True), words_of(instruction)
        wholes = [(scene.whole(shown.scene), shown) for shown in self._shown]
        wholes.sort(key=lambda fit: fit[0].cost + fit[1].misses(said))
        ways = (True, False) if self._local else (False,)
        plans = [_moved(shown, scene, whole, said, local) for whole, shown in wholes[:CONSIDERED] for local in ways]
        return [[*frames, home] for _, frames in sorted(plans, key=lambda plan: plan[0])]


def _moved(shown: Shown, scene: Scene, whole: Match, said: frozenset[str], local: bool) -> tuple[float, list[KeyFrame]]:
    """Return how badly a demonstration fits, and its key frames moved to this scene, part by part or with the whole."""
    find = scene.part if local else scene.staying
    matches = [find(part.points, whole.motion) if len(part.points) else None for part in shown.parts]
    costs = [match.cost for match in matches if match is not None]
    frames = []
    for part, motion in zip(shown.parts, _motions(matches, whole.motion)):
        frames += [KeyFrame(motion.of_pose(f.pose), f.is_open, f.ignore_collisions) for f in part.frames]
    return (float(np.mean(costs)) if costs else whole.cost) + shown.misses(said), frames


def _motions(matches: Sequence[Match | None], whole: PlanarMotion) -> list[PlanarMotion]:
    """Return the motion of each part; one that is not known moves as that before it, else as that after it, else as the whole."""
    motions = [None if match is None else match.motion for match in matches]
    for order in (range(1, len(motions)), range(len(motions) - 2, -1, -1)):
        step = order.step
        for i in order:
            motions[i] = motions[i] if motions[i] is not None else motions[i - step]
    return [whole if motion is None else motion for motion in motions]


def remembered(demonstration: Demonstration) -> Shown:
    """Return what is remembered of a demonstration."""
    seen = demonstration.observations
    scene = scene_points(seen[0])
    groups: list[list[KeyFrame]] = []
    for frame in map(_frame, (seen[index] for index in key_frames(seen))):
        if groups and np.linalg.norm(frame.pose[:3] - groups[-1][-1].pose[:3]) < TOGETHER:
            groups[-1].append(replace(frame, ignore_collisions=True))
        else:
            groups.append([frame])
    parts = tuple(Part(tuple(group), _around(scene, group)) for group in groups)
    return Shown(frozenset().union(*map(words_of, demonstration.instructions)), scene, parts)


def words_of(sentence: str) -> frozenset[str]:
    """Return the words of a sentence."""
    return frozenset("".join(c if c.isalnum() else " " for c in sentence.lower()).split())


def _frame(observation: Observation) -> KeyFrame:
    assert observation.gripper_pose is not None
    return KeyFrame(observation.gripper_pose, bool((observation.gripper_open or 0.0) > 0.5))


def _around(scene: np.ndarray, frames: Sequence[KeyFrame]) -> np.ndarray:
    near = np.zeros(len(scene), dtype=bool)
    for frame in frames:
        near |= np.linalg.norm(scene[:, :3] - frame.pose[:3], axis=1) < RADIUS
    return scene[near] if near.sum() >= FEWEST else scene[:0]
