"""The results of `bench_safety.py` as a page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

INTRODUCTION = """# Random actions through the safety filter

Written by `python benchmarks/bench_safety.py`. Joint velocities drawn from the full range of the motors go through
`SafeArm(JointVelocity())` in simulated scenes, {episode} ticks of 0.05 s per episode. Every tick is measured.

* `violations`: ticks beyond the limits of joint position / velocity / acceleration, as the simulator has them.
* `contacts`: ticks at which the simulator reports that the arm touches anything.
* `world`, `self`: smallest distances to the world and between parts of the arm. Margins: {margin:.0f} mm and {self_margin:g} mm;
  `below` counts ticks below them by more than {slack:g} mm.
* `avoided`: share of commands changed for the sake of distances. `clipped`: share changed for joint limits alone; a velocity
  drawn at random asks for more than the motors can accelerate in one tick. `stops`: share that was the hardest braking.
* `us`: median processor time of a filter tick by itself, on recorded states. `in the loop`: the same between steps of physics,
  with cold caches.
"""
COLUMNS = "scene | actions | violations | contacts | below | world mm | self mm | avoided | clipped | stops | us | in the loop us"


def report(content: Mapping[str, Any]) -> str:
    """Return the page."""
    text = INTRODUCTION.format(
        episode=200,
        margin=1e3 * content["margin_m"],
        self_margin=1e3 * content["self_margin_m"],
        slack=1e3 * content["slack_m"],
    )
    titles = {"fresh": "A new action in every tick", "held": f"Each action kept for {content['hold_ticks']} ticks"}
    return text + "".join(f"\n## {title}\n\n{_table(content[key])}" for key, title in titles.items() if content[key])


def _table(scenes: Mapping[str, Mapping[str, Any]]) -> str:
    rows = [COLUMNS.split(" | "), *(_row(name, [figures]) for name, figures in scenes.items())]
    if len(scenes) > 1:
        rows.append(_row("all", list(scenes.values())))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    rows.insert(1, ["-" * width for width in widths])
    return "".join("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |\n" for row in rows)


def _row(name: str, scenes: list[Mapping[str, Any]]) -> list[str]:
    total = {key: sum(s[key] for s in scenes) for key, value in scenes[0].items() if isinstance(value, int)}
    actions = total["actions"]
    shares = [f"{total[key] / actions:.2%}" for key in ("avoided", "clipped", "stops")]
    nearest = [f"{1e3 * min(s[key] for s in scenes):.2f}" for key in ("nearest_world_m", "nearest_self_m")]
    medians = [sorted(s[key]["median"] for s in scenes)[len(scenes) // 2] for key in ("tick_us", "loop_tick_us")]
    violations = f"{total['position']} / {total['velocity']} / {total['acceleration']}"
    ticks = [f"{us:.0f}" for us in medians]
    return [name, str(actions), violations, str(total["contact"]), str(total["distance"]), *nearest, *shares, *ticks]
