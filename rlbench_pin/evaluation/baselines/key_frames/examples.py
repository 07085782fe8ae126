"""Demonstrations as examples for key frames: the cloud before each, and the pose, hand and checks to reach it with."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rlbench_pin.datasets import key_frames, stored_demos
from rlbench_pin.environment import (
    Discrete,
    Environment,
    JointPosition,
    MoveArmThenGripper,
    TaskEnvironment,
    key_frame_actions,
)
from rlbench_pin.errors import DatasetError
from rlbench_pin.evaluation.baselines.key_frames.clouds import Cloud, cloud_config, make_cloud, switch_cameras
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.spatial import FloatArray

MOST_STEPS = 24
"""Key frames that are told apart by their number; later ones count as the last."""


@dataclass(frozen=True)
class Look:
    """What is known at one moment."""

    cloud: Cloud
    """What the cameras see."""
    tip: FloatArray
    """Pose of the tip, (7,)."""
    opening: float
    """Whether the hand is open."""


def look_at(observation: Observation) -> Look:
    """Return what an observation says, without its pictures.

    Raises:
        DatasetError: It lacks colours or point clouds.
    """
    return Look(make_cloud(observation), np.asarray(observation.gripper_pose), float(observation.gripper_open or 0.0))


@dataclass(frozen=True)
class KeyFrameExamples:
    """Moments at which a key frame is behind and the next one ahead; all of some demonstrations of one task."""

    points: FloatArray
    """(n, POINTS, 3) [m]."""
    colors: FloatArray
    """(n, POINTS, 3), 0..1."""
    neighbours: np.ndarray
    """(n, POINTS, NEIGHBOURS)."""
    tip: FloatArray
    """Pose of the tip, (n, 7)."""
    opening: FloatArray
    """Whether the hand is open, (n,)."""
    step: np.ndarray
    """Number of key frames behind, (n,)."""
    target: FloatArray
    """Next key frame: tip pose, opening, whether collisions are ignored, (n, 9)."""
    episode: np.ndarray
    """Number of its demonstration, (n,)."""
    instructions: tuple[tuple[str, ...], ...]
    """Sentences of each demonstration."""


def read_key_frames(
    root: Path, task: str, demos: int = -1, on_demo: Callable[[int, int], None] = lambda done, total: None
) -> KeyFrameExamples:
    """Read the first demonstrations of a task, spread over its variations, play them again and look at their key frames.

    Pictures need not be stored: the demonstrations start from their state and repeat their actions, and the cameras look at the
    start and at each key frame. A dataset without pictures takes a hundredth of the space and a fifth of the time.

    Args:
        root: Folder of a dataset.
        task: Name of the task.
        demos: How many; -1 is all.
        on_demo: Called with how many are done, and how many there are.

    Raises:
        DatasetError: Too few are stored, or they lack what is needed.
    """
    stored = stored_demos(root, task, demos, -1, rng=np.random.default_rng(0))
    config = cloud_config()
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, seed=0, renderer="cpu") as environment:
        running = environment.get_task(task)
        looked: list[tuple[Demo, list[Look]]] = []
        for number, demo in enumerate(stored, start=1):
            seen = _observations(running, demo, lambda on: switch_cameras(config, on))
            looked.append((demo, [look_at(observation) for observation in seen]))
            on_demo(number, len(stored))
    return make_key_frame_examples(looked)


def _observations(task: TaskEnvironment, demo: Demo, switch: Callable[[bool], None]) -> Iterator[Observation]:
    """Yield what the cameras see at the start and at every key frame but the last, which is followed by none."""
    wanted = key_frames(demo)[:-1]
    if any("joint_position_action" not in o.misc for o in demo[1:]):
        raise DatasetError("A demonstration lacks `joint_position_action`, so it cannot be played again. Record it live.")
    switch(False)
    task.reset_to_demo(demo)
    for index in range(len(demo)):
        if index > 0:
            task.step(demo[index].misc["joint_position_action"])
        if index == 0 or index in wanted:
            switch(True)
            yield task.get_observation()
            switch(False)
        if index == (wanted[-1] if wanted else 0):
            return


def make_key_frame_examples(looked: Sequence[tuple[Demo, Sequence[Look]]]) -> KeyFrameExamples:
    """Return the examples of demonstrations, each with what was seen at its start and at every key frame but the last.

    Raises:
        DatasetError: There are none.
    """
    if not looked:
        raise DatasetError("There are no demonstrations to learn from. `rlbench-pin record` makes some.")
    looks = [look for _, seen in looked for look in seen]
    clouds = [look.cloud for look in looks]
    targets = [target for demo, seen in looked for target, _ in zip(key_frame_actions(demo), seen, strict=True)]
    return KeyFrameExamples(
        points=np.stack([c.points for c in clouds]),
        colors=np.stack([c.colors for c in clouds]),
        neighbours=np.stack([c.neighbours for c in clouds]),
        tip=np.stack([look.tip for look in looks]),
        opening=np.array([look.opening for look in looks]),
        step=np.concatenate([np.arange(len(seen)) for _, seen in looked]),
        target=np.stack(targets),
        episode=np.concatenate([np.full(len(seen), number) for number, (_, seen) in enumerate(looked)]),
        instructions=tuple(tuple(str(s) for s in d[0].misc.get("descriptions", ())) or ("",) for d, _ in looked),
    )
