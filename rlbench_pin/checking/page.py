"""The report of a check as a Markdown page and as a table for the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rlbench_pin.checking.report import TaskReport
from rlbench_pin.rates import Rate

SLOWEST = 5
SHARES = (
    "same_scene",
    "unseen",
    "stable_success",
    "replay",
    "key_frames",
    "friction_only",
    "noop",
    "random",
    "repeat",
    "accepted",
)
_RENAMED = {"idle": "noop", "lasting": "stable_success"}
Plain = Mapping[str, Any]
HEADER = (
    "task", "var", "first try", "95 %", "in tries", "scene", "unseen", "stable", "replay", "keys", "friction", "noop", "random",
    "repeat", "reach", "drift", "overlap", "demo", "plan", "speed", "verdict",
)  # fmt: skip


def page(content: Plain, images: Mapping[str, Mapping[str, str]] | None = None) -> str:
    """Return the page.

    Args:
        content: The JSON report; parts that an older report lacks are left out.
        images: Task -> content of an image (`sheet`, `map`) -> its file, relative to the page.
    """
    content = current_keys(content)
    tasks = content["tasks"]
    sections = [_head(content), overview(content), _slowest(tasks)]
    sections += [_task(name, task, (images or {}).get(name, {})) for name, task in tasks.items()]
    return "\n\n".join(section for section in sections if section) + "\n"


def current_keys(content: Plain) -> Plain:
    """Return a JSON report with the keys that format 3 has; reports of format 2 are accepted."""
    tasks = {name: {_RENAMED.get(key, key): value for key, value in task.items()} for name, task in content["tasks"].items()}
    return {**content, "tasks": tasks}


def _head(content: Plain) -> str:
    tasks = content["tasks"]
    passed = sum(task["passed"] for task in tasks.values())
    versions = ", ".join(f"{name} {version}" for name, version in content["versions"].items())
    last = content["seed"] + content["episodes"] - 1
    return (
        f"# Check of {len(tasks)} task{'s' * (len(tasks) != 1)}\n\n"
        f"{passed} of {len(tasks)} pass. {content['episodes']} demonstrations each, seeds {content['seed']} to {last}, "
        f"at most {content['max_variations']} variations and {content['max_attempts']} tries. {versions}."
    )


def overview(content: Plain) -> str:
    """Return the table of all tasks."""
    head = [
        "Task", "Variations", "First try (95 % interval)", f"Within {content['max_attempts']} tries", "In the same scene",
        "First try, unseen seeds", "Stable", "Replay", "Key frames", "Friction only", "Noop", "Random", "Repeat", "Reach",
        "Drift", "Overlap", "Length", "Planning", "x real time", "Verdict",
    ]  # fmt: skip
    rows = []
    for name, task in content["tasks"].items():
        rows.append(
            [
                f"[`{name}`](#{name})",
                len(task["variations"]),
                interval(task["first_try"]),
                share(task["within_tries"]),
                *(share(task.get(part)) for part in SHARES),
                *(_millimetres(task.get(part)) for part in ("drift", "penetration")),
                f"{task['median_simulated_s']:.1f} s",
                f"{1000 * task['median_planning_s']:.0f} ms",
                f"{task['times_real_time']:.1f}",
                "; ".join(task["faults"]) or "ok",
            ]
        )
    return markdown_table(head, rows)


def _slowest(tasks: Plain) -> str:
    timed = {name: task for name, task in tasks.items() if task["times_real_time"] > 0 and "speed" in task}
    if not timed:
        return ""
    median = np.median([task["times_real_time"] for task in timed.values()])
    slow = sorted(timed, key=lambda name: timed[name]["times_real_time"])[:SLOWEST]
    rows = [[f"`{name}`", f"{timed[name]['times_real_time']:.1f}", timed[name]["speed"]["reason"]] for name in slow]
    text = (
        "Simulated time over process time of a reset and a demonstration without images. Median of each task; "
        f"median of the tasks: {median:.1f} x real time."
    )
    return f"## Slowest tasks\n\n{text}\n\n" + markdown_table(["Task", "x real time", "Share of the process time"], rows)


def _task(name: str, task: Plain, images: Mapping[str, str]) -> str:
    parts = [f"## {name}", "; ".join(task["faults"]) or "ok", _findings(task)]
    parts += [f"![{name}, {what}]({file})" for what, file in images.items()]
    parts += [_failures(task["failures"]), _variations(task), _segments(task), _reach(task)]
    return "\n\n".join(part for part in parts if part)


def _findings(task: Plain) -> str:
    """One line for each part of the contract."""
    lines = []
    if "drift" in task:
        d, p = task["drift"], task["penetration"]
        lines.append(f"In 2 s without actions, {d['what'] or 'nothing'} moves most: {d['mm']:.3f} mm (seed {d['seed']}).")
        lines.append(f"Deepest overlap at a reset: {p['mm']:.3f} mm (seed {p['seed']}).")
        left = ", ".join(task["left_over"])
        lines.append(f"Changed in the next episode: {left or 'nothing'} ({share(task['tidy'])} episodes change nothing).")
        lines.append(f"Speed: {task['speed']['times_real_time']:.1f} x real time; {task['speed']['reason']}.")
    return "\n".join(f"- {line}" for line in lines)


def _failures(failures: Sequence[Plain]) -> str:
    if not failures:
        return ""
    rows = [
        [f["count"], f["cause"], f["seed"], f["variation"], f["attempt"], "" if f["waypoint"] is None else f["waypoint"]]
        for f in failures
    ]
    return markdown_table(["Count", "Cause", "Seed", "Variation", "Attempt", "Waypoint"], rows)


def _variations(task: Plain) -> str:
    rates, words = task.get("per_variation", {}), task.get("instructions", {})
    rows = [
        [v, interval(entry["first_try"]), share(entry["within_tries"]), (words.get(v) or [""])[0]] for v, entry in rates.items()
    ]
    return markdown_table(["Variation", "First try (95 % interval)", "Within the tries", "Instruction"], rows) if rows else ""


def _segments(task: Plain) -> str:
    head = ["Waypoint", "Reached", "Planning, median", "95 %", "Length, median", "95 %", "Found by"]
    rows = [
        [
            segment["waypoint"],
            share(segment) if "of" in segment else segment["count"],
            f"{segment['planning_median_ms']:.0f} ms",
            f"{segment['planning_p95_ms']:.0f} ms",
            f"{segment['length_median_s']:.2f} s",
            f"{segment['length_p95_s']:.2f} s",
            ", ".join(f"{method} {count}" for method, count in segment["methods"].items()),
        ]
        for segment in task.get("segments", task.get("legs", ()))  # `legs` in older reports
    ]
    return markdown_table(head, rows) if rows else ""


def _reach(task: Plain) -> str:
    rates = task.get("reach", {})
    if not rates:
        return ""
    lost = [f"waypoint {w} {share(rate)}" for w, rate in rates.items() if rate["count"] < rate["of"]]
    kept = f"A reset keeps {share(task['accepted'])} places of the task (waypoints in reach, the arm free)"
    return f"{kept}. Out of reach at some: {', '.join(lost)}." if lost else f"{kept}. Every waypoint is in reach at all places."


def share(rate: Plain | None) -> str:
    """Return `19/20`, or an empty text when there was no trial."""
    return f"{rate['count']}/{rate['of']}" if rate and rate["of"] else ""


def interval(rate: Plain) -> str:
    """Return `95 % (76 to 99)`."""
    low, high = rate["wilson_95"]
    return f"{100 * rate['rate']:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def _millimetres(worst: Plain | None) -> str:
    return "" if worst is None else f"{worst['mm']:.2f} mm"


def markdown_table(head: Sequence[object], rows: Sequence[Sequence[object]]) -> str:
    """Return a table; bars within cells are escaped."""
    lines = ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in (head, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def table(reports: Sequence[TaskReport]) -> str:
    """Return one line per task under a line of headings."""
    rows = [HEADER, *map(_row, reports)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)


def _row(r: TaskReport) -> tuple[str, ...]:
    low, high = r.first_try.interval
    rates = (
        r.within_tries,
        r.same_scene,
        r.unseen,
        r.stable_success,
        r.replay,
        r.key_frames,
        r.friction_only,
        r.noop,
        r.random,
        r.repeat,
        r.accepted,
    )
    return (
        r.task,
        str(len(r.variations)),
        _share(r.first_try),
        f"{low:.0%}..{high:.0%}",
        *map(_share, rates),
        f"{1000 * r.drift.value:.2f} mm",
        f"{1000 * r.penetration.value:.2f} mm",
        f"{r.simulated:.1f} s",
        f"{1000 * r.planning:.0f} ms",
        f"{r.speed.times_real_time:.1f} x",
        "; ".join(r.faults) or "ok",
    )


def _share(rate: Rate) -> str:
    return f"{rate.count}/{rate.of}"
