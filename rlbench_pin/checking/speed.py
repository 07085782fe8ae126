"""How long demonstrations and their legs take, and where the time goes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.checking.records import SolvedDemo
from rlbench_pin.environment.demonstrate import LegReport


@dataclass(frozen=True)
class LegStatistics:
    """The leg to one waypoint, over all demonstrations that went there."""

    waypoint: int
    count: int
    planning: tuple[float, float]
    """Median and 95th percentile of the process time [s]."""
    duration: tuple[float, float]
    """Median and 95th percentile of the length of the motion [s]."""
    methods: dict[str, int]
    """How the plan was found -> how often."""

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {
            "waypoint": self.waypoint,
            "count": self.count,
            "planning_median_ms": round(1000 * self.planning[0], 1),
            "planning_p95_ms": round(1000 * self.planning[1], 1),
            "length_median_s": round(self.duration[0], 2),
            "length_p95_s": round(self.duration[1], 2),
            "methods": self.methods,
        }


@dataclass(frozen=True)
class Speed:
    """Time that resets and demonstrations of a task take."""

    times_real_time: float = 0.0
    """Median of simulated time over process time."""
    times_real_time_wall: float = 0.0
    """Median of simulated time over wall time; lower when the machine does other things as well."""
    planning: float = 0.0
    """Share of the process time."""
    physics: float = 0.0
    """Share of the process time."""
    observing: float = 0.0
    """Share of the process time."""
    tick: float = 0.0
    """Process time of the physics of one control tick [s]."""
    slowest_leg: int | None = None
    """Waypoint whose legs take most planning in all."""
    slowest_leg_planning: float = 0.0
    """Mean planning time of a demonstration's legs to it [s]."""

    @property
    def other(self) -> float:
        """Share of the process time that none of these takes."""
        return max(0.0, 1.0 - self.planning - self.physics - self.observing)

    @property
    def reason(self) -> str:
        """What the time is spent on, the largest share first."""
        leg = "" if self.slowest_leg is None else f", {self.slowest_leg_planning:.2f} s of it at waypoint {self.slowest_leg}"
        parts = [
            (self.physics, f"physics {self.physics:.0%} ({1000 * self.tick:.1f} ms a tick)"),
            (self.planning, f"planning {self.planning:.0%}{leg}"),
            (self.observing, f"observing {self.observing:.0%}"),
            (self.other, f"saving, restoring and the rest {self.other:.0%}"),
        ]
        return "; ".join(text for _, text in sorted(parts, key=lambda part: -part[0]))

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {
            "times_real_time": round(self.times_real_time, 2),
            "times_real_time_wall": round(self.times_real_time_wall, 2),
            "planning_share": round(self.planning, 3),
            "physics_share": round(self.physics, 3),
            "observing_share": round(self.observing, 3),
            "physics_tick_ms": round(1000 * self.tick, 2),
            "reason": self.reason,
        }


def speed_of(demos: Sequence[SolvedDemo]) -> Speed:
    """Add up successful demonstrations, each with its reset."""
    costs = [demo.cost for demo in demos]
    total, ticks = sum(c.process for c in costs), sum(c.ticks for c in costs)
    if not total:
        return Speed()
    spent: dict[int, float] = {}
    for leg in (leg for demo in demos for leg in demo.legs):
        spent[leg.waypoint] = spent.get(leg.waypoint, 0.0) + leg.planning_time
    slowest = max(spent, key=spent.__getitem__, default=None)
    on_the_wall = [demo.simulated / demo.cost.wall for demo in demos if demo.cost.wall]
    return Speed(
        times_real_time=float(np.median([demo.simulated / demo.cost.process for demo in demos if demo.cost.process])),
        times_real_time_wall=float(np.median(on_the_wall)) if on_the_wall else 0.0,
        planning=sum(c.planning for c in costs) / total,
        physics=sum(c.physics for c in costs) / total,
        observing=sum(c.observing for c in costs) / total,
        tick=sum(c.physics for c in costs) / ticks if ticks else 0.0,
        slowest_leg=slowest,
        slowest_leg_planning=0.0 if slowest is None else spent[slowest] / len(demos),
    )


def leg_statistics(demos: Sequence[SolvedDemo]) -> tuple[LegStatistics, ...]:
    """Group the legs of demonstrations by waypoint, rounds of a repeated list together."""
    groups: dict[int, list[LegReport]] = {}
    for leg in (leg for demo in demos for leg in demo.legs):
        groups.setdefault(leg.waypoint, []).append(leg)
    return tuple(
        LegStatistics(
            waypoint,
            len(legs),
            _spread([leg.planning_time for leg in legs]),
            _spread([leg.duration for leg in legs]),
            dict(sorted(Counter(leg.method for leg in legs).items())),
        )
        for waypoint, legs in sorted(groups.items())
    )


def _spread(values: Sequence[float]) -> tuple[float, float]:
    return float(np.median(values)), float(np.percentile(values, 95))
