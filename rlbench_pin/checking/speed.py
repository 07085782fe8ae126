"""How long demonstrations and their segments take, and where the time goes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.checking.records import SolvedDemo
from rlbench_pin.environment.demos import SegmentReport


@dataclass(frozen=True)
class SegmentStatistics:
    """The segment to one waypoint, over all demonstrations that went there."""

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
    slowest_segment: int | None = None
    """Waypoint whose segments take most planning in all."""
    slowest_segment_planning: float = 0.0
    """Mean planning time of a demonstration's segments to it [s]."""

    @property
    def other(self) -> float:
        """Share of the process time that none of these takes."""
        return max(0.0, 1.0 - self.planning - self.physics - self.observing)

    @property
    def reason(self) -> str:
        """What the time is spent on, the largest share first."""
        segment = (
            ""
            if self.slowest_segment is None
            else f", {self.slowest_segment_planning:.2f} s of it at waypoint {self.slowest_segment}"
        )
        parts = [
            (self.physics, f"physics {self.physics:.0%} ({1000 * self.tick:.1f} ms a tick)"),
            (self.planning, f"planning {self.planning:.0%}{segment}"),
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
    for segment in (segment for demo in demos for segment in demo.segments):
        spent[segment.waypoint] = spent.get(segment.waypoint, 0.0) + segment.planning_time
    slowest = max(spent, key=spent.__getitem__, default=None)
    on_the_wall = [demo.simulated / demo.cost.wall for demo in demos if demo.cost.wall]
    return Speed(
        times_real_time=float(np.median([demo.simulated / demo.cost.process for demo in demos if demo.cost.process])),
        times_real_time_wall=float(np.median(on_the_wall)) if on_the_wall else 0.0,
        planning=sum(c.planning for c in costs) / total,
        physics=sum(c.physics for c in costs) / total,
        observing=sum(c.observing for c in costs) / total,
        tick=sum(c.physics for c in costs) / ticks if ticks else 0.0,
        slowest_segment=slowest,
        slowest_segment_planning=0.0 if slowest is None else spent[slowest] / len(demos),
    )


def segment_statistics(demos: Sequence[SolvedDemo]) -> tuple[SegmentStatistics, ...]:
    """Group the segments of demonstrations by waypoint, rounds of a repeated list together."""
    groups: dict[int, list[SegmentReport]] = {}
    for segment in (segment for demo in demos for segment in demo.segments):
        groups.setdefault(segment.waypoint, []).append(segment)
    return tuple(
        SegmentStatistics(
            waypoint,
            len(segments),
            _spread([segment.planning_time for segment in segments]),
            _spread([segment.duration for segment in segments]),
            dict(sorted(Counter(segment.method for segment in segments).items())),
        )
        for waypoint, segments in sorted(groups.items())
    )


def _spread(values: Sequence[float]) -> tuple[float, float]:
    return float(np.median(values)), float(np.percentile(values, 95))
