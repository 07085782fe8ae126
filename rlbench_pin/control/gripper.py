"""A controller of parallel grippers: open, close to a width, close with a force; detects arrival, grasps and blocking.

It needs no simulator: each tick, `update` takes the measured width and force, and returns the commanded width and the force
limit. Commanded widths move at a set speed and lead the measured width by at most `lead`. So the force of blocked fingers is
bounded by the position loop with this lead, and by the force limit.

    moving  -> reached    |width - target| <= tolerance
            -> holding    closing, and the force reached its limit, or the width has not changed for `stall_time`
            -> stalled    opening, and the width has not changed for `stall_time`
    holding -> moving     the width changed by more than `slip`: the object slipped or was removed; closing continues
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
    """Largest commanded force [N]."""
    dt: float = 0.05
    """Control tick [s]."""
    speed: float = 0.1
    """Rate of change of the width [m/s]."""
    lead: float = 0.01
    """Maximum difference between commanded and measured width [m]."""
    tolerance: float = 1e-3
    """Width error below which a target is reached [m]."""
    stall_time: float = 0.15
    """Time without a change of width after which the fingers are blocked [s]."""
    stall_speed: float = 2e-3
    """Speed below which the fingers are stationary [m/s]."""
    slip: float = 2e-3
    """Change of width while holding that indicates slipping [m]."""

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
    """Commanded distance between the pads [m]."""
    force: float
    """Largest force of a finger [N]."""
    state: GripperState
    """Current state of the gripper."""

    def fingers(self) -> tuple[float, float]:
        """Return the two finger positions for the width [m]."""
        return 0.5 * self.width, 0.5 * self.width


class GripperController:
    """One gripper. Set a goal with `open`, `close` or `move`, then call `update` once per tick."""

    def __init__(self, config: GripperConfig) -> None:
        """Start with the goal to be fully open."""
        self.config = as_record(config, GripperConfig, "config")
        self.open()

    def open(self) -> None:
        """Open fully."""
        self.move(self.config.widest)

    def close(self, force: float | None = None) -> None:
        """Close until the fingers meet or hold an object with `force` [N]; None uses the largest force."""
        self.move(0.0, force)

    def move(self, width: float, force: float | None = None) -> None:
        """Move to a width [m] between 0 and fully open, with at most `force` [N].

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
        """Whether the gripper is at rest."""
        return self.state != "moving"

    @property
    def holds(self) -> bool:
        """Whether the fingers hold an object."""
        return self.state == "holding"

    def update(self, width: float, force: Sequence[float] | float = 0.0) -> GripperCommand:
        """Return the command of the next tick.

        Args:
            width: Measured distance between the pads [m].
            force: Measured force of the fingers [N], one number or one per finger; 0 without a force sensor.

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
        """Accumulate the time without a change of width."""
        slow = self._last is not None and abs(width - self._last) < self.config.stall_speed * self.config.dt
        self._still = self._still + self.config.dt if slow else 0.0
        self._last = width

    def _update_state(self, width: float, force: float, closing: bool) -> None:
        """Leave the state `moving` if the fingers have arrived or are blocked."""
        if abs(width - self.target) <= self.config.tolerance:
            self.state = "reached"
        elif (closing and force >= self.force) or self._still >= self.config.stall_time - 1e-9:
            self.state, self._held_at = "holding" if closing else "stalled", width

    def _next_width(self, width: float) -> float:
        """Return the commanded width: a step towards the target, or a width that keeps the force."""
        if self.state in ("reached", "stalled"):
            return self.target if self.state == "reached" else width
        lead = self.config.lead if self.state == "holding" else min(self.config.lead, self.config.speed * self.config.dt)
        return max(self.target, width - lead) if self.target < width else min(self.target, width + lead)
