"""Training examples of the key-frame baseline: key frames of demonstrations, and point clouds from four cameras."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from scipy.spatial import cKDTree

from rlbench_pin.baselines.cloning.model import SENTENCE_SIZE, encode_sentence
from rlbench_pin.baselines.perception import PALETTE, arm_surface, camera_points, distances, first_of_cells
from rlbench_pin.datasets import key_frames, stored_demos
from rlbench_pin.environment import (
    Discrete,
    Environment,
    JointPosition,
    MoveArmThenGripper,
    ObservationConfig,
    TaskEnvironment,
    image_config,
    key_frame_actions,
)
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, matrix_to_pose, pose_to_matrix


@dataclass(frozen=True, eq=False)
class Frame:
    """Coordinate frame of the inputs and outputs of a network."""

    origin: FloatArray
    """Origin in the world, (3,) [m]."""
    rotation: FloatArray
    """Rotation from this frame to the world, (3, 3)."""

    @classmethod
    def of_tip(cls, pose: FloatArray) -> Frame:
        """Return the frame of a tip pose (7,)."""
        return cls(np.asarray(pose[:3], dtype=float), pose_to_matrix(pose)[:3, :3])

    def points(self, points: FloatArray) -> FloatArray:
        """Convert points (..., 3) [m] from the world to this frame."""
        moved: FloatArray = (points - self.origin) @ self.rotation
        return moved

    def axes(self, axes: FloatArray) -> FloatArray:
        """Convert two axes (6,) from the world to this frame."""
        return (axes.reshape(2, 3) @ self.rotation).ravel()

    def pose(self, position: FloatArray, axes: FloatArray) -> FloatArray:
        """Return the tip pose in the world (7,) for a position (3,) and axes (6,) in this frame."""
        return pose_from(self.rotation @ position + self.origin, (axes.reshape(2, 3) @ self.rotation.T).ravel())


def axes_of(pose: FloatArray) -> FloatArray:
    """Return the x-axis and the z-axis of a tip pose (7,), shape (6,)."""
    rotation = pose_to_matrix(pose)[:3, :3]
    return np.concatenate([rotation[:, 0], rotation[:, 2]])


def pose_from(position: FloatArray, axes: FloatArray) -> FloatArray:
    """Return the tip pose (7,) nearest to a position and two axes that need not be orthonormal.

    The z axis, along which the gripper points, is kept; the x axis is made orthogonal to it (Gram and Schmidt).
    """
    z = axes[3:] / max(float(np.linalg.norm(axes[3:])), 1e-9)
    x = axes[:3] - z * float(axes[:3] @ z)
    x = x / max(float(np.linalg.norm(x)), 1e-9)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.column_stack([x, np.cross(z, x), z]), position
    return matrix_to_pose(matrix)


LOW, HIGH = np.array([-0.3, -0.5, TABLE_HEIGHT - 0.01]), np.array([0.7, 0.5, TABLE_HEIGHT + 1.0])
"""Corners of the box of used points, in world coordinates [m]."""
CELL = 0.005
"""Edge of the grid cells, of which each keeps one point [m]."""
OWN = 0.015
"""Points nearer than this to the surface of the arm belong to the arm [m]."""
FLAT = 0.003
"""Points lower than this over the table belong to the table [m]."""
TABLE_SHARE = 0.1
"""Number of table points in a cloud, relative to the number of other points."""
CAMERAS = ("front", "left_shoulder", "right_shoulder", "wrist")
"""Cameras of the protocol PerAct-18."""
IMAGE_SIZE = (128, 128)
"""Width and height of the images [px], as in PerAct-18."""


@dataclass(frozen=True)
class Cloud:
    """Coloured points in the world."""

    points: np.ndarray
    """Positions, float32 (n, 3) [m]."""
    colors: np.ndarray
    """Red, green, blue, uint8 (n, 3)."""

    def __len__(self) -> int:
        return len(self.points)

    def where(self, rows: np.ndarray) -> Cloud:
        """Return the points with the indices `rows`, in their order."""
        return Cloud(self.points[rows], self.colors[rows])


def cloud_config() -> ObservationConfig:
    """Return the observation settings for a cloud: colours and points of the four cameras, joints, gripper and tip."""
    config = image_config(IMAGE_SIZE, CAMERAS, depth=False, mask=False)
    switch_cameras(config, True)
    return config


def switch_cameras(config: ObservationConfig, on: bool) -> None:
    """Enable colours and points of the four cameras, or disable all images."""
    config.set_all_high_dim(False)
    for name in CAMERAS:
        camera = config.camera(name)
        camera.rgb = camera.point_cloud = on


def make_cloud(observation: Observation, arm: RobotModel) -> Cloud:
    """Merge the images of an observation into one cloud: cropped, one point per cell, without the arm, with few table points.

    The result is deterministic.

    Args:
        observation: Colours and points of the cameras, positions of joints and fingers.
        arm: Model of the arm, to remove its points.

    Raises:
        DatasetError: A camera lacks colours or points, or the box contains no points except those of the arm.
    """
    points, colors = camera_points(observation, CAMERAS)
    inside = np.flatnonzero(((points > LOW) & (points < HIGH)).all(axis=1))
    rows = inside[thinned(points[inside], CELL)]
    own = arm_surface(arm, np.asarray(observation.joint_positions), np.asarray(observation.gripper_joint_positions))
    rows = rows[cKDTree(own).query(points[rows], distance_upper_bound=OWN)[0] > OWN]
    if len(rows) == 0:
        raise DatasetError(
            "No camera sees a point above the table except the arm, so there is no cloud. Check the cameras and their depth."
        )
    is_table = points[rows, 2] < TABLE_HEIGHT + FLAT
    objects, table = rows[~is_table], np.random.default_rng(0).permutation(rows[is_table])
    return Cloud(points, colors).where(np.concatenate([objects, table[: max(100, int(len(objects) * TABLE_SHARE))]]))


def thinned(points: FloatArray, cell: float) -> np.ndarray:
    """Return the index of one point per grid cell, the first, with the cells ordered by z, y, x; `cell` is the edge [m]."""
    return first_of_cells((points - LOW)[:, ::-1], cell)


def near(points: FloatArray, middle: FloatArray, radius: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return the indices of `count` points near a position.

    They are a random sample of the points in the ball around `middle`. With too few in the ball they are the nearest points,
    repeated if there are fewer than `count` in all.
    """
    far = np.linalg.norm(points - middle, axis=1)
    inside = np.flatnonzero(far < radius)
    if len(inside) >= count:
        return rng.permutation(inside)[:count]
    return np.resize(np.argsort(far)[:count], count)


