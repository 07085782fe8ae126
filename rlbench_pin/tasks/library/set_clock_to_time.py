"""Set a clock to one of three times with the key on its back; a variant of `change_clock`, not one of the paper's 106 tasks."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, JointMoved, Task, Waypoint


class TurnedForward(JointMoved):
    """`JointMoved` in the positive direction only."""

    def met(self) -> bool:
        """Return whether the joint is now far enough from its start in the positive direction."""
        return super().met() and self.joint.position > self.start


class SetClockToTime(Task):
    """The long hand must turn forward to three, six or nine: a quarter past, half past, or a quarter to.

    The demonstration turns the key by at most half a turn. For a quarter to, it grasps the key again for the last quarter turn.
    """

    times = ("quarter_past", "half_past", "quarter_to")
    words = (
        ("a quarter past twelve", "three", "12:15"),
        ("half past twelve", "six", "12:30"),
        ("a quarter to one", "nine", "12:45"),
    )

    def init_task(self) -> None:
        """Create the condition for the forward rotation; each round turns the key by a half or a quarter turn."""
        self.forward = TurnedForward(self.world.joint("clock/hand"), 1.0)
        self.register_waypoint_ability_start(2, self._skip_unless_half)

    def variation_count(self) -> int:
        """One for each time."""
        return len(self.times)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Register the rounds for the requested time; success is the long hand at its mark after a forward rotation."""
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
        """Rotate the waypoints after the grasp: by a quarter turn in all, or by a quarter turn each."""
        quarter = [0.0, 0.0, 0.0, 0.0, 0.0, -np.sqrt(0.5), np.sqrt(0.5)]
        self.world.frame("waypoint2").set_local(quarter if quarters == 2 else [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        self.world.frame("waypoint3").set_local(quarter)
