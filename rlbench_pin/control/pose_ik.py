"""Inverse kinematics for one pose: iterations of differential inverse kinematics, with restarts.

Each step solves the QP of `differential_ik` without velocity limits, with position limits and a trust region,

    minimise    w_p ||J_p d - e_p||^2 + w_r ||J_r d - e_r||^2 + w ||d||^2
    subject to  lower <= q + d <= upper,   |d| <= r,            w = c (w_p ||e_p||^2 + w_r ||e_r||^2) + w_0

With damping in proportion to the squared error (Sugihara, "Solvability-unconcerned inverse kinematics by the
Levenberg-Marquardt method", T-RO 2011) steps are small far from the goal, where J is inaccurate, and Newton steps near the
goal. A descent stops when its error no longer halves. The next start is drawn at random between the joint limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rlbench_pin.control.checks import as_placement, as_vector, check_made_of
from rlbench_pin.control.differential_ik import PlacoArm
from rlbench_pin.errors import NoIkSolution
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import NOT_NEGATIVE, POSITIVE, check_settings, counted, ruled

_RULES = ruled(
    (POSITIVE, "position_tolerance rotation_tolerance rotation_weight step"),
    (NOT_NEGATIVE, "damping"),
    (counted(1), "steps patience starts"),
)


@dataclass(frozen=True, kw_only=True)
class PoseIKConfig:
    """Tolerances of a solution, and limits of the search."""

    position_tolerance: float = 1e-4
    """[m]."""
    rotation_tolerance: float = 1e-3
    """[rad]."""
    rotation_weight: float = 0.3
    """Weight of 1 rad of error; 1 m weighs 1."""
    damping: float = 0.1
    """c: damping per squared error."""
    step: float = 1.2
    """r: largest change of a joint in one step [rad]."""
    steps: int = 60
    """Maximum number of steps of one descent."""
    patience: int = 5
    """Number of steps within which the squared error has to halve."""
    starts: int = 60
    """Maximum number of descents; the first starts at the given configuration."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, of a wrong kind, or outside its range (also a ValueError)."""
        check_settings(self, _RULES)


@dataclass(frozen=True, eq=False)
class PoseSolution:
    """A configuration that reaches a pose, with statistics of the search."""

    q: FloatArray
    """Shape (n,), [rad]."""
    position_error: float
    """[m]."""
    rotation_error: float
    """[rad]."""
    starts: int
    """Number of descents."""
    steps: int
    """Total number of steps."""


class PoseIK:
    """Finds configurations whose tip is at a pose, inside the joint limits. Not thread-safe."""

    def __init__(self, model: RobotModel, config: PoseIKConfig = PoseIKConfig()) -> None:
        """Prepare the solver."""
        check_made_of(model, config, PoseIKConfig)
        self.model, self.config = model, config
        self._arm, self._data = PlacoArm(model), model.arm.createData()
        solver = self._arm.solver
        self._tip_task = solver.add_frame_task(model.description.tip_frame, np.eye(4))
        self._tip_task.configure("tip", "soft", 1.0, config.rotation_weight)
        self._damping_task = solver.add_regularization_task(1.0)
        solver.enable_joint_limits(True)
        solver.enable_velocity_limits(False)

    def solve(self, pose: ArrayLike, q_start: ArrayLike, rng: np.random.Generator) -> PoseSolution:
        """Return a configuration that reaches `pose`.

        Args:
            pose: Tip target (7,) in the world.
            q_start: Start of the first descent (n,), [rad].
            rng: Generator of the other starts.

        Raises:
            InvalidTarget: NaN, a wrong shape, or a quaternion of norm zero.
            NoIkSolution: No descent reached the pose; the error contains the smallest deviation.
        """
        goal = as_placement(pose)
        limits, config = self.model.limits, self.config
        q = np.clip(as_vector(q_start, self.model.size, "configuration"), limits.lower, limits.upper)
        best, steps = (math.inf, math.inf), 0
        for start in range(config.starts):
            q, errors, taken = self._descend(goal, q if start == 0 else rng.uniform(limits.lower, limits.upper))
            steps += taken
            if errors[0] <= config.position_tolerance and errors[1] <= config.rotation_tolerance:
                return PoseSolution(q, *errors, start + 1, steps)
            best = min(best, errors)
        raise NoIkSolution(np.asarray(pose, dtype=float), *best, config.starts)

    def _descend(self, goal: pin.SE3, q: FloatArray) -> tuple[FloatArray, tuple[float, float], int]:
        """Descend from `q`; return the final configuration, its position and rotation error, and the number of steps."""
        config, limits = self.config, self.model.limits
        self._tip_task.T_world_frame = goal.homogeneous
        best = math.inf
        for taken in range(config.steps):
            errors = self._errors(goal, q)
            square = errors[0] ** 2 + config.rotation_weight * errors[1] ** 2
            if errors[0] <= config.position_tolerance and errors[1] <= config.rotation_tolerance:
                return q, errors, taken
            if taken % config.patience == config.patience - 1:
                if square > 0.5 * best:
                    return q, errors, taken
                best = square
            self._arm.set_configuration(q)
            self._damping_task.configure("damping", "soft", config.damping * square + 1e-9)
            lowest, highest = np.maximum(limits.lower - q, -config.step), np.minimum(limits.upper - q, config.step)
            step = self._arm.solve(q.tolist(), lowest.tolist(), highest.tolist())
            q = np.minimum(np.maximum(q + step, limits.lower), limits.upper)
        return q, self._errors(goal, q), config.steps

    def _errors(self, goal: pin.SE3, q: FloatArray) -> tuple[float, float]:
        """Return distance [m] and angle [rad] between the tip at `q` and the goal."""
        pin.forwardKinematics(self.model.arm, self._data, q)
        tip = pin.updateFramePlacement(self.model.arm, self._data, self.model.tip_id)
        x, y, z, qx, qy, qz, qw = pin.SE3ToXYZQUAT(tip.actInv(goal)).tolist()
        return math.sqrt(x * x + y * y + z * z), 2.0 * math.atan2(math.sqrt(qx * qx + qy * qy + qz * qz), abs(qw))