MAX_STEPS = 24
"""Number of distinct key-frame indices; later key frames have the last index."""
CONTEXT = SENTENCE_SIZE + 9 + 1 + 3 + MAX_STEPS
"""Length of the context: instruction, tip, gripper, vertical direction, and index of the key frame."""
NAMED = 4
"""Number of colour words of a sentence that are used, in order; each point has its similarity to each as a feature."""
LIKENESS = 3.0
"""Decay rate of the similarity with the distance of two colours."""
POINT = 3 + 3 + NAMED + 1
"""Number of features of a point: position, colour, similarities, and whether it is the tip."""
NEIGHBOURS = 8
"""Number of nearest points in the graph of a point, including itself."""
OVERVIEW = Frame(np.array([0.2, 0.0, TABLE_HEIGHT + 0.2]), np.eye(3))
"""Frame for clouds of the whole scene."""
WHOLE, WHOLE_CELL = 512, 0.01
"""Number of points of the whole scene, including the tip, and edge of the grid cells, of which each keeps one point [m]."""
CLOSE, CLOSE_RADIUS = 256, 0.08
"""Number of points around a pose, including the tip, and their maximum distance from it [m]."""


@dataclass(frozen=True, eq=False)
class Conditioning:
    """Inputs of a network in addition to the cloud: instruction, tip, gripper and number of reached key frames."""

    sentence: str
    """The instruction."""
    tip: FloatArray
    """Pose of the tip, (7,)."""
    opening: float
    """Whether the gripper is open."""
    step: int
    """Number of key frames that were reached."""

    def row(self, frame: Frame, sentence: FloatArray) -> FloatArray:
        """Return the context vector in the coordinates of a frame, (CONTEXT,); `sentence` is the encoded instruction."""
        number = np.zeros(MAX_STEPS)
        number[min(self.step, MAX_STEPS - 1)] = 1.0
        gripper = [frame.points(self.tip[:3]), frame.axes(axes_of(self.tip)), [self.opening]]
        return np.concatenate([sentence, *gripper, frame.rotation[2], number])


