"""Inverse kinematics, sets of equivalent goals, and checks of requests.

Three descents solve inverse kinematics:

* `descend` (damped least squares, many starts) is for planning: exact to 1e-6, with bounded steps. It stops early, because
  there are other starts.
* `solve_pinned_ik` has one start and fixed joints: it has a tenth of the damping, and does not stop early. With the
  damping and the early stop of `descend`, it would not reach 2 % of the random poses that it reaches now.
* `control.PoseIK` solves a QP in each step, by PlaCo, with joint limits and a trust region as constraints.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike
from scipy.linalg.lapack import dposv

from rlbench_pin.errors import GoalInCollision, InvalidRequest, NoIkSolution, OutsideJointLimits
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3, se3_to_pose
from rlbench_pin.values import SMALLEST_NORM, as_array, as_finite, as_flag, as_names, as_number, as_record, as_vector, as_whole

TOLERANCE = 1e-6
"""Tolerance of the norm of the pose error, [m] and [rad] combined."""
LIMIT_MARGIN = 0.05
"""Distance to a joint limit below which configurations are ranked last [rad]."""
SAME = 0.1
"""Distance below which solutions are duplicates [rad]."""
MAX_STARTS = 100_000
"""Upper bound of the number of descents."""
JOINT_LIMIT_TOLERANCE = 1e-3
"""Tolerance of joint limits at the ends of a motion, which then starts or ends at the limit [rad]."""
_ITERATIONS = 40
_LARGEST_STEP = 0.6
_JOINT_WEIGHT_END = 0.4


def as_configuration(model: RobotModel, q: ArrayLike, what: str) -> FloatArray:
    """Validate a configuration (n,), [rad], of an arm, and return it.

    Args:
        model: The arm.
        q: The configuration.
        what: Its name in errors, such as `start configuration`.

    Raises:
        InvalidRequest: NaN, a wrong shape, or no numbers.
        OutsideJointLimits: A joint is beyond its limits by more than `JOINT_LIMIT_TOLERANCE`; the error names the farthest.
    """
    as_record(model, RobotModel, "model", InvalidRequest)
    vector, limits = as_vector(q, model.size, f"The {what}", InvalidRequest), model.limits
    if not limits.contains(vector, JOINT_LIMIT_TOLERANCE):
        worst = int(np.argmax(np.maximum(limits.lower - vector, vector - limits.upper)))
        limit = limits.lower[worst] if vector[worst] < limits.lower[worst] else limits.upper[worst]
        raise OutsideJointLimits(
            what, model.description.arm_joints[worst], float(vector[worst]), float(limit), JOINT_LIMIT_TOLERANCE
        )
    return vector


def as_goal_poses(pose: PoseLike | Sequence[PoseLike], what: str = "goal") -> list[FloatArray]:
    """Return a list of tip poses (7,) from one or several.

    Raises:
        InvalidRequest: There is no pose, or one has a wrong shape, NaN, or a quaternion of norm zero.
    """
    given = as_array(pose, f"The {what}", InvalidRequest)
    poses = given[None] if given.ndim == 1 else given
    if poses.ndim != 2 or poses.shape[1] != 7 or not len(poses):
        raise InvalidRequest(f"The {what}", pose, f"has to be a pose (7,) or several (m, 7), not of shape {given.shape}")
    as_finite(poses, f"The {what}", InvalidRequest)
    norms = np.linalg.norm(poses[:, 3:], axis=1)
    if not norms.min() >= SMALLEST_NORM or not np.isfinite(norms).all():
        raise InvalidRequest(f"The {what}", pose, "has a quaternion of norm zero", "Pass x, y, z, qx, qy, qz, qw.")
    return list(poses)


def as_goal_pose(pose: PoseLike, what: str = "goal") -> FloatArray:
    """Validate one tip pose (7,) and return it; raise the errors of `as_goal_poses`."""
    return as_goal_poses(as_vector(pose, 7, f"The {what}", InvalidRequest), what)[0]


def check_generator(rng: object) -> None:
    """Raise InvalidRequest unless `rng` is a numpy generator."""
    if not isinstance(rng, np.random.Generator):
        raise InvalidRequest("rng", rng, "has to be a numpy generator", "Pass `np.random.default_rng(0)`.")


def check_switches(**switches: object) -> None:
    """Raise InvalidRequest unless each is True or False."""
    for name, switch in switches.items():
        as_flag(switch, name, InvalidRequest)


def check_options(rng: object, allowed: Collection[str], free: object) -> None:
    """Raise InvalidRequest unless `rng` is a generator, `allowed` a collection of names (not a string), and `free` a bool."""
    check_switches(ignore_collisions=free)
    check_generator(rng)
    as_names(allowed, "allowed, the bodies that may be touched,", InvalidRequest)


@dataclass(frozen=True, eq=False)
class Descent:
    """Result of one descent."""

    q: FloatArray
    """Configuration (n,), [rad]."""
    error: FloatArray
    """Pose error `[linear, angular]` in the tip frame, shape (6,)."""
    converged: bool
    """Whether the pose was reached."""


def descend(model: RobotModel, target: pin.SE3, q_start: FloatArray, iterations: int = _ITERATIONS) -> Descent:
    """Descend from `q_start` to a configuration that reaches `target`, inside the joint limits.

    Each step is dq = J^T (J J^T + w I)^-1 e, where w increases with the error (Sugihara's damping). Joints that would leave
    their limits stay fixed, and the other joints take the step.
    """
    arm, data, tip = model.arm, model.data, model.tip_id
    lower, upper = model.limits.lower, model.limits.upper
    q = np.minimum(np.maximum(q_start, lower), upper)
    best = np.inf
    for i in range(iterations):
        pin.framesForwardKinematics(arm, data, q)
        error = pin.log6(data.oMf[tip].actInv(target)).vector
        square = float(error @ error)
        if square < TOLERANCE * TOLERANCE:
            return Descent(q, error, True)
        if i % 8 == 7:
            if square > 0.5 * best:
                break
            best = square
        jacobian = pin.computeFrameJacobian(arm, data, q, tip, pin.LOCAL)
        step = _step(jacobian, error, 0.5 * square + 1e-9)
        outside = ((q <= lower) & (step < 0.0)) | ((q >= upper) & (step > 0.0))
        if outside.any():
            jacobian[:, outside] = 0.0
            step = _step(jacobian, error, 0.5 * square + 1e-6)
        largest = float(np.abs(step).max())
        if largest > _LARGEST_STEP:
            step *= _LARGEST_STEP / largest
        q = np.minimum(np.maximum(q + step, lower), upper)
    return Descent(q, error, False)


def _step(jacobian: FloatArray, error: FloatArray, damping: float) -> FloatArray:
    """Return J^T (J J^T + damping I)^-1 e."""
    square = jacobian @ jacobian.T
    square.flat[::7] += damping
    _, solution, info = dposv(square, error)
    return jacobian.T @ solution if info == 0 else np.zeros(jacobian.shape[1])


def solve_ik(
    model: RobotModel,
    pose: PoseLike,
    seed_q: FloatArray,
    rng: np.random.Generator,
    *,
    starts: int = 60,
    max_solutions: int = 1,
    collision: CollisionModel | None = None,
) -> list[FloatArray]:
    """Return configurations whose tip is at `pose`, nearest to `seed_q` first, those close to a joint limit last.

    Args:
        model: The arm.
        pose: Tip pose (7,) in the world.
        seed_q: Start of the search, shape (n,), [rad]; clipped to the joint limits.
        rng: Generator of the other starts.
        starts: Maximum number of descents.
        max_solutions: Number of different solutions at which the search stops.
        collision: Collision check that rejects configurations; None accepts all.

    Raises:
        InvalidRequest: NaN, a wrong shape, or no numbers.
        NoIkSolution: No descent reaches the pose; the error contains the smallest deviation.
        GoalInCollision: All configurations that reach it collide.
    """
    as_record(model, RobotModel, "model", InvalidRequest)
    target, seed_q = pose_to_se3(as_goal_pose(pose)), as_vector(seed_q, model.size, "seed_q", InvalidRequest)
    check_generator(rng)
    counts = ((starts, "starts"), (max_solutions, "max_solutions"))
    starts, max_solutions = (as_whole(count, what, InvalidRequest, least=1, most=MAX_STARTS) for count, what in counts)
    if collision is not None:
        as_record(collision, CollisionModel, "collision", InvalidRequest)
    found, colliding, failed = _descents(model, target, seed_q, rng, starts, max_solutions, collision)
    if not found:
        raise _colliding(model, seed_q, collision, colliding) if collision and colliding else _unreached(model, pose, failed)
    return sorted(found, key=lambda q: cost(model, seed_q, q))


def _descents(
    model: RobotModel,
    target: pin.SE3,
    seed_q: FloatArray,
    rng: np.random.Generator,
    starts: int,
    enough: int,
    collision: CollisionModel | None,
) -> tuple[list[FloatArray], list[FloatArray], list[Descent]]:
    """Descend from each start; return free configurations, colliding configurations, and failed descents."""
    found: list[FloatArray] = []
    colliding: list[FloatArray] = []
    failed: list[Descent] = []
    for k in range(starts):
        end = descend(model, target, seed_q if k == 0 else draw_start(model, seed_q, rng, k))
        if not end.converged:
            failed.append(end)
            continue
        q = model.limits.nearest_turn(end.q, seed_q)
        if not any(np.abs(q - other).max() < SAME for other in (*found, *colliding)):
            (colliding if collision is not None and collision.goal_in_collision(q) else found).append(q)
            if len(found) >= enough:
                break
    return found, colliding, failed


def _colliding(model: RobotModel, seed_q: FloatArray, collision: CollisionModel, reached: list[FloatArray]) -> GoalInCollision:
    """Return the error for the nearest of the colliding configurations that reach the pose."""
    pairs, depths = collision.penetrations(min(reached, key=lambda q: cost(model, seed_q, q)))
    return GoalInCollision(pairs, len(reached), depths)


def _unreached(model: RobotModel, pose: PoseLike, failed: Sequence[Descent]) -> NoIkSolution:
    """Return the error for a pose that no descent reached, with the nearest descent."""
    closest = min(failed, key=lambda end: float(end.error @ end.error))
    position, rotation = (float(np.linalg.norm(part)) for part in (closest.error[:3], closest.error[3:]))
    return NoIkSolution(np.asarray(pose), position, rotation, len(failed), model.tip_pose(closest.q))


def cost(model: RobotModel, q_from: FloatArray, q: FloatArray) -> float:
    """Return the rank of a configuration: weighted joint distance [rad], less for the wrist, plus a penalty near joint limits."""
    lack = max(0.0, LIMIT_MARGIN - model.limits.margin(q))
    return float(np.linalg.norm(_weights(model.size) * (q - q_from))) + (2.0 if lack > 0.0 else 0.0) + 20.0 * lack


@cache
def _weights(size: int) -> FloatArray:
    """Return the weight of each joint, from the first to the last (n,)."""
    weights = np.linspace(1.0, _JOINT_WEIGHT_END, size)
    weights.setflags(write=False)
    return weights


def draw_start(model: RobotModel, seed_q: FloatArray, rng: np.random.Generator, k: int) -> FloatArray:
    """Draw the k-th start: first near the seed, then farther away, finally anywhere within the limits."""
    limits = model.limits
    anywhere = rng.uniform(limits.lower, limits.upper)
    blend = min(1.0, 0.15 * k)
    return seed_q + blend * (limits.nearest_turn(anywhere, seed_q) - seed_q)


POSITION_TOLERANCE, ROTATION_TOLERANCE = 1e-4, 1e-3
_PINNED_ITERATIONS = 100


def solve_pinned_ik(model: RobotModel, pose: PoseLike, q_start: FloatArray, pinned: Mapping[int, float]) -> FloatArray:
    """Find the configuration near `q_start` that reaches `pose` with some joints at given angles.

    Each step is the damped least-squares step of the free joints: dq = J^T (J J^T + w I)^-1 e.

    Args:
        model: The arm.
        pose: Tip pose (7,) in the world.
        q_start: Start of the descent (n,), [rad].
        pinned: Joint index -> angle [rad].

    Raises:
        InvalidRequest: NaN, a wrong shape, no numbers, or an unknown joint.
        NoIkSolution: The free joints cannot reach the pose.
    """
    as_record(model, RobotModel, "model", InvalidRequest)
    as_record(pinned, Mapping, "pinned", InvalidRequest)  # type: ignore[type-abstract]
    target, limits = pose_to_se3(as_goal_pose(pose)), model.limits
    joints = [as_whole(joint, "pinned joint", InvalidRequest, least=0, most=model.size - 1) for joint in pinned]
    as_vector(list(pinned.values()), len(joints), "The angles of pinned joints", InvalidRequest)
    q = as_vector(q_start, model.size, "q_start", InvalidRequest).copy()
    q[joints] = list(pinned.values())
    error = np.zeros(6)
    for _ in range(_PINNED_ITERATIONS):
        error = pin.log6(model.tip_se3(q).actInv(target)).vector
        if np.linalg.norm(error[:3]) < POSITION_TOLERANCE and np.linalg.norm(error[3:]) < ROTATION_TOLERANCE:
            return q
        jacobian = model.jacobian(q, "tip").copy()
        jacobian[:, joints] = 0.0
        square = jacobian @ jacobian.T + (1e-6 + 0.05 * float(error @ error)) * np.eye(6)
        q = np.clip(q + jacobian.T @ np.linalg.solve(square, error), limits.lower, limits.upper)
        q[joints] = list(pinned.values())
    raise NoIkSolution(np.asarray(pose), float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:])), 1)


def symmetric_poses(pose: PoseLike, order: int) -> list[FloatArray]:
    """Return the `order` equivalent poses (7,) of a gripper or an object with this rotational symmetry about the tip's z axis.

    Raises:
        InvalidRequest: `pose` is not a pose, or `order` is not an integer from 1 to 360.
    """
    T, order = pose_to_se3(as_goal_pose(pose, "pose")), as_whole(order, "order", InvalidRequest, least=1, most=360)
    turns = (pin.SE3(pin.utils.rotate("z", 2.0 * np.pi * k / order), np.zeros(3)) for k in range(order))
    return [se3_to_pose(T * turn) for turn in turns]


@dataclass(frozen=True, kw_only=True)
class PoseRegion:
    """All poses within some lengths and angles of `center`, along and about its own axes."""

    center: tuple[float, ...]
    """Pose (7,)."""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Half sizes of the box of positions [m]."""
    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Largest rotation about each axis [rad]."""

    def __post_init__(self) -> None:
        """Raise InvalidRequest if the centre is not a pose, or a size is negative."""
        as_goal_pose(self.center, "center of a region")
        for name in ("position", "rotation"):
            if as_vector(getattr(self, name), 3, f"PoseRegion.{name}", InvalidRequest).min() < 0.0:
                raise InvalidRequest(f"PoseRegion.{name}", getattr(self, name), "has to be three numbers >= 0")

    def sample(self, count: int, rng: np.random.Generator) -> list[FloatArray]:
        """Return `count` poses of the region, its centre first."""
        count = as_whole(count, "count", InvalidRequest, least=0, most=1_000_000)
        check_generator(rng)
        T = pose_to_se3(self.center)
        half = np.concatenate([self.position, self.rotation])
        offsets = rng.uniform(-half, half, (count, 6))
        offsets[:1] = 0.0
        return [se3_to_pose(T * pin.SE3(pin.exp3(offset[3:]), offset[:3])) for offset in offsets]


def self_motions(model: RobotModel, q: FloatArray, step: float = 0.3, count: int = 4) -> list[FloatArray]:
    """Return up to `count` configurations (n,) on each side of `q` (n,) with the same tip pose and another elbow position.

    An arm of six joints has none.

    Raises:
        InvalidRequest: NaN, a wrong shape, or no numbers.
        OutsideJointLimits: `q` is outside the joint limits.
    """
    q, step = as_configuration(model, q, "configuration"), as_number(step, "step", InvalidRequest, above=0.0)
    count = as_whole(count, "count", InvalidRequest, least=0, most=1000)
    target = model.tip_se3(q)
    found: list[FloatArray] = []
    for sign in (1.0, -1.0) if model.size > 6 else ():
        here, direction = q, sign * _null_direction(model, q)
        for _ in range(count):
            end = descend(model, target, here + step * direction)
            if not end.converged or np.abs(end.q - here).max() < 0.3 * SAME:
                break
            following = _null_direction(model, end.q)
            direction = following if following @ direction > 0.0 else -following
            here = end.q
            found.append(here)
    return found


def _null_direction(model: RobotModel, q: FloatArray) -> FloatArray:
    """Return the joint motion (n,) of length 1 that does not move the tip."""
    return np.linalg.svd(model.jacobian(q))[2][-1]
