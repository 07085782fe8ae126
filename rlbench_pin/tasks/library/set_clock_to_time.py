"""Set a clock to one of three times by the key at its back; a variant of `change_clock`, beside the paper's 106 tasks."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, JointMoved, Task, Waypoint


class TurnedForward(JointMoved):
    """As `JointMoved`, and the joint is beyond its start, not before it."""

    def met(self) -> bool:
        """Return whether the joint is far enough from its start now, forwards."""
        return super().met() and self.joint.position > self.start


class SetClockToTime(Task):
    """The long hand must turn forward to three, six or nine: a quarter past, half past, a quarter to.

    The key is turned by a half at once; for a quarter to the hand then grips it again and turns it by the last quarter.
    """

    times = ("quarter_past", "half_past", "quarter_to")
    words = (
        ("a quarter past twelve", "three", "12:15"),
        ("half past twelve", "six", "12:30"),
        ("a quarter to one", "nine", "12:45"),
    )

    def init_task(self) -> None:
        """The way forward counts; the rounds of the waypoints turn by a half or by a quarter."""
        self.forward = TurnedForward(self.world.joint("clock/hand"), 1.0)
        self.register_waypoint_ability_start(2, self._skip_unless_half)

    def variation_count(self) -> int:
        """One for each time."""
        return len(self.times)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Plan the rounds that the time asks for; success is that the long hand went forward and covers the mark of that time."""
        self.quarters = ((1,), (2,), (2, 1))[variation]
        self.register_rounds(len(self.quarters))
        self._turn_by(self.quarters[0])
        covers = Detected(self.world.body("clock"), self.world.sensor(self.times[variation]))
        self.register_success_conditions([covers, self.forward])
        time, number, digits = self.words[variation]
        return self.make_instructions(time=time, number=number, digits=digits)

    def _skip_unless_half(self, waypoint: Waypoint) -> None:
        quarters = self.quarters[self.round]
        self._turn_by(quarters)
        waypoint.skip = quarters == 1

    def _turn_by(self, quarters: int) -> None:
        """Turn the waypoints after the grip by one quarter, or by one each."""
        quarter = [0.0, 0.0, 0.0, 0.0, 0.0, -np.sqrt(0.5), np.sqrt(0.5)]
        self.world.frame("waypoint2").set_local(quarter if quarters == 2 else [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        self.world.frame("waypoint3").set_local(quarter)
