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
    """Where a network looks from."""

    origin: FloatArray
    """In the world, (3,) [m]."""
    rotation: FloatArray
    """Its axes in the world as columns, (3, 3)."""

    @classmethod
    def of_tip(cls, pose: FloatArray) -> Frame:
        """Return the frame of a tip pose (7,)."""
        return cls(np.asarray(pose[:3], dtype=float), pose_to_matrix(pose)[:3, :3])

    def points(self, points: FloatArray) -> FloatArray:
        """Return points of the world (..., 3) in this frame."""
        moved: FloatArray = (points - self.origin) @ self.rotation
        return moved

    def axes(self, axes: FloatArray) -> FloatArray:
        """Return two axes (6,) of the world in this frame."""
        return (axes.reshape(2, 3) @ self.rotation).ravel()

    def pose(self, position: FloatArray, axes: FloatArray) -> FloatArray:
        """Return a tip pose in the world (7,) from position (3,) and axes (6,) in this frame."""
        return pose_from(self.rotation @ position + self.origin, (axes.reshape(2, 3) @ self.rotation.T).ravel())


def axes_of(pose: FloatArray) -> FloatArray:
    """Return the x and z axis of a tip pose (7,), shape (6,)."""
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


def turn(vector: FloatArray) -> FloatArray:
    """Return the rotation about a vector by its length [rad], (3, 3) (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / max(angle, 1e-12)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


LOW, HIGH = np.array([-0.3, -0.5, TABLE_HEIGHT - 0.01]), np.array([0.7, 0.5, TABLE_HEIGHT + 1.0])
"""Corners of the box that is kept, in the world [m]."""
CELL = 0.005
"""Size of the grid of which each cell keeps one point [m]."""
OWN = 0.015
"""Points nearer than this to the arm's own surface are taken for the arm [m]."""
FLAT = 0.003
"""What is less high over the table counts as table [m]."""
TABLE_SHARE = 0.1
"""Points of the table that are kept, as a share of the others."""
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
        """Return some of the points, in the order of their numbers `rows`."""
        return Cloud(self.points[rows], self.colors[rows])


def cloud_config() -> ObservationConfig:
    """Return what has to be observed for a cloud: colours and points of the four cameras, joints, gripper and tip."""
    config = image_config(IMAGE_SIZE, CAMERAS, depth=False, mask=False)
    switch_cameras(config, True)
    return config


def switch_cameras(config: ObservationConfig, on: bool) -> None:
    """Ask for colours and points of the four cameras, or for no image at all."""
    config.set_all_high_dim(False)
    for name in CAMERAS:
        camera = config.camera(name)
        camera.rgb = camera.point_cloud = on


def make_cloud(observation: Observation, arm: RobotModel) -> Cloud:
    """Fuse the images of an observation: crop, one point per cell, no arm, little table.

    Nothing is drawn at random: the same images give the same cloud.

    Args:
        observation: Colours and points of the cameras, positions of joints and fingers.
        arm: Model of the arm, to leave out its own points.

    Raises:
        DatasetError: A camera lacks colours or points, or nothing is seen in the box.
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
    """Return the rows of the points that are the first in their cell of a grid [m], cells ordered by z, y, x."""
    return first_of_cells((points - LOW)[:, ::-1], cell)


def near(points: FloatArray, middle: FloatArray, radius: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return the numbers of `count` points: some of those in a ball, spread evenly, or else the nearest; repeated if too few."""
    far = np.linalg.norm(points - middle, axis=1)
    inside = np.flatnonzero(far < radius)
    if len(inside) >= count:
        return rng.permutation(inside)[:count]
    return np.resize(np.argsort(far)[:count], count)


MAX_STEPS = 24
"""Key frames with a number of their own; later ones count as the last."""
CONTEXT = SENTENCE_SIZE + 9 + 1 + 3 + MAX_STEPS
"""Size of the encoded instruction, the state of the gripper and the number of the step."""
NAMED = 4
"""Colours of a sentence that count, in their order; each point has its likeness to each as a feature."""
LIKENESS = 3.0
"""How fast likeness falls with the distance of two colours."""
POINT = 3 + 3 + NAMED + 1
"""Numbers of a point: position, colour, likeness, whether it is the tip."""
NEIGHBOURS = 8
"""Nearest points that a point exchanges features with, itself among them."""
OVERVIEW = Frame(np.array([0.2, 0.0, TABLE_HEIGHT + 0.2]), np.eye(3))
"""From where the whole scene is seen."""
WHOLE, WHOLE_CELL = 512, 0.01
"""Points of the whole scene, and size of the grid of which each cell keeps one [m]."""
CLOSE, CLOSE_RADIUS = 256, 0.08
"""Points of the surroundings of a pose, and how far they reach [m]."""


