"""The baseline: OMPL's RRT-Connect with its defaults, its state check in Python over Coal on all pairs."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from rlbench_pin.planning.problems import PlanningProblem
from rlbench_pin.robot.collision import CollisionGeometry
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray

ou.setLogLevel(ou.LOG_NONE)


@dataclass(frozen=True, eq=False)
class PlainResult:
    """Result of the plain planner."""

    path: FloatArray | None
    seconds: float
    """Processor time until the path was found, or the search given up [s]."""
    checks: int
    simplify_seconds: float
    """Processor time of OMPL's simplification afterwards [s]."""


class PlainPlanner:
    """Checks states of one arm in one world with `computeCollisions` over every pair that the SRDF leaves."""

    def __init__(self, model: RobotModel, problem: PlanningProblem, margin: float) -> None:
        self.model = model
        world = problem.world
        self.geometry = CollisionGeometry(model, world.bodies, world.attached)
        self.data = model.full.createData()
        self.q = model.full_configuration(world.arm, world.fingers)
        pin.forwardKinematics(model.full, self.data, self.q)
        self.geometry.place(world.bodies, self.data.oMi[self.geometry.hand_joint])
        self.geometry.data.setSecurityMargins(self.geometry.model, np.where(self.geometry.crosses, margin, 0.0))
        self.index = model.full_index[: model.size]
        self.checks = 0

    def is_valid(self, state: ob.State) -> bool:
        """Check one state."""
        self.checks += 1
        self.q[self.index] = [state[i] for i in range(7)]
        return not pin.computeCollisions(self.model.full, self.data, self.geometry.model, self.geometry.data, self.q, True)

    def solve(self, start: FloatArray, goal: FloatArray, *, seed: int, step: float, limit: float) -> PlainResult:
        """Search for at most `limit` seconds of processor time, with edges checked every `step` [rad]; then simplify the path."""
        ou.RNG.setSeed(seed)
        self.checks = 0
        began = time.process_time()
        setup = og.SimpleSetup(self._space(step))
        setup.setStateValidityChecker(self.is_valid)
        space = setup.getStateSpace()
        ends = []
        for q in (start, goal):
            state = space.allocState()
            for i in range(7):
                state[i] = float(q[i])
            ends.append(state)
        setup.setStartAndGoalStates(*ends)
        setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
        setup.solve(ob.PlannerTerminationCondition(lambda: time.process_time() - began > limit))
        seconds = time.process_time() - began
        path, checks, began = None, self.checks, time.process_time()
        if setup.haveExactSolutionPath():
            setup.simplifySolution(limit)
            path = np.array([[state[i] for i in range(7)] for state in setup.getSolutionPath().getStates()])
        return PlainResult(path, seconds, checks, time.process_time() - began)

    def _space(self, step: float) -> ob.RealVectorStateSpace:
        limits = self.model.limits
        space = ob.RealVectorStateSpace(7)
        bounds = ob.RealVectorBounds(7)
        for i in range(7):
            bounds.setLow(i, float(limits.lower[i]))
            bounds.setHigh(i, float(limits.upper[i]))
        space.setBounds(bounds)
        space.setLongestValidSegmentFraction(step / space.getMaximumExtent())
        return space
