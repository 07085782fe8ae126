"""The few-shot baseline: it replays the nearest demonstration, with point clouds registered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from rlbench_pin.baselines.perception import camera_points, first_of_cells
from rlbench_pin.datasets import key_frames
from rlbench_pin.environment.observations import ObservationConfig
from rlbench_pin.environment.presets import key_frame_mode
from rlbench_pin.evaluation.challenge.learner import Demonstration, TrainingTask
from rlbench_pin.evaluation.policies.adapters import KeyFrame, KeyFramePolicy
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.evaluation.policies.settings import blank_observations
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import TABLE_HEIGHT, compose, pose_at

CAMERAS = ("left_shoulder", "right_shoulder", "overhead", "front")
"""Cameras whose images are used."""
LOW, HIGH = np.array([-0.12, -0.7, TABLE_HEIGHT + 0.006]), np.array([0.85, 0.7, TABLE_HEIGHT + 0.9])
"""Corners of the box in which points are used, in world coordinates [m]."""
ARM_RADIUS, GRIPPER_RADIUS = 0.11, 0.13
"""Points nearer than this to the lines between the joints, or from the last joint to the tip, belong to the arm [m]."""
GRAIN = 0.007
"""Edge of the cubic cells of which each keeps one point [m]."""


def scene_points(observation: Observation) -> np.ndarray:
    """Return the points of a scene without the arm: x, y, z [m] and the scaled colour (see `COLOUR`), shape (n, 6).

    Args:
        observation: Observation with `rgb` and `point_cloud` of the cameras, and `joint_poses` in `misc`.
    """
    places, colours = camera_points(observation, CAMERAS)
    points = np.column_stack([places, colours * (COLOUR / 255.0)])
    points = points[((points[:, :3] > LOW) & (points[:, :3] < HIGH)).all(axis=1)]
    points = points[_arm_distances(points[:, :3], observation) > 0.0]
    return points[first_of_cells(points[:, :3], GRAIN)]


def _arm_distances(points: np.ndarray, observation: Observation) -> np.ndarray:
    """Return the approximate distances (n,) [m] of points (n, 3) from the surface of the arm; negative inside."""
    joints = np.asarray(observation.misc["joint_poses"], dtype=float)[:, :3]
    assert observation.gripper_pose is not None
    tip = np.asarray(observation.gripper_pose, dtype=float)[:3]
    lines = [(a, b, ARM_RADIUS) for a, b in zip(joints, joints[1:]) if np.linalg.norm(b - a) > 1e-6]
    lines.append((joints[-1], tip, GRIPPER_RADIUS))
    return np.min([_line_distances(points, a, b) - radius for a, b, radius in lines], axis=0)


def _line_distances(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the distances (n,) [m] of points (n, 3) from the line segment between `a` and `b`."""
    along = np.clip(((points - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - (a + along[:, None] * (b - a)), axis=1))


COLOUR = 0.06
"""Distance that corresponds to the full range of a colour channel [m]."""
KEPT = 0.8
"""Fraction of the smallest distances in a cost; the others belong to points that are hidden in one of the scenes."""
FAR = 0.05
"""Upper bound of distances in a cost [m]."""
TURNS = np.linspace(-np.pi, np.pi, 24, endpoint=False)
"""Initial yaw angles of the registration [rad]."""
SHIFTS = [(x, y) for x in np.linspace(-0.2, 0.2, 5) for y in np.linspace(-0.2, 0.2, 5)]
"""Initial offsets between the centres of two whole scenes [m]."""
TURNING = 0.001
"""Cost of a rotation, which prefers the smaller of two equally good ones [m/rad]."""
COST_TOLERANCE = 0.001
"""Minimum relevant difference of costs [m]."""
PLACES = 40
"""Number of initial positions in the registration of a part."""
SAMPLES, REFINED = (80, 200, 500), (10, 3)
"""Numbers of points for the comparison of all initial motions and for two refinements; numbers of refined motions."""
OUTLYING, NEAR, NEIGHBOURS = 2.5, 0.2, 12
"""Outlier threshold as a multiple of the median distance; weight of point distances relative to plane distances; number of
neighbours for a surface normal."""
STEPS = 20
"""Maximum number of iterations of a refinement."""


@dataclass(frozen=True)
class PlanarMotion:
    """Motion from the scene of a demonstration to the current one: a rotation about the vertical world axis, then a shift."""

    yaw: float = 0.0
    """Rotation [rad]."""
    x: float = 0.0
    """Shift along x [m]."""
    y: float = 0.0
    """Shift along y [m]."""

    def of_points(self, points: np.ndarray) -> np.ndarray:
        """Return the moved points (n, 6); colours do not change."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        moved = points.copy()
        moved[:, 0] = c * points[:, 0] - s * points[:, 1] + self.x
        moved[:, 1] = s * points[:, 0] + c * points[:, 1] + self.y
        return moved

    def of_pose(self, pose: np.ndarray) -> np.ndarray:
        """Return the moved pose (7,)."""
        return compose(pose_at((self.x, self.y, 0.0), yaw=self.yaw), pose)

    def then(self, step: PlanarMotion) -> PlanarMotion:
        """Return the composition of this motion and a second one after it."""
        x, y = step.of_points(np.array([[self.x, self.y, 0.0, 0.0, 0.0, 0.0]]))[0, :2]
        return PlanarMotion(self.yaw + step.yaw, float(x), float(y))

    @classmethod
    def about(cls, yaw: float, center: np.ndarray, target: np.ndarray) -> PlanarMotion:
        """Return the motion with a rotation by `yaw` [rad] that moves the point `center` (2,) to `target` (2,) [m]."""
        c, s = np.cos(yaw), np.sin(yaw)
        return cls(yaw, float(target[0] - c * center[0] + s * center[1]), float(target[1] - s * center[0] - c * center[1]))


@dataclass(frozen=True)
class Match:
    """A motion and its registration error."""

    motion: PlanarMotion
    cost: float
    """Mean distance of nearest neighbours in position and scaled colour [m]."""


class Scene:
    """Target of a registration: a scene to which other scenes or parts of them are aligned.

    Args:
        points: Points of the scene, shape (n, 6).
    """

    def __init__(self, points: np.ndarray) -> None:
        self.points = points
        self._tree = KDTree(points)
        self._normals = surface_normals(points, self._tree)

    def cost(self, moved: np.ndarray) -> float:
        """Return the mean distance [m] of points (m, 6) to their nearest neighbours in this scene, without the largest."""
        return kept_mean(self._tree.query(moved, distance_upper_bound=FAR)[0])

    def whole(self, part: np.ndarray) -> Match:
        """Return the best motion of a whole scene (m, 6); its cost is measured in both directions."""
        center, here = part[:, :2].mean(axis=0), self.points[:, :2].mean(axis=0)
        tried = [PlanarMotion.about(yaw, center, here + shift) for yaw in TURNS for shift in SHIFTS]
        return self._best(part, [PlanarMotion(), *tried], both_ways=True)

    def staying(self, part: np.ndarray, motion: PlanarMotion) -> Match:
        """Return a given motion and its cost for a part (m, 6), without registration."""
        return Match(motion, self._misfit(motion, thinned(part, SAMPLES[-1])) + COST_TOLERANCE)

    def part(self, part: np.ndarray, likely: PlanarMotion) -> Match:
        """Return the best motion of a part of a scene.

        Args:
            part: Points of the part (m, 6).
            likely: Expected motion; it is only refined, unless another one is better by `COST_TOLERANCE`.
        """
        center = part[:, :2].mean(axis=0)
        places = thinned(self.points, PLACES)[:, :2]
        tried = [PlanarMotion.about(yaw, center, place) for place in places for yaw in TURNS]
        kept, other = self._best(part, [likely], both_ways=False), self._best(part, tried, both_ways=False)
        return other if other.cost + COST_TOLERANCE < kept.cost else kept

    def _best(self, part: np.ndarray, tried: Sequence[PlanarMotion], both_ways: bool) -> Match:
        """Return the best motion: compare all initial ones, refine the best with some points, and the best of them with more."""
        few, some, more = (thinned(part, most) for most in SAMPLES)
        distances = self._tree.query(np.concatenate([m.of_points(few) for m in tried]), distance_upper_bound=FAR)[0]
        costs = [kept_mean(of_one) for of_one in distances.reshape(len(tried), len(few))]
        motions = [self._refined(some, tried[i]) for i in np.argsort(costs, kind="stable")[: REFINED[0]]]
        motions = [self._refined(more, m) for m in sorted(motions, key=lambda m: self._misfit(m, some))[: REFINED[1]]]
        matches = [Match(m, self._misfit(m, more) + (self._back(m, part) if both_ways else 0.0)) for m in motions]
        return min(matches, key=lambda match: match.cost)

    def _misfit(self, motion: PlanarMotion, points: np.ndarray) -> float:
        """Return the cost of a motion [m] for points (n, 6), with the cost of its rotation."""
        return self.cost(motion.of_points(points)) + TURNING * abs(float(np.angle(np.exp(1j * motion.yaw))))

    def _back(self, motion: PlanarMotion, whole: np.ndarray) -> float:
        """Return the mean distance [m] of this scene to a moved whole scene (n, 6)."""
        here = thinned(self.points, SAMPLES[-1])
        return kept_mean(KDTree(motion.of_points(whole)).query(here, distance_upper_bound=FAR)[0])

    def _refined(self, part: np.ndarray, motion: PlanarMotion) -> PlanarMotion:
        """Return a motion after refinement by iterative closest points.

        The distances are those to the surfaces, so that a part can slide along them, and with less weight those to the points.
        """
        for _ in range(STEPS):
            moved = motion.of_points(part)
            distances, nearest = self._tree.query(moved)
            close = distances <= max(0.01, OUTLYING * float(np.median(distances)))
            ours, gaps, normals = moved[close, :3], (self.points[nearest] - moved)[close, :3], self._normals[nearest[close]]
            center = ours[:, :2].mean(axis=0)
            x, y = (ours[:, :2] - center).T
            zero, one = np.zeros_like(x), np.ones_like(x)
            flat = np.stack([np.column_stack([-y, one, zero]), np.column_stack([x, zero, one])])  # Jacobian of x and y
            rows = np.concatenate([np.einsum("nk,knj->nj", normals[:, :2], flat), *(NEAR * flat)])
            wanted = np.concatenate([(normals * gaps).sum(axis=1), *(NEAR * gaps[:, :2].T)])
            turn, *shift = np.linalg.lstsq(rows, wanted, rcond=None)[0]
            motion = motion.then(PlanarMotion.about(float(turn), center, center + shift))
            if abs(turn) < 1e-4 and np.abs(shift).max() < 1e-5:
                break
        return motion


def surface_normals(points: np.ndarray, tree: KDTree) -> np.ndarray:
    """Return the surface normals at points (n, 6), from the principal axes of their neighbours, shape (n, 3)."""
    around = points[tree.query(points, k=min(NEIGHBOURS, len(points)))[1].reshape(len(points), -1), :3]
    spread = around - around.mean(axis=1, keepdims=True)
    return np.asarray(np.linalg.eigh(np.einsum("nki,nkj->nij", spread, spread))[1][:, :, 0])


def kept_mean(distances: np.ndarray) -> float:
    """Return the mean of the smallest distances (a fraction `KEPT` of all), each clipped to `FAR`."""
    cut = np.sort(np.minimum(distances, FAR))
    return float(cut[: max(1, int(KEPT * len(cut)))].mean())


def thinned(points: np.ndarray, most: int) -> np.ndarray:
    """Return at most `most` of the points (n, 6), with even spacing in their order."""
    return points[np.linspace(0, len(points) - 1, min(most, len(points))).astype(int)]


TOGETHER = 0.2
"""Maximum distance of consecutive key frames in one part of the scene, which the gripper may touch [m]."""
RADIUS = 0.15
"""Maximum distance of the points of a part from its key frames [m]."""
FEWEST = 40
"""Minimum number of points of a part; a part with fewer gets the motion of its neighbour."""
WORDS = 0.02
"""Cost of an instruction that shares no word [m]."""
CONSIDERED = 4
"""Number of best matching demonstrations whose parts are registered."""


def nearest_config() -> ObservationConfig:
    """Return the observation settings of the learner: colours and points of four cameras, and the arm."""
    config = blank_observations()
    config.gripper_open = config.gripper_pose = config.joint_velocities = config.joint_poses = True
    for name in CAMERAS:
        config.camera(name).rgb = config.camera(name).point_cloud = True
    return config


@dataclass(frozen=True)
class Part:
    """Consecutive key frames at the same part of the scene."""

    frames: tuple[KeyFrame, ...]
    """The key frames, in order."""
    points: np.ndarray
    """Points near the key frames in the first observation, shape (n, 6); none if there are fewer than `FEWEST`."""


@dataclass(frozen=True)
class StoredDemonstration:
    """A stored demonstration."""

    words: frozenset[str]
    """Words of its instructions."""
    scene: np.ndarray
    """Points of the first observation, shape (n, 6)."""
    parts: tuple[Part, ...]
    """Its key frames, grouped by parts of the scene."""

    def word_cost(self, words: frozenset[str]) -> float:
        """Return the cost [m] of the words of an instruction: 0 for the same words, `WORDS` for no word in common."""
        return WORDS * (1.0 - len(words & self.words) / max(1, len(words | self.words)))


class Nearest:
    """A few-shot learner that stores demonstrations, without training.

    Args:
        local: Register parts of the scene separately; otherwise the scene as a whole.
    """

    pictures = "first"

    def __init__(self, local: bool = True) -> None:
        self.action_mode, self.obs_config, self.max_steps = key_frame_mode(), nearest_config(), 25
        self._local = local

    def meta_train(self, tasks: Sequence[TrainingTask]) -> None:
        """Do nothing: this learner is not trained."""

    def recall(self, learned: Mapping[str, Any]) -> None:
        """Do nothing: this learner has no trained state."""

    def adapt(self, demonstrations: Sequence[Demonstration]) -> NearestPolicy:
        """Store the demonstrations."""
        return NearestPolicy([record_of(demonstration) for demonstration in demonstrations], self._local)


class NearestPolicy(KeyFramePolicy):
    """Replays the key frames of the best matching demonstration; after a failure, those of the next one.

    Args:
        stored: The demonstrations.
        local: Register parts of the scene separately.
    """

    def __init__(self, stored: Sequence[StoredDemonstration], local: bool) -> None:
        super().__init__(nearest_config())
        self._stored, self._local = stored, local
        self._plans: list[list[KeyFrame]] = []
        self._next, self._tries, self._tip = 0, 0, np.full(7, np.nan)

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Start an episode."""
        super().reset(instruction, context)
        self._plans, self._next, self._tries, self._tip = [], 0, 0, np.full(7, np.nan)

    def predict(self, observation: Observation, instruction: str) -> KeyFrame:
        """Return the next key frame. If the arm has not moved towards the last one, that action was invalid."""
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
        """Return the key frames of the best matching demonstrations, moved to the observed scene, the best first.

        Each plan ends with the start pose.
        """
        assert observation.gripper_pose is not None
        scene, home, words = Scene(scene_points(observation)), KeyFrame(observation.gripper_pose, True), words_of(instruction)
        wholes = [(scene.whole(stored.scene), stored) for stored in self._stored]
        wholes.sort(key=lambda fit: fit[0].cost + fit[1].word_cost(words))
        ways = (True, False) if self._local else (False,)
        plans = [_moved(stored, scene, whole, words, local) for whole, stored in wholes[:CONSIDERED] for local in ways]
        return [[*frames, home] for _, frames in sorted(plans, key=lambda plan: plan[0])]


def _moved(
    stored: StoredDemonstration, scene: Scene, whole: Match, words: frozenset[str], local: bool
) -> tuple[float, list[KeyFrame]]:
    """Return the cost [m] of a demonstration, and its key frames moved to this scene, by parts or with the whole scene."""
    find = scene.part if local else scene.staying
    matches = [find(part.points, whole.motion) if len(part.points) else None for part in stored.parts]
    costs = [match.cost for match in matches if match is not None]
    frames = []
    for part, motion in zip(stored.parts, _motions(matches, whole.motion)):
        frames += [KeyFrame(motion.of_pose(f.pose), f.is_open, f.ignore_collisions) for f in part.frames]
    return (float(np.mean(costs)) if costs else whole.cost) + stored.word_cost(words), frames


def _motions(matches: Sequence[Match | None], whole: PlanarMotion) -> list[PlanarMotion]:
    """Return the motion of each part; without a match it is that of the previous part, of the next, or of the whole scene."""
    motions = [None if match is None else match.motion for match in matches]
    for order in (range(1, len(motions)), range(len(motions) - 2, -1, -1)):
        step = order.step
        for i in order:
            motions[i] = motions[i] if motions[i] is not None else motions[i - step]
    return [whole if motion is None else motion for motion in motions]


def record_of(demonstration: Demonstration) -> StoredDemonstration:
    """Return the record of a demonstration: its words, its scene and its key frames."""
    seen = demonstration.observations
    scene = scene_points(seen[0])
    groups: list[list[KeyFrame]] = []
    for frame in map(_frame, (seen[index] for index in key_frames(seen))):
        if groups and np.linalg.norm(frame.pose[:3] - groups[-1][-1].pose[:3]) < TOGETHER:
            groups[-1].append(replace(frame, ignore_collisions=True))
        else:
            groups.append([frame])
    parts = tuple(Part(tuple(group), _around(scene, group)) for group in groups)
    return StoredDemonstration(frozenset().union(*map(words_of, demonstration.instructions)), scene, parts)


def words_of(sentence: str) -> frozenset[str]:
    """Return the words of a sentence."""
    return frozenset("".join(c if c.isalnum() else " " for c in sentence.lower()).split())


def _frame(observation: Observation) -> KeyFrame:
    """Return the key frame of an observation: its tip pose and the state of its gripper."""
    assert observation.gripper_pose is not None
    return KeyFrame(observation.gripper_pose, bool((observation.gripper_open or 0.0) > 0.5))


def _around(scene: np.ndarray, frames: Sequence[KeyFrame]) -> np.ndarray:
    """Return the points (m, 6) of a scene within `RADIUS` of key frames; none if they are fewer than `FEWEST`."""
    near = np.zeros(len(scene), dtype=bool)
    for frame in frames:
        near |= np.linalg.norm(scene[:, :3] - frame.pose[:3], axis=1) < RADIUS
    return scene[near] if near.sum() >= FEWEST else scene[:0]
