"""Count the files of the package that one step, one waypoint of a demonstration and one evaluated action use.

These are the paths of docs/architecture.md. A file is counted if one of its functions is called in this process:

* step: from the call of `TaskEnvironment.step` to its return;
* waypoint: from the start of one segment of a demonstration to the start of the next;
* evaluated action: from the return of one step to the return of the next, so without the process of the policy.

Usage: python scripts/count_path_files.py [--list]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType

import numpy as np

import rlbench_pin
from rlbench_pin.environment import Listener, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.evaluation import EpisodeRunner, EvaluationConfig
from rlbench_pin.evaluation.run.config import plan_episodes
from rlbench_pin.planning import Plan
from rlbench_pin.tasks import Waypoint

PACKAGE = Path(rlbench_pin.__file__).parent
Moment = tuple[str, CodeType]
"""`call` or `return` of a function."""


class Segments(Listener):
    """Its method marks the starts of segments."""

    def on_segment(self, waypoint: Waypoint, plan: Plan) -> None:
        """The motion to a waypoint begins."""


def files_between(run: Callable[[], object], start: Moment, end: Moment) -> list[str]:
    """Run a function and return the files of the package whose functions are called between two moments, first occurrences."""
    found: set[str] = set()
    state = "before"

    def profile(frame: FrameType, event: str, argument: object) -> None:
        nonlocal state
        moment = (event, frame.f_code)
        if state == "during":
            if event == "call":
                found.add(frame.f_code.co_filename)
            if moment == end:
                state = "after"
        elif state == "before" and moment == start:
            state = "during"
            found.add(frame.f_code.co_filename)

    sys.setprofile(profile)
    try:
        run()
    finally:
        sys.setprofile(None)
    inside = (Path(name) for name in found if name.startswith(str(PACKAGE)))
    return sorted(str(path.relative_to(PACKAGE)) for path in inside)


def main() -> None:
    """Print how many files each path passes through, and which with `--list`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="print the files")
    listed = parser.parse_args().list
    step = TaskEnvironment.step.__code__
    paths: dict[str, list[str]] = {}
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("open_drawer")
        _, observation = task.reset(seed=0)
        action = np.append(observation.joint_positions, 1.0)
        task.step(action)
        paths["step"] = files_between(lambda: task.step(action), ("call", step), ("return", step))
        segments = Segments()
        with task.runtime.listening(segments):
            started = ("call", Segments.on_segment.__code__)
            paths["waypoint"] = files_between(lambda: task.try_demo(seed=0), started, started)
    config = EvaluationConfig(policy="random", tasks=("reach_target",), episodes=1, max_steps=3)
    with EpisodeRunner(config) as runner:
        item = plan_episodes(config)[0]
        paths["evaluated action"] = files_between(lambda: runner.play(item), ("return", step), ("return", step))
    for name, files in paths.items():
        more = len(set(files) - set(paths["step"]))
        print(f"{name}: {len(files)} files" + ("" if name == "step" else f", {more} of them not on the path of a step"))
        for file in files if listed else ():
            print(f"    {file}")


if __name__ == "__main__":
    main()
