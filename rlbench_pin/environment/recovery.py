"""Recovery demonstrations: a disturbance at a random moment, and the planner continues from the measured state."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rlbench_pin.environment.demos import DemoPlayer
from rlbench_pin.environment.runtime import Runtime, follow
from rlbench_pin.errors import DemoError, InvalidArgument, PlanningError
from rlbench_pin.observation import DISTURBANCES, INTERVENTION, PHASE, RECOVERY, TASK, Disturbance, Observation
from rlbench_pin.planning.kinematics import descend
from rlbench_pin.planning.plan import Plan
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, pose_to_se3
from rlbench_pin.tasks import Waypoint
from rlbench_pin.values import as_names

PUSH = 0.03
"""Distance by which a push moves the gripper [m]."""
_PUSH_TICKS, _STOP_TICKS = 6, 4
"""Number of control ticks of a push, and of a stop."""
_LEAST_HEIGHT = 0.02
"""Minimum height of the target of a push above the table [m]."""
_SHARES: dict[Disturbance, tuple[float, float]] = {"push": (0.2, 0.9), "slip": (0.05, 0.3), "stop": (0.2, 0.9)}
"""Range of the time of a disturbance, as a fraction of the duration of its segment; a slip occurs soon after the grasp."""
_CURVE_POSES = 12
"""Number of poses that describe the remainder of a curve when it is planned again."""


def as_disturbances(value: object) -> tuple[Disturbance, ...]:
    """Validate the names of disturbances, and return each once.

    Raises:
        InvalidArgument: There is no such disturbance.
    """
    names = as_names(value, "disturb", InvalidArgument)
    for name in names:
        if name not in DISTURBANCES:
            raise InvalidArgument("disturb", name, f"has to be one of {', '.join(DISTURBANCES)}")
    return tuple(kind for kind in DISTURBANCES if kind in names)


class DisturbedPlayer(DemoPlayer):
    """Plays a demonstration with one disturbance, and continues from the measured state.

    `misc["phase"]` of a frame is `task`, the name of the disturbance, or `recovery` from its end to the next waypoint.
    `misc["intervention"]` is True during the recovery: these frames show how to correct the effect of the disturbance.

    Args:
        runtime: A task at the start of an episode.
        kinds: Disturbances to choose from. `slip` occurs in the segment after a grasp.
        rng: Draws the disturbance, its time and its direction.
        record: Keep observations.
        record_gripper: Keep one observation per tick of finger motion, not only the last.
        on_frame: Function that is called with each kept observation.

    Attributes:
        happened: The disturbance that occurred; None before it.
    """

    def __init__(
        self,
        runtime: Runtime,
        kinds: Sequence[Disturbance],
        rng: np.random.Generator,
        *,
        record: bool = True,
        record_gripper: bool = False,
        on_frame: Callable[[Observation], None] | None = None,
    ) -> None:
        super().__init__(runtime, record=record, record_gripper=record_gripper, on_frame=on_frame)
        self.happened: Disturbance | None = None
        self._phase: str = TASK
        self._rng = rng
        self._order = [kinds[i] for i in rng.permutation(len(kinds)).tolist()]
        self._moment, self._part = rng.random(2).tolist()
        self._grasp: Waypoint | None = None
        self._has_gripped = False

    def play(self) -> list[Observation]:
        """Run the demonstration and return its observations.

        Raises:
            DemoError: The goal was not reached, or no segment allowed a disturbance.
        """
        frames = super().play()
        if self.happened is None:
            raise DemoError(
                f"No segment of the demonstration allows {' or '.join(self._order)}. Use another seed or other disturbances.",
                self.runtime.task,
            )
        return frames

    def flag(self, observation: Observation) -> None:
        """Write the phase into a frame."""
        super().flag(observation)
        observation.misc |= {PHASE: self._phase, INTERVENTION: self._phase == RECOVERY}

    def operate_gripper(self, waypoint: Waypoint) -> None:
        """Execute the gripper command of a waypoint, and store the grasp."""
        super().operate_gripper(waypoint)
        self._grasp = None if waypoint.releases else waypoint
        self._has_gripped = self._grips

    @property
    def _grips(self) -> bool:
        """Whether there is an object between the fingers after a waypoint has closed them."""
        gripper = self.runtime.gripper
        closed = self._grasp is not None and self._amount == self._grasp.gripper_amount
        return closed and (bool(gripper.held) or gripper.closes_on_something())

    def _due(self, waypoint: Waypoint) -> Disturbance | None:
        """Return the disturbance of the segment to a waypoint; None if there is none, or one has already occurred."""
        if self.happened is not None:
            return None
        waypoints = self.runtime.task.get_waypoints()
        grasps = [w for w in waypoints if w.gripper is not None and not w.releases]
        for kind in self._order:
            if kind != "slip":
                return kind if len(self.segments) > self._moment * len(waypoints) else None
            if self._has_gripped and waypoint.index > grasps[int(self._moment * len(grasps))].index:
                return kind
            if any(grasp.index >= waypoint.index for grasp in grasps):
                return None  # something will be gripped later
        return None

    def move(self, waypoint: Waypoint, rest: Sequence[Waypoint], plan: Plan) -> None:
        """Execute the planned motion to a waypoint, or a part of it, the disturbance, and a new plan from there."""
        kind, self._has_gripped = self._due(waypoint), False
        if kind is None:
            super().move(waypoint, rest, plan)
            return
        runtime, gripped = self.runtime, self._grips
        self.happened = kind
        low, high = _SHARES[kind]
        seconds = (low + self._part * (high - low)) * plan.trajectory.duration
        ticks = max(1, round(seconds / runtime.world.control_dt))
        follow(runtime, plan.trajectory, on_tick=self._arm_tick, compliant=waypoint.compliant, ticks=ticks)
        before = runtime.robot.tip_pose()
        self._phase = kind
        if kind == "push":
            self._push()
        elif kind == "slip":
            self._let_go()
        else:
            self._drive([runtime.robot.joint_positions] * _STOP_TICKS)
        self._phase = RECOVERY
        if kind == "slip" and runtime.gripper.closes_on_something():
            self._close()
        if gripped and not self._grips:
            self._grip_again(waypoint, rest)
        else:
            self._continue(waypoint, rest, plan, seconds, before)
        self._phase = TASK

    def _push(self) -> None:
        """Push the tip sideways within the limits of the motors, without collision checks."""
        robot, direction = self.runtime.robot, self._rng.normal(size=3)
        target = robot.tip_pose()
        step = PUSH * direction / np.linalg.norm(direction)
        if target[2] + step[2] < TABLE_HEIGHT + _LEAST_HEIGHT:
            step[2] = abs(step[2])
        target[:3] += step
        q = self.runtime.measured_start
        way = descend(self.runtime.model, pose_to_se3(target), q).q - q
        self._drive([q + tick / _PUSH_TICKS * way for tick in range(1, _PUSH_TICKS + 1)])

    def _drive(self, targets: Sequence[FloatArray]) -> None:
        """Move to joint positions (n,), one each tick [rad]."""
        for target in targets:
            self.runtime.drive_to(target)
            self._arm_tick(target)

    def _let_go(self) -> None:
        """Open the fingers to their opening before the grasp."""
        assert self._grasp is not None, "something is gripped"
        earlier = [w.gripper_amount for w in self.runtime.task.get_waypoints() if w.index < self._grasp.index]
        self._move_fingers(earlier[-1] if earlier else 1.0, release=True)

    def _close(self) -> None:
        """Close the fingers in the same way as the last grasp."""
        assert self._grasp is not None, "something was gripped"
        self._move_fingers(self._grasp.gripper_amount, release=False)

    def _grip_again(self, waypoint: Waypoint, rest: Sequence[Waypoint]) -> None:
        """Repeat the waypoints of the last grasp, from the approach, then the interrupted waypoint."""
        assert self._grasp is not None, "something was gripped"
        if self._amount == self._grasp.gripper_amount:
            self._let_go()
        waypoints = self.runtime.task.get_waypoints()
        first = self._grasp.index
        while first > 0 and waypoints[first - 1].gripper is None:
            first -= 1
        between = [w for w in waypoints if first <= w.index < waypoint.index]
        for again, following, angles in self._segments([*between, waypoint, *rest]):
            if again is waypoint:
                super().move(again, following, self._plan(again, following, angles))
                return
            self.run_segment(again, following, angles)

    def _continue(self, waypoint: Waypoint, rest: Sequence[Waypoint], plan: Plan, seconds: float, before: FloatArray) -> None:
        """Plan again to a waypoint from the present configuration.

        Args:
            waypoint: The waypoint.
            rest: The waypoints after it in its group.
            plan: The interrupted plan.
            seconds: Time at which it was interrupted [s].
            before: Tip pose at that time (7,).
        """
        angles = [self._planner.angle]
        if waypoint.path == "plan":
            try:
                super().move(waypoint, rest, self._plan(waypoint, rest, angles))
                return
            except PlanningError:
                pass  # from where the arm was it was possible
        planner, rng = self.runtime.planner, self.runtime.planning_rng
        self.runtime.refresh_planner()
        back = planner.plan_to_pose(self.runtime.measured_start, before, ignore_collisions=True, rng=rng)
        follow(self.runtime, back.trajectory, on_tick=self._arm_tick)
        if waypoint.path == "curve":
            left = np.linspace(seconds, plan.trajectory.duration, _CURVE_POSES + 1)[1:]
            poses = [self.runtime.model.tip_pose(plan.trajectory.sample(t)[0]) for t in left.tolist()]
            onward = planner.plan_curve(self.runtime.measured_start, poses, ignore_collisions=True, rng=rng)
        else:
            onward = self._plan(waypoint, rest, angles)
        super().move(waypoint, rest, onward)
