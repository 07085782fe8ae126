"""Two checkouts in one run: ms of an observation of five cameras at 128 px with all products and default settings.

Usage: python benchmarks/compare_cameras.py OLD [TASK ...]    OLD is the folder of another checkout; the new one is this

Both run in a subprocess and take turns of a few observations each, so that other programs slow both alike. Times are CPU time.
The arm moves a little before each observation, so that no camera sees a scene at rest.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

TASKS = ("reach_target", "stack_blocks", "open_oven", "empty_dishwasher", "setup_checkers", "open_fridge", "open_window")
TURNS, EACH = 40, 4
PLAYER = """
import sys, time
import numpy as np
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.presets import make_environment
with make_environment(ObservationConfig()) as environment:
    task = environment.get_task(sys.argv[1])
    task.reset(seed=0, variation=0)
    home, count = task.world.robot.joint_positions.copy(), 0
    for line in sys.stdin:
        for _ in range(int(line)):
            count += 1
            task.world.robot.reset_configuration(home + 0.1 * np.sin(0.05 * count))
            began = time.process_time()
            task.get_observation()
            print(time.process_time() - began, flush=True)
"""


class Player:
    """One checkout in a process of its own.

    Args:
        checkout: Its folder.
        task: What it shows.
    """

    def __init__(self, checkout: Path, task: str) -> None:
        environment = {**os.environ, "PYTHONPATH": str(checkout), "OMP_NUM_THREADS": "1"}
        self._child = subprocess.Popen(
            [sys.executable, "-c", PLAYER, task],
            cwd=checkout,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.observe(12)

    def observe(self, count: int) -> list[float]:
        """Return the CPU time of some observations [s]."""
        assert self._child.stdin is not None and self._child.stdout is not None
        self._child.stdin.write(f"{count}\n")
        self._child.stdin.flush()
        return [float(self._child.stdout.readline()) for _ in range(count)]

    def close(self) -> None:
        """End the process."""
        assert self._child.stdin is not None
        self._child.stdin.close()
        self._child.wait()


def compared(old: Path, new: Path, task: str) -> tuple[float, float, float]:
    """Return the medians of old and new [s], and the median of their ratios turn by turn."""
    players = [Player(checkout, task) for checkout in (old, new)]
    turns = np.array([[np.median(player.observe(EACH)) for player in players] for _ in range(TURNS)])
    for player in players:
        player.close()
    before, after = np.median(turns, axis=0).tolist()
    return before, after, float(np.median(turns[:, 1] / turns[:, 0]))


def main() -> None:
    """Compare and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path)
    parser.add_argument("tasks", nargs="*", default=TASKS)
    options = parser.parse_args()
    print("| task | old [ms] | new [ms] | new / old |\n|---|---|---|---|")
    for task in options.tasks:
        before, after, ratio = compared(options.old.resolve(), Path(__file__).resolve().parents[1], task)
        print(f"| `{task}` | {1e3 * before:.2f} | {1e3 * after:.2f} | {ratio:.2f} |", flush=True)


if __name__ == "__main__":
    main()
