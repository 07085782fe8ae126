"""A safety filter in front of any arm action mode."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rlbench_pin.control.safety_filter import FilterCounts, SafeCommand, SafetyConfig, SafetyFilter
from rlbench_pin.environment.actions.arm_mode import ArmActionMode
from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray

LIMIT_MARGIN = 0.02
"""Distance kept from joint limits, for what motors overshoot [rad]."""
SHARE = 0.95
"""Share of the velocity and acceleration limits that is used, for what motors miss."""


class SafeArm:
    """Runs another arm mode, each control tick of which passes the safety filter first.

    The filter looks at the joint velocity that the motors were told to bring about in the next tick, and replaces it when a
    joint limit or a distance would be violated. Bodies that the arm holds count as part of it.

    Args:
        mode: The mode to make safe.
        config: Margins and gains; the control tick is the world's, and motors reach velocities when their torque lets them.

    Attributes:
        last: The filter's last command; None before the first.
    """

    def __init__(self, mode: ArmActionMode, config: SafetyConfig | None = None) -> None:
        self.mode, self.config = mode, config or SafetyConfig(limit_margin=LIMIT_MARGIN)
        self.last: SafeCommand | None = None
        self._filter: SafetyFilter | None = None
        self._world: WorldSnapshot | None = None

    @property
    def counts(self) -> FilterCounts:
        """How often and why the filter intervened."""
        return FilterCounts() if self._filter is None else self._filter.counts

    def action_shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action of the inner mode."""
        return self.mode.action_shape(runtime)

    def action_bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return the bounds of the inner mode."""
        return self.mode.action_bounds(runtime)

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """Return what the inner mode's numbers mean."""
        return self.mode.action_spec(runtime)

    def action(self, runtime: Runtime, action: FloatArray) -> None:
        """Run the inner action with every tick filtered."""
        self._look_at(runtime)
        with runtime.filtering(self._command):
            self.mode.action(runtime, action)

    def _look_at(self, runtime: Runtime) -> None:
        """Tell the filter the world, when something but the arm has moved."""
        guard, snapshot = self._filter_for(runtime), runtime.world.snapshot()
        if self._world is None or not _same_surroundings(snapshot, self._world):
            guard.distances.update(snapshot)
            self._world = snapshot

    def _command(self, runtime: Runtime) -> None:
        """Replace the motors' command of the coming tick by a safe one where needed."""
        robot = runtime.robot
        q, v = robot.joint_positions, robot.joint_velocities
        self.last = self._filter_for(runtime).filter(q, v, wanted_velocity(runtime, q, v))
        if self.last.intervened:
            robot.set_velocity_targets(self.last.velocity)

    def _filter_for(self, runtime: Runtime) -> SafetyFilter:
        if self._filter is None or self._filter.model is not runtime.model:
            limits, arm = runtime.model.limits, runtime.description
            shares = np.where(np.arange(len(limits.acceleration)) < arm.loaded_joints, arm.loaded_share, SHARE)
            reduced = replace(limits, velocity=SHARE * limits.velocity, acceleration=shares * limits.acceleration)
            self._filter = SafetyFilter(
                runtime.model, replace(self.config, dt=runtime.world.control_dt, hold="any"), limits=reduced
            )
            self._world = None
        return self._filter


def _same_surroundings(a: WorldSnapshot, b: WorldSnapshot) -> bool:
    """Whether two snapshots differ at most in the arm's joints."""
    if a.attached or b.attached or len(a.bodies) != len(b.bodies) or not np.array_equal(a.fingers, b.fingers):
        return False
    return all(
        x.layout == y.layout and np.array_equal(x.link_poses, y.link_poses) for x, y in zip(a.bodies, b.bodies, strict=True)
    )


def wanted_velocity(runtime: Runtime, q: FloatArray, v: FloatArray) -> FloatArray:
    """Return the joint velocity (n,) [rad/s] that the present motor command brings about in the coming tick."""
    control, dt = runtime.robot.control, runtime.world.control_dt
    if control.mode == "velocity":
        return control.target
    if control.mode == "position":
        return (control.target - q) / dt
    return v + dt * np.clip(runtime.model.forward_dynamics(q, v, control.target), -1e3, 1e3)
