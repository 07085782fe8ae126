"""Write the hashes of the initial states of a protocol's test episodes into its file: `write_protocol_states.py peract18`.

With `--check` nothing is written; it only reports the tasks whose hash in the file differs. `--tasks` limits the tasks.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.environment import Environment, low_dim_config, make_environment
from rlbench_pin.evaluation import EpisodeItem, EvaluationConfig, load_protocol, plan_episodes

FOLDER = Path(__file__).resolve().parents[1] / "rlbench_pin" / "evaluation" / "protocols"
TABLE = "\n[initial_states]"


def digest(environment: Environment, items: Sequence[EpisodeItem]) -> str:
    """Return the SHA-256 of the initial states of the episodes of one task.

    A state is variation, seed, instructions, joint positions [rad], and poses and joints of all bodies [m, rad], to 1e-6.
    """
    found, task = hashlib.sha256(), environment.get_task(items[0].name)
    for item in items:
        instructions, seen = task.reset(seed=item.seed, variation=item.variation)
        numbers = np.concatenate([seen.joint_positions, seen.task_low_dim_state])
        rounded = [f"{number:.6f}".replace("-0.000000", "0.000000") for number in numbers]
        found.update(json.dumps([item.variation, item.seed, instructions, rounded]).encode())
    return found.hexdigest()


def digests(name: str, tasks: Sequence[str] = ()) -> dict[str, str]:
    """Return task -> hash of its test episodes in a protocol; of all its tasks when none is named."""
    items = plan_episodes(EvaluationConfig.of_protocol("noop", load_protocol(name)))
    found = {}
    with make_environment(low_dim_config()) as environment:
        for task in dict.fromkeys(item.name for item in items):
            if not tasks or task in tasks:
                began = time.perf_counter()
                found[task] = digest(environment, [item for item in items if item.name == task])
                print(f"{task}: {found[task][:12]} ({time.perf_counter() - began:.1f} s)", file=sys.stderr, flush=True)
    return found


def main() -> int:
    """Write or check the hashes; 1 when one differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", help="name of a published protocol")
    parser.add_argument("--tasks", nargs="*", default=(), help="only these tasks")
    parser.add_argument("--check", action="store_true", help="write nothing")
    arguments = parser.parse_args()
    before, found = load_protocol(arguments.name).initial_states, digests(arguments.name, arguments.tasks)
    changed = [task for task, value in found.items() if before.get(task) != value]
    print(f"{len(found)} tasks, other than in the file: {', '.join(changed) or 'none'}")
    if arguments.check:
        return 1 if changed else 0
    path = FOLDER / f"{arguments.name}.toml"
    head = path.read_text(encoding="utf-8").split(TABLE)[0].rstrip("\n")
    lines = [f'{task} = "{value}"' for task, value in {**before, **found}.items()]
    write_whole(path, "\n".join([head, TABLE, *lines, ""]).encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
