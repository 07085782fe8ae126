"""Planner and controllers of the arm: motions around what is seen, and joint velocities, one for each tick."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rlbench_pin.control import DifferentialIK, DifferentialIKConfig, PostureObjective, TrajectoryFollower, VelocityFollowing
from rlbench_pin.errors import GoalInCollision, PlanningError
from rlbench_pin.evaluation.baselines.classical.perception import as_world, near
from rlbench_pin.evaluation.baselines.classical.perception.cloud import Cloud
from rlbench_pin.planning import MotionPlanner, PlannerConfig, solve_ik
from rlbench_pin.robot import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray, se3_to_pose

MEANT = 0.07
"""What is nearer than this to where the tip goes may be touched [m]."""
PLANNING = PlannerConfig(
    max_velocity=1.5, margin=0.008, clearance=0.02, certify=False, ik_starts=15, checks=6000, attempts=1, simplify_checks=600
)
"""Free motions."""


class Driver:
    """What moves one arm: a planner in a world of boxes, a follower of trajectories, and Cartesian control.

    Args:
        arm: The arm.
        period: Time of a control tick [s].
    """

    def __init__(self, arm: RobotModel, period: float) -> None:
        self.arm, self.period = arm, period
        self._planner = MotionPlanner(arm, PLANNING)
        self._following = VelocityFollowing(arm.limits, period)
        still = PostureObjective(gain=0.0)
        self._cartesian = DifferentialIK(arm, DifferentialIKConfig(dt=period, posture=still))
        self._world: WorldSnapshot | None = None

    def update(self, things: Cloud, q: FloatArray, fingers: FloatArray) -> None:
        """Take what is seen for the world, with the arm at `q` (n,) [rad] and its fingers at `fingers` (2,) [m]."""
        self._world = as_world(things, q, fingers)
        self._planner.update(self._world)

    def reach(self, q: FloatArray, target: pin.SE3, rng: np.random.Generator) -> tuple[FloatArray, bool]:
        """Return the configuration (n,) nearest to `q` whose tip is at a placement, and whether it is free.

        Raises:
            NoIkSolution: There is none.
        """
        pose = se3_to_pose(target)
        try:
            return self._planner.reachable(q, pose, rng, ignore_collisions=False, allowed=self._meant(target)), True
        except GoalInCollision:
            return solve_ik(self.arm, pose, q, rng, starts=10)[0], False

    def plan(self, q: FloatArray, goal: FloatArray, rng: np.random.Generator) -> tuple[Trajectory, bool]:
        """Return a timed motion from `q` to `goal` (n,) [rad], and whether it goes around what is seen; else straight there."""
        try:
            meant = self._meant(self.arm.tip_se3(goal))
            return self._planner.plan_to_configuration(q, goal, allowed=meant, rng=rng).trajectory, True
        except PlanningError:
            return self._planner.plan_to_configuration(q, goal, ignore_collisions=True, rng=rng).trajectory, False

    def follower(self, trajectory: Trajectory) -> TrajectoryFollower:
        """Return what gives the joint velocity of each tick along a trajectory."""
        return TrajectoryFollower(trajectory, self._following)

    def towards(self, q: FloatArray, v: FloatArray, target: pin.SE3) -> FloatArray:
        """Return the joint velocity (n,) [rad/s] that brings the tip to a placement in one tick, as far as limits allow.

        Args:
            q: Measured configuration (n,) [rad].
            v: Last command (n,) [rad/s].
            target: Where the tip should be a tick later.
        """
        here = self.arm.tip_se3(q)
        turn = pin.log3(target.rotation @ here.rotation.T)
        twist = np.concatenate([target.translation - here.translation, turn]) / self.period
        return self._cartesian.velocity_for_twist(q, v, twist)

    def _meant(self, target: pin.SE3) -> list[str]:
        """Return the names of the boxes that the hand goes to."""
        return [] if self._world is None else near(self._world, target.translation, MEANT)