@dataclass(frozen=True, eq=False)
class NetworkInput:
    """One input of a network; batches have an additional first dimension."""

    points: np.ndarray
    """Features of the points, (n, POINT); the last point is the tip."""
    neighbours: np.ndarray
    """Indices of the nearest points, (n, NEIGHBOURS)."""
    context: np.ndarray
    """Context vector, (CONTEXT,)."""

    @staticmethod
    def batch(inputs: list[NetworkInput], device: torch.device) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return the points, neighbours and contexts of several inputs as tensors on a device."""
        points, context = (
            torch.as_tensor(np.stack(c), dtype=torch.float32, device=device)
            for c in ([s.points for s in inputs], [s.context for s in inputs])
        )
        return points, torch.as_tensor(np.stack([s.neighbours for s in inputs]), device=device), context


def network_input(cloud: Cloud, conditioning: Conditioning, frame: Frame) -> NetworkInput:
    """Return the input of a network for a sampled cloud, with the tip as an additional point, in the coordinates of a frame."""
    world = np.concatenate([cloud.points, conditioning.tip[None, :3]])
    colors = np.concatenate([cloud.colors / 255.0, np.zeros((1, 3))])
    flag = np.zeros((len(world), 1))
    flag[-1] = 1.0
    rows = np.concatenate([frame.points(world), colors, likeness(colors, conditioning.sentence), flag], axis=1)
    near_by = cKDTree(world).query(world, k=NEIGHBOURS)[1]
    return NetworkInput(rows.astype(np.float32), near_by, conditioning.row(frame, encode_sentence(conditioning.sentence)))


def likeness(colors: FloatArray, sentence: str) -> FloatArray:
    """Return the similarity of colours (n, 3) to the colour words of a sentence, from 0 to 1, (n, NAMED)."""
    named = [word for word in re.findall(r"[a-z]+", sentence.lower()) if word in PALETTE][:NAMED]
    like = np.zeros((len(colors), NAMED))
    for column, name in enumerate(named):
        like[:, column] = np.exp(-LIKENESS * distances(colors, name))
    return like


def overview(cloud: Cloud) -> Cloud:
    """Return the cloud with one point per cell of a coarse grid."""
    return cloud.where(thinned(cloud.points, WHOLE_CELL))


def whole(seen: Cloud, rng: np.random.Generator) -> Cloud:
    """Return a random sample of `WHOLE` - 1 points of an overview."""
    return seen.where(np.resize(rng.permutation(len(seen)), WHOLE - 1))


def close_up(cloud: Cloud, middle: FloatArray, rng: np.random.Generator) -> Cloud:
    """Return a random sample of `CLOSE` - 1 points around a position (3,) [m]."""
    return cloud.where(near(cloud.points, middle, CLOSE_RADIUS, CLOSE - 1, rng))


ROBOT = "panda"
"""The arm of the demonstrations."""
KEPT, MARGIN = 3000, 0.05
"""Maximum number of stored points around a key frame, and their maximum distance beyond `CLOSE_RADIUS` [m]."""


@dataclass(frozen=True, eq=False)
class Example:
    """A training example: the observation at one key frame, and the next key frame as the target."""

    whole: Cloud
    """Cloud of the scene on a coarse grid."""
    close: Cloud
    """Cloud around the next key frame."""
    tip: FloatArray
    """Pose of the tip, (7,)."""
    opening: float
    """Whether the gripper is open."""
    step: int
    """Number of key frames that were reached."""
    target: FloatArray
    """Next key frame: tip pose, opening, whether collisions are ignored, (9,)."""
    sentences: tuple[str, ...]
    """Instructions of the demonstration."""
    joint_names: tuple[str, ...] = ()
    """Joint names of the arm of the demonstration; empty if unknown."""


def read_key_frames(
    root: Path, task: str, demos: int = -1, on_demo: Callable[[int, int], None] = lambda done, total: None
) -> list[Example]:
    """Read the first demonstrations of a task, spread over its variations, replay them and observe their key frames.

    Images need not be stored: the demonstrations start from their state and repeat their actions, and the images are
    rendered at the start and at each key frame. A dataset without images needs a hundredth of the space and a fifth of the time.

    Args:
        root: Folder of a dataset.
        task: Name of the task.
        demos: Number of demonstrations; -1 reads all.
        on_demo: Function that is called with the number of completed demonstrations, and their total number.

    Raises:
        DatasetError: Too few demonstrations are stored, or they lack a field.
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
    """Replay a demonstration and yield the observations at its start and at each key frame except the last.

    Args:
        task: The task.
        demo: The demonstration.
        switch: Function that enables or disables the images of the task.
    """
    wanted = key_frames(demo)[:-1]
    if any("joint_position_action" not in o.misc for o in demo[1:]):
        raise DatasetError(
            "A demonstration lacks `joint_position_action`, so it cannot be replayed. Record it with `rlbench-pin record`."
        )
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
        seen: Observations at its start and at each key frame except the last.
        arm: Model of the arm.
    """
    sentences = tuple(str(s) for s in demo[0].misc.get("descriptions", ())) or ("",)
    examples, rng = [], np.random.default_rng(0)
    for step, (target, observation) in enumerate(zip(key_frame_actions(demo), seen, strict=True)):
        cloud = make_cloud(observation, arm)
        close = cloud.where(np.unique(near(cloud.points, target[:3], CLOSE_RADIUS + MARGIN, KEPT, rng)))
        tip, opening = np.asarray(observation.gripper_pose), float(observation.gripper_open or 0.0)
        examples.append(Example(overview(cloud), close, tip, opening, step, target, sentences, tuple(demo.joint_names)))
    return examples
