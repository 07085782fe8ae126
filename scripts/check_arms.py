"""Check every arm of the catalogue as `rlbench-pin arm check` does, time its resets, and write docs/results/arm_checks.md.

Usage: python scripts/check_arms.py [--actions 50000] [--resets 5] [--out docs/results/arm_checks.md]
This takes about half an hour on one core; times are processor times.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from rlbench_pin.checking.arms import CHECKS, check_arm
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import ResetError
from rlbench_pin.robot import DEFAULT_ROBOT, SUPPORTED_ROBOTS
from rlbench_pin.tasks import library_names

ROOT = Path(__file__).resolve().parents[1]


def reset_times(robot: str, resets: int) -> dict[str, float]:
    """Return task -> median time of a reset [s]; tasks that the arm cannot start are left out."""
    found = {}
    with make_environment(low_dim_config(), robot=robot) as environment:
        for name in tqdm(library_names(), desc=f"resets of {robot}", unit="task"):
            task, times = environment.get_task(name), []
            for seed in range(resets + 1):
                began = time.process_time()
                try:
                    task.reset(seed=seed)
                except ResetError:
                    continue
                times.append(time.process_time() - began)
            if len(times) > 1:
                found[name] = statistics.median(times[1:])  # the first builds the world
    return found


def reset_row(times: Sequence[float], of_panda: Sequence[float]) -> str:
    """Return the cell of one arm: the median time, and the ratio to the Panda over all tasks."""
    ratio = statistics.median(a / b for a, b in zip(times, of_panda, strict=True))
    return f"{1e3 * statistics.median(times):.1f} ms, {ratio:.2f} x the Panda"


def main() -> None:
    """Check all arms and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--actions", type=int, default=50_000, help="random actions of each arm through the safety filter")
    parser.add_argument("--resets", type=int, default=5, help="number of resets of each task and arm")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "results" / "arm_checks.md", help="page to write")
    options = parser.parse_args()
    arms = list(SUPPORTED_ROBOTS)
    rows: dict[str, list[str]] = {name: [] for name, _, _ in CHECKS}
    for arm in arms:
        checks = tqdm(check_arm(SUPPORTED_ROBOTS[arm], options.actions), desc=f"checks of {arm}", total=len(CHECKS))
        for check in checks:
            rows[check.name].append(check.figure if check.passed is not False else f"**fails:** {check.figure}")
    times = {arm: reset_times(arm, options.resets) for arm in arms}
    rows["reset"] = []
    for arm in arms:
        tasks = [task for task in times[DEFAULT_ROBOT] if task in times[arm]]
        rows["reset"].append(reset_row([times[arm][t] for t in tasks], [times[DEFAULT_ROBOT][t] for t in tasks]))
    lines = [
        "# Checks of the arms",
        "",
        "Written by `python scripts/check_arms.py`. Each line is a check of `rlbench-pin arm check`. Last, the time of a reset",
        f"with its check of reach: the median over all tasks, {options.resets} resets of each, without images.",
        "",
        f"| Check | {' | '.join(arms)} |",
        f"|---|{'---|' * len(arms)}",
        *(f"| {name} | {' | '.join(cells)} |" for name, cells in rows.items()),
    ]
    options.out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
