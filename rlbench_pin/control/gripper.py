"""The parallel gripper: open, close to a width, close with a force; says when it has arrived, holds something, or is stuck.

Pure logic over measured width and force: each tick `update` takes what was measured and returns the width to command and
the largest force to apply. Commanded widths move at a set speed and never run ahead of the measured one by more than
`lead`: fingers that are held up press with no more than the position loop makes of that lead, and of the force limit.

    moving  -> reached    |width - target| <= tolerance
            -> holding    closing, and the force reached its limit, or the width has not changed for `stall_time`
            -> stalled    opening, and the width has not changed for `stall_time`
    holding -> moving     the width changed by more than `slip`: what was held slipped, or was taken away; closing goes on
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.values import POSITIVE, as_array, as_finite, as_number, as_record, check_settings

GripperState = Literal["moving", "reached", "holding", "stalled"]


@dataclass(frozen=True, kw_only=True)
class GripperConfig:
    """Settings of a gripper controller."""

    widest: float
    """Distance between the pads of the open gripper [m]."""
    force: float
    """Largest force that may ever be commanded [N]."""
    dt: float = 0.05
    """Control tick [s]."""
    speed: float = 0.1
    """At which the width changes [m/s]."""
    lead: float = 0.01
    """How far the commanded width may be ahead of the measured one [m]."""
    tolerance: float = 1e-3
    """Nearness that counts as reached [m]."""
    stall_time: float = 0.15
    """Time without a change of width after which the fingers count as blocked [s]."""
    stall_speed: float = 2e-3
    """Speed below which the fingers count as stationary [m/s]."""
    slip: float = 2e-3
    """Change of width while holding that counts as slipping [m]."""

    @classmethod
    def of(cls, robot: RobotDescription, dt: float = 0.05) -> GripperConfig:
        """Return the settings of an arm's gripper: two fingers, each opening by `gripper_open`."""
        return cls(widest=2.0 * robot.gripper_open, force=robot.gripper_force, dt=dt)

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is not finite and > 0 (also a ValueError)."""
        check_settings(self, dict.fromkeys(vars(self), POSITIVE))


@dataclass(frozen=True, slots=True)
class GripperCommand:
    """Command of the next tick."""

    width: float
    """Distance between the pads to drive to [m]."""
    force: float
    """Largest force of a finger [N]."""
    state: GripperState
    """Current state of the gripper."""

    def fingers(self) -> tuple[float, float]:
        """Return the two finger positions [m] that make the width."""
        return 0.5 * self.width, 0.5 * self.width


class GripperController:
    """One gripper. Set a goal with `open`, `close` or `move`, then call `update` once per tick."""

    def __init__(self, config: GripperConfig) -> None:
        """Start with the goal of standing open."""
        self.config = as_record(config, GripperConfig, "config")
        self.open()

    def open(self) -> None:
        """Open all the way."""
        self.move(self.config.widest)

    def close(self, force: float | None = None) -> None:
        """Close until the fingers meet or something is held with `force` [N]; None is the largest."""
        self.move(0.0, force)

    def move(self, width: float, force: float | None = None) -> None:
        """Go to a width [m] between 0 and the widest, with at most `force` [N].

        Raises:
            InvalidTarget: NaN or infinity, or a force that is not > 0 (also a ValueError).
        """
        width = as_number(width, "a gripper width [m]", InvalidTarget)
        limit = self.config.force if force is None else as_number(force, "a gripping force [N]", InvalidTarget, above=0.0)
        self.target, self.force = min(max(width, 0.0), self.config.widest), min(limit, self.config.force)
        self.state: GripperState = "moving"
        self._last: float | None = None
        self._still = 0.0
        self._held_at = 0.0

    @property
    def done(self) -> bool:
        """Whether the gripper has come to rest."""
        return self.state != "moving"

    @property
    def holds(self) -> bool:
        """Whether the fingers press on something."""
        return self.state == "holding"

    def update(self, width: float, force: Sequence[float] | float = 0.0) -> GripperCommand:
        """Return what to do during the next tick.

        Args:
            width: Measured distance between the pads [m].
            force: Measured force of the fingers [N], one number or one per finger; where nothing measures it, 0.

        Raises:
            InvalidTarget: NaN or infinity.
        """
        width = as_number(width, "measured width [m]", InvalidTarget)
        forces = as_array(force, "measured force [N]", InvalidTarget)
        measured = as_finite(forces, "measured force [N]", InvalidTarget).ravel().tolist()
        if not measured:
            raise InvalidTarget("measured force [N]", force, "has to be a number, or one for each finger")
        closing = self.target < width
        self._note_motion(width)
        if self.state == "holding" and abs(width - self._held_at) > self.config.slip:
            self.state, self._still = "moving", 0.0
        if self.state == "moving":
            self._update_state(width, max(abs(f) for f in measured), closing)
        return GripperCommand(self._next_width(width), self.force, self.state)

    def _note_motion(self, width: float) -> None:
        """Add up the time without a change of width."""
        slow = self._last is not None and abs(width - self._last) < self.config.stall_speed * self.config.dt
        self._still = self._still + self.config.dt if slow else 0.0
        self._last = width

    def _update_state(self, width: float, force: float, closing: bool) -> None:
        """Leave the state `moving` when there is a reason."""
        if abs(width - self.target) <= self.config.tolerance:
            self.state = "reached"
        elif (closing and force >= self.force) or self._still >= self.config.stall_time - 1e-9:
            self.state, self._held_at = "holding" if closing else "stalled", width

    def _next_width(self, width: float) -> float:
        """Return the width to command: a step towards the target, or where it keeps pressing."""
        if self.state in ("reached", "stalled"):
            return self.target if self.state == "reached" else width
        lead = self.config.lead if self.state == "holding" else min(self.config.lead, self.config.speed * self.config.dt)
        return max(self.target, width - lead) if self.target < width else min(self.target, width + lead)
