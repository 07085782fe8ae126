"""Set a clock to one of three times by the key at its back; a variant of `change_clock`, beside the paper's 106 tasks."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task, Waypoint


class SetClockToTime(Task):
    """The long hand must point at three, six or nine: a quarter past, half past, a quarter to."""

    times = ("quarter_past", "half_past", "quarter_to")
    words = (
        ("a quarter past twelve", "three", "12:15"),
        ("half past twelve", "six", "12:30"),
        ("a quarter to one", "nine", "12:45"),
    )

    def init_task(self) -> None:
        """Leave out the waypoint that is half of the way to half past, for the other times."""
        self.register_waypoint_ability_start(2, self.skip_a_standstill)

    def variation_count(self) -> int:
        """One for each time."""
        return len(self.times)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Turn the gripper as the time requires; success is that the long hand covers the mark of that time."""
        self.half = self.times[variation] == "half_past"
        back, quarter = self.times[variation] == "quarter_to", np.sqrt(0.5)
        self.world.frame("waypoint2").set_local([0.0, 0.0, 0.0, 0.0, 0.0, *((-quarter, quarter) if self.half else (0.0, 1.0))])
        self.world.frame("waypoint3").set_local([0.0, 0.0, 0.0, 0.0, 0.0, quarter if back else -quarter, quarter])
        sensor = self.world.sensor(self.times[variation])
        self.register_success_conditions([Detected(self.world.body("clock"), sensor)])
        time, number, digits = self.words[variation]
        return [
            f"Set the alarm clock to {time}.",
            f"It is twelve by this clock: rotate the key at its back until the long hand points to the {number}.",
            f"With the knob behind the dial, make the hands read {digits}.",
        ]

    def skip_a_standstill(self, waypoint: Waypoint) -> None:
        """Leave the waypoint out unless the time is half past."""
        waypoint.skip = not self.half
