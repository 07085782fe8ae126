"""`SafeArm`: a safety filter for any arm action mode."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from rlbench_pin.control.safety_filter import FilterCounts, SafeCommand, SafetyConfig, SafetyFilter
from rlbench_pin.environment.actions.modes import ActionSpec, ArmActionMode, checked_mode, example_call
from rlbench_pin.environment.runtime import RefusedOpening, Runtime
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.sim.arm.control import ArmControl
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_record

LIMIT_MARGIN = 0.02
"""Distance kept from joint limits, for the overshoot of the motors [rad]."""
SHARE = 0.95
"""Used fraction of the velocity limits, for the tracking error of the motors."""
ACCELERATION_SHARE = 0.9
"""Used fraction of the acceleration limits.

The simulator computes motor torques iteratively over the joints, and stops before full convergence. Light joints that heavy
ones drag along, such as the third, end a tick up to 7 % of a dt beyond the commanded velocity.
"""
UNSEEN = 2e-5
"""Motions of bodies and fingers below this value do not update the world of the filter [m, quaternion components]."""

OPENING_STEP = 0.005
"""Largest finger motion between two distance measurements of an opening [m]."""
CLOSER = 1e-4
"""Largest further decrease by an opening of a distance that is already below its minimum [m]."""


@dataclass
class RuntimeFilter:
    """The safety filter of one runtime."""

    filter: SafetyFilter
    seen: WorldSnapshot | None = None
    """The world state in the filter."""
    opened: DistanceModel | None = None
    """Distance model with other finger positions; created at the first opening."""

    def update_world(self, snapshot: WorldSnapshot) -> None:
        """Update the world of the filter if a body other than the arm has moved since the last update."""
        if self.seen is None or not _same_surroundings(snapshot, self.seen):
            self.filter.distances.update(snapshot)
            self.seen = snapshot

    def refused_opening(self, snapshot: WorldSnapshot, velocity: FloatArray, fingers: FloatArray) -> RefusedOpening | None:
        """Return why the fingers must not open to `fingers` (2,) [m] while the arm brakes from `velocity` (n,) [rad/s]."""
        model, config, bounds = self.filter.model, self.filter.config, self.filter.bounds
        if self.opened is None:
            self.opened = DistanceModel(model)
        distances, here = self.opened, snapshot.fingers
        turns = np.array(bounds.travels(velocity, bounds.braking(velocity)))
        steps = max(1, math.ceil(np.abs(fingers - here).max() / OPENING_STEP))
        minimum = which = np.zeros(0, dtype=np.intp)
        for step in range(steps + 1):
            distances.update(replace(snapshot, fingers=here + step / steps * (fingers - here)))
            if step == 0:
                which = distances.pairs_of(model.fingers.links[1:])
            found = distances.measure(which) - distances.motion.displacement(turns)[which]
            if step == 0:
                margins = np.where(distances.crosses[which], config.margin, config.self_margin)
                minimum = np.minimum(margins, found - CLOSER)
            worst = int(np.argmin(found - minimum))
            if found[worst] < minimum[worst]:
                return RefusedOpening(distances.names(which[worst]), float(found[worst]), float(minimum[worst]))
        return None


class SafeArm(ArmActionMode):
    """Run another arm mode with a safety filter on each of its control ticks.

    The filter checks the commanded joint velocity of the next tick, and replaces it if it would violate a joint limit or a
    minimum distance. Grasped bodies are part of the arm, and the fingers are at their commanded positions. A gripper action
    that would open the fingers nearer to an object than the margin has no effect; `TaskEnvironment.refused_opening` has the
    reason.

    Args:
        mode: The arm mode to filter.
        config: Margins and gains; its control tick is replaced by that of the world, and motor torque limits apply.

    Attributes:
        counts: Number of interventions of the filter by cause, in all environments that use this object.
        last: Last command of the filter in any of these environments; None before the first.
    """

    def __init__(self, mode: ArmActionMode, config: SafetyConfig | None = None) -> None:
        self.mode = checked_mode(mode, "mode", ArmActionMode, f"Write `SafeArm({example_call(mode, ArmActionMode)})`.")
        self.config = SafetyConfig(limit_margin=LIMIT_MARGIN) if config is None else as_record(config, SafetyConfig, "config")
        self.counts = FilterCounts()
        self.last: SafeCommand | None = None

    def filter_of(self, runtime: Runtime) -> RuntimeFilter:
        """Return the filter of this arm and control tick, updated with the present world."""
        runtime_filter = runtime.kept(self, lambda: self.make_filter(runtime))
        snapshot = runtime.world.snapshot()
        runtime_filter.update_world(replace(snapshot, fingers=np.maximum(snapshot.fingers, runtime.gripper.control.target)))
        return runtime_filter

    def refused_opening(self, runtime: Runtime, fingers: FloatArray) -> RefusedOpening | None:
        """Return the reason why the fingers must not open to `fingers` (2,) [m]; None if they may."""
        runtime_filter: RuntimeFilter = runtime.kept(self, lambda: self.make_filter(runtime))
        return runtime_filter.refused_opening(runtime.world.snapshot(), runtime.robot.joint_velocities, fingers)

    def make_filter(self, runtime: Runtime) -> RuntimeFilter:
        """Create the filter of one runtime."""
        limits, arm = runtime.model.limits, runtime.description
        shares = np.where(np.arange(len(limits.acceleration)) < arm.loaded_joints, arm.loaded_share, ACCELERATION_SHARE)
        reduced = replace(limits, velocity=SHARE * limits.velocity, acceleration=shares * limits.acceleration)
        config = replace(self.config, dt=runtime.world.control_dt, hold="any")
        return RuntimeFilter(SafetyFilter(runtime.model, config, limits=reduced, counts=self.counts))

    @property
    def ticks(self) -> int | None:  # type: ignore[override]
        """Number of control ticks of an action of the inner mode."""
        return self.mode.ticks

    @property
    def optional_values(self) -> int:
        """Number of optional values of the inner mode."""
        return self.mode.optional_values

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return the specification of the inner mode."""
        return self.mode.spec(runtime)

    def shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action of the inner mode."""
        return self.mode.shape(runtime)

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return the bounds of the inner mode."""
        return self.mode.bounds(runtime)

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the values after the check of the inner mode, or raise InvalidActionError if it rejects them."""
        return self.mode.check(runtime, values)

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command the motors with the inner mode; filter the command if an action takes one tick."""
        runtime_filter = self.filter_of(runtime)
        self.mode.pre_step(runtime, values)
        if self.mode.ticks == 1:
            self.filter_command(runtime, runtime_filter)

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Run the ticks of the inner action, and filter each tick of a motion."""
        runtime_filter: RuntimeFilter = runtime.kept(self, lambda: self.make_filter(runtime))
        filtered = self.mode.ticks == 1  # by `pre_step`, for the first tick

        def before_tick() -> None:
            nonlocal filtered
            if not filtered:
                self.filter_command(runtime, runtime_filter)
            filtered = False

        with runtime.calling(before=before_tick):
            self.mode.steps(runtime, values)

    @contextmanager
    def protected(self, runtime: Runtime) -> Iterator[None]:
        """Filter the present motor command of the arm in each tick of a block in which the gripper moves."""
        replaced: ArmControl | None = None

        def before_tick() -> None:
            nonlocal replaced
            if replaced is not None:  # by a command for one tick
                runtime.robot.set_control(replaced)
            control = runtime.robot.control
            replaced = control if self.filter_command(runtime, self.filter_of(runtime)).intervened else None

        with runtime.calling(before=before_tick):
            yield

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Call `post_step` of the inner mode."""
        self.mode.post_step(runtime, values)

    def filter_command(self, runtime: Runtime, runtime_filter: RuntimeFilter) -> SafeCommand:
        """Replace the motor command of the next tick by a safe one if necessary, and return it."""
        robot = runtime.robot
        q, v = robot.joint_positions, robot.joint_velocities
        self.last = runtime_filter.filter.filter(q, v, wanted_velocity(runtime, q, v))
        if self.last.intervened:
            robot.set_velocity_targets(self.last.velocity)
        return self.last


