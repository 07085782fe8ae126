"""Demonstrations as examples for key frames: the cloud before each, and the pose, hand and checks to reach it with."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
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
from rlbench_pin.evaluation.baselines.key_frames.clouds import Cloud, cloud_config, make_cloud, near, switch_cameras
from rlbench_pin.evaluation.baselines.key_frames.sights import CLOSE_RADIUS, overview
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.spatial import FloatArray

ROBOT = "panda"
"""The arm of the demonstrations."""
KEPT, MARGIN = 3000, 0.05
"""Points that are kept about a key frame, and how far beyond `CLOSE_RADIUS` they reach [m]."""


@dataclass(frozen=True, eq=False)
class Example:
    """A moment at which a key frame is behind and the next one ahead."""

    whole: Cloud
    """What the cameras see, on a coarse grid."""
    close: Cloud
    """What they see about the next key frame."""
    tip: FloatArray
    """Pose of the tip, (7,)."""
    opening: float
    """Whether the hand is open."""
    step: int
    """Number of key frames behind."""
    target: FloatArray
    """Next key frame: tip pose, opening, whether collisions are ignored, (9,)."""
    sentences: tuple[str, ...]
    """What its demonstration was told to do, in several words."""


def read_key_frames(
    root: Path, task: str, demos: int = -1, on_demo: Callable[[int, int], None] = lambda done, total: None
) -> list[Example]:
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
    config, arm = cloud_config(), RobotModel(robot_description(ROBOT))
    examples: list[Example] = []
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, seed=0, renderer="cpu") as environment:
        running = environment.get_task(task)
        for number, demo in enumerate(stored, start=1):
            examples += demo_examples(demo, _observations(running, demo, lambda on: switch_cameras(config, on)), arm)
            on_demo(number, len(stored))
    return examples


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


def demo_examples(demo: Demo, seen: Iterable[Observation], arm: RobotModel) -> list[Example]:
    """Return the examples of a demonstration.

    Args:
        demo: The demonstration.
        seen: What the cameras see at its start and at every key frame but the last.
        arm: Model of the arm.
    """
    said = tuple(str(s) for s in demo[0].misc.get("descriptions", ())) or ("",)
    examples, rng = [], np.random.default_rng(0)
    for step, (target, observation) in enumerate(zip(key_frame_actions(demo), seen, strict=True)):
        cloud = make_cloud(observation, arm)
        close = cloud.where(np.unique(near(cloud.points, target[:3], CLOSE_RADIUS + MARGIN, KEPT, rng)))
        tip, opening = np.asarray(observation.gripper_pose), float(observation.gripper_open or 0.0)
        examples.append(Example(overview(cloud), close, tip, opening, step, target, said))
    return examples