@dataclass(frozen=True, eq=False)
class Conditioning:
    """Inputs of a network beside the cloud: instruction, tip, gripper and number of the step."""

    sentence: str
    """What to do."""
    tip: FloatArray
    """Pose of the tip, (7,)."""
    opening: float
    """Whether the gripper is open."""
    step: int
    """Number of key frames behind."""

    def row(self, frame: Frame, sentence: FloatArray) -> FloatArray:
        """Return it as numbers, as seen from a frame, (CONTEXT,), with the sentence encoded already."""
        number = np.zeros(MAX_STEPS)
        number[min(self.step, MAX_STEPS - 1)] = 1.0
        gripper = [frame.points(self.tip[:3]), frame.axes(axes_of(self.tip)), [self.opening]]
        return np.concatenate([sentence, *gripper, frame.rotation[2], number])


@dataclass(frozen=True, eq=False)
class Sight:
    """One input of a network; batches have one more dimension in front."""

    points: np.ndarray
    """(n, POINT), the tip last."""
    neighbours: np.ndarray
    """Numbers of near points, (n, NEIGHBOURS)."""
    context: np.ndarray
    """(CONTEXT,)."""

    @staticmethod
    def batch(sights: list[Sight], device: torch.device) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return points, neighbours and contexts of several on a device."""
        points, context = (
            torch.as_tensor(np.stack(c), dtype=torch.float32, device=device)
            for c in ([s.points for s in sights], [s.context for s in sights])
        )
        return points, torch.as_tensor(np.stack([s.neighbours for s in sights]), device=device), context


def sight(cloud: Cloud, conditioning: Conditioning, frame: Frame) -> Sight:
    """Return a sample of a cloud with the tip as one more point, as seen from a frame."""
    world = np.concatenate([cloud.points, conditioning.tip[None, :3]])
    colors = np.concatenate([cloud.colors / 255.0, np.zeros((1, 3))])
    flag = np.zeros((len(world), 1))
    flag[-1] = 1.0
    rows = np.concatenate([frame.points(world), colors, likeness(colors, conditioning.sentence), flag], axis=1)
    near_by = cKDTree(world).query(world, k=NEIGHBOURS)[1]
    return Sight(rows.astype(np.float32), near_by, conditioning.row(frame, encode_sentence(conditioning.sentence)))


def likeness(colors: FloatArray, sentence: str) -> FloatArray:
    """Return how like colours (n, 3) are to those that a sentence names, in its order, 0 to 1, (n, NAMED)."""
    named = [word for word in re.findall(r"[a-z]+", sentence.lower()) if word in PALETTE][:NAMED]
    like = np.zeros((len(colors), NAMED))
    for column, name in enumerate(named):
        like[:, column] = np.exp(-LIKENESS * distances(colors, name))
    return like


def overview(cloud: Cloud) -> Cloud:
    """Return the cloud with one point per cell of a coarse grid."""
    return cloud.where(thinned(cloud.points, WHOLE_CELL))


def whole(seen: Cloud, rng: np.random.Generator) -> Cloud:
    """Return a sample of an overview."""
    return seen.where(np.resize(rng.permutation(len(seen)), WHOLE - 1))


def close_up(cloud: Cloud, middle: FloatArray, rng: np.random.Generator) -> Cloud:
    """Return a sample of what is about a place (3,)."""
    return cloud.where(near(cloud.points, middle, CLOSE_RADIUS, CLOSE - 1, rng))


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
    """Whether the gripper is open."""
    step: int
    """Number of key frames behind."""
    target: FloatArray
    """Next key frame: tip pose, opening, whether collisions are ignored, (9,)."""
    sentences: tuple[str, ...]
    """Instructions of its demonstration."""
    joint_names: tuple[str, ...] = ()
    """Joints of the arm that made its demonstration; empty where it does not say."""


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
    """Yield what the cameras see at the start and at every key frame but the last, which is followed by none."""
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
        seen: What the cameras see at its start and at every key frame but the last.
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