def unwrapped(mode: ArmActionMode) -> ArmActionMode:
    """Return the arm mode without its safety filters."""
    while isinstance(mode, SafeArm):
        mode = mode.mode
    return mode


def _same_surroundings(a: WorldSnapshot, b: WorldSnapshot) -> bool:
    """Return whether two snapshots differ only in the arm joints, apart from motions below the threshold."""
    if a.attached or b.attached or len(a.bodies) != len(b.bodies) or not _same(a.fingers, b.fingers):
        return False
    return all(x.layout == y.layout and _same(x.link_poses, y.link_poses) for x, y in zip(a.bodies, b.bodies, strict=True))


def _same(a: FloatArray, b: FloatArray) -> bool:
    return a is b or a.shape == b.shape and bool((np.abs(a - b) < UNSEEN).all())


def wanted_velocity(runtime: Runtime, q: FloatArray, v: FloatArray) -> FloatArray:
    """Return the joint velocity (n,) [rad/s] that results from the present motor command in the next tick."""
    control, dt = runtime.robot.control, runtime.world.control_dt
    if control.mode == "velocity":
        return control.target
    if control.mode == "position":
        return (control.target - q) / dt
    return v + dt * np.clip(runtime.model.forward_dynamics(q, v, control.target), -1e3, 1e3)
