"""The results of `bench_safety.py` as a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

INTRODUCTION = """# Random actions through the safety filter

Written by `python benchmarks/bench_safety.py` from {found} of {planned} pieces: {actions:,} actions, {ticks:,} ticks of 0.05 s,
{violations:,} violations. Joint velocities drawn from the full range of the motors go through `SafeArm(JointVelocity())` in
simulated scenes; one action in twelve opens or shuts the gripper. Every tick is measured, also while the fingers move.

* `violations`: ticks beyond the limits of joint position / velocity / acceleration, as the simulator has them.
* `hardest`: largest acceleration, mean over a tick, as a share of the joint's limit.
* `contacts`: ticks at which the simulator reports that the arm touches anything but a body between its fingers.
* `openings`: commands to open the shut gripper, and how many of them were refused because the fingers had no room.
* `world`, `self`: smallest distances to the world and between parts of the arm. Margins: {margin:.0f} mm and {self_margin:g} mm;
  `below` counts ticks below them by more than {slack:g} mm.
* `avoided`: share of commands changed for the sake of distances. `clipped`: share changed for joint limits and torques alone; a
  velocity drawn at random asks for more than the motors can accelerate in one tick. `stops`: share that was the hardest braking.
* `us`: median processor time of a filter tick by itself, on recorded states. `in the loop`: the same between steps of physics,
  with cold caches, and with what it takes to take over a world that moved.
"""
COLUMNS = (
    "scene", "actions", "ticks", "violations", "hardest", "contacts", "below", "world mm", "self mm", "openings",
    "avoided", "clipped", "stops", "us", "in the loop us",
)  # fmt: skip
Scene = Mapping[str, Any]


def report(content: Mapping[str, Any]) -> str:
    """Return the page."""
    held: Mapping[str, Mapping[str, Scene]] = content["held"]
    scenes = [scene for of_hold in held.values() for scene in of_hold.values()]
    found, planned = content["shards"]
    text = INTRODUCTION.format(
        found=found,
        planned=planned,
        actions=_sum(scenes, "actions"),
        ticks=_sum(scenes, "ticks"),
        violations=sum(_sum(scenes, kind) for kind in ("position", "velocity", "acceleration", "contact", "distance")),
        margin=1e3 * content["margin_m"],
        self_margin=1e3 * content["self_margin_m"],
        slack=1e3 * content["slack_m"],
    )
    titles = {hold: "A new action in every tick" if hold == "1" else f"Each action kept for {hold} ticks" for hold in held}
    return text + "".join(f"\n## {title}\n\n{_table(held[hold])}" for hold, title in titles.items() if held[hold])


def _table(scenes: Mapping[str, Scene]) -> str:
    rows = [COLUMNS, *(_row(name, [figures]) for name, figures in scenes.items())]
    if len(scenes) > 1:
        rows.append(_row("all", list(scenes.values())))
    widths = [max(len(row[i]) for row in rows) for i in range(len(COLUMNS))]
    rows.insert(1, tuple("-" * width for width in widths))
    return "".join("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |\n" for row in rows)


def _sum(scenes: Sequence[Scene], key: str) -> int:
    return sum(int(scene[key]) for scene in scenes)


def _row(name: str, scenes: Sequence[Scene]) -> tuple[str, ...]:
    ticks = _sum(scenes, "ticks")
    shares = [f"{_sum(scenes, key) / ticks:.2%}" for key in ("avoided", "clipped", "stops")]
    nearest = [f"{1e3 * min(s[key] for s in scenes):.2f}" for key in ("nearest_world_m", "nearest_self_m")]
    medians = [f"{sorted(s[key]['median'] for s in scenes)[len(scenes) // 2]:.0f}" for key in ("tick_us", "loop_tick_us")]
    violations = " / ".join(str(_sum(scenes, kind)) for kind in ("position", "velocity", "acceleration"))
    hardest = f"{max(s['hardest'] for s in scenes):.3f}"
    touched = [str(_sum(scenes, kind)) for kind in ("contact", "distance")]
    openings = f"{_sum(scenes, 'openings')} ({_sum(scenes, 'refused')} refused)"
    return name, str(_sum(scenes, "actions")), str(ticks), violations, hardest, *touched, *nearest, openings, *shares, *medians
