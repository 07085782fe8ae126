"""PerAct-18 at scale: episodes a minute of an evaluation with a scripted key-frame policy, and demonstrations a minute.

    python benchmarks/bench_protocol.py --out docs/results/protocol_speed.json

The policy moves the tip to 25 poses above the table, the limit of actions, with four cameras of 128 px: an episode costs at least
as much as that of a policy that succeeds earlier. Its own time is left out. Rates are those between first and last episode,
so the start of the workers is left out. More cores are estimated from one and two workers: each keeps the share of its rate that
each of two keeps.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from bench_record import PRODUCTS, Figures
from bench_record import measure as measure_record

from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.demos import library_versions
from rlbench_pin.evaluation import EvaluationConfig, KeyFrame, KeyFramePolicy, PolicyContext, evaluate, load_protocol
from rlbench_pin.evaluation.run.evaluate import EvaluationProgress
from rlbench_pin.observation import Observation
from rlbench_pin.processes import ProcessEngine
from rlbench_pin.spatial import TABLE_HEIGHT

PERACT18 = Path(__file__).resolve().parents[1] / "rlbench_pin" / "evaluation" / "protocols" / "peract18.toml"
EPISODES = 450
"""Episodes of the whole protocol."""
CORES = (2, 16, 64)
"""Numbers of cores for which the wall time is estimated; Ray does not slow workers down."""


class Tour(KeyFramePolicy):
    """Visits 25 places above the table, with the gripper pointing down and turning."""

    def __init__(self) -> None:
        config = ObservationConfig()
        config.overhead_camera.set_all(False)
        super().__init__(config)

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin with the first place."""
        super().reset(instruction, context)
        self.step = 0

    def predict(self, observation: Observation, instruction: str) -> KeyFrame:
        """Return the next place: five rows of five, 30 to 40 cm above the table."""
        row, column = divmod(self.step % 25, 5)
        half = 0.5 * np.radians(10.0 * (column - 2))
        place = (0.18 + 0.05 * row, 0.09 * (column - 2), TABLE_HEIGHT + 0.3 + 0.05 * ((row + column) % 3))
        self.step += 1
        return KeyFrame(np.array([*place, np.cos(half), np.sin(half), 0.0, 0.0]), is_open=True)


@dataclass(frozen=True)
class Speed:
    """Figures of an evaluation."""

    workers: int
    episodes: int
    a_minute: float
    """Episodes a minute by the clock, time of the policy excluded."""
    policy_seconds: float
    """Time of the policy in an episode, on average [s]."""
    actions: float
    """Actions of an episode, on average."""
    whole_minutes: float
    """Wall time of the whole protocol [min]."""


def measure(episodes: int, workers: int) -> Speed:
    """Evaluate the tour in some episodes of each task of PerAct-18."""
    times: list[float] = []
    policy: list[float] = []

    def note(progress: EvaluationProgress) -> None:
        if progress.latest is not None:
            times.append(time.perf_counter())
            policy.append(sum(progress.latest.action_times))

    with tempfile.TemporaryDirectory() as folder:
        text = PERACT18.read_text(encoding="utf-8").partition("[initial_states]")[0]
        text = re.sub(r"(\[splits\.test\]\nepisodes = )\d+", rf"\g<1>{episodes}", text)
        file = Path(folder) / "peract18.toml"
        file.write_text(text, encoding="utf-8")
        config = EvaluationConfig.of_protocol(f"{Path(__file__).resolve()}:Tour", load_protocol(str(file)))
        results = evaluate(config, Path(folder) / "results.json", engine=ProcessEngine(workers), on_progress=note)
    seconds = times[-1] - times[0] - sum(policy[1:]) / workers
    a_minute = 60.0 * (len(times) - 1) / seconds
    steps = float(np.mean([record.steps for record in results.episodes]))
    return Speed(workers, len(times), round(a_minute, 1), round(float(np.mean(policy)), 3), round(steps, 1), _minutes(a_minute))


def _minutes(a_minute: float) -> float:
    return round(EPISODES / a_minute, 1)


def table(speeds: Sequence[Speed], recordings: Sequence[Figures]) -> str:
    """Return the figures for people."""
    lines = [
        "| Evaluation | Workers | Episodes | A minute | Actions each | Policy s each | 450 episodes, min |",
        "|---|---|---|---|---|---|---|",
    ]
    for s in speeds:
        what = "| four cameras of 128 px"
        lines.append(
            f"{what} | {s.workers} | {s.episodes} | {s.a_minute} | {s.actions} | {s.policy_seconds} | {s.whole_minutes} |"
        )
    lines += ["", "| Demonstrations | Workers | Episodes | A minute | Processor s each |", "|---|---|---|---|---|"]
    lines += [f"| {f.what} | {f.workers} | {f.episodes} | {f.a_minute} | {f.processor_seconds} |" for f in recordings]
    one, two = (next(s.a_minute for s in speeds if s.workers == n) for n in (1, 2))
    kept = two / (2.0 * one)
    lines += ["", f"With two workers each keeps {100 * kept:.0f} % of its rate. Estimated from that, policy time excluded:", ""]
    lines += ["| Cores, on one machine or several with Ray | 450 episodes, min |", "|---|---|"]
    lines += [f"| {cores} | {_minutes(cores * kept * one)} |" for cores in CORES]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure, print, save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=2, help="of each task")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    load = os.getloadavg()[0]
    speeds = [measure(options.episodes, workers) for workers in (1, 2)]
    tasks = load_protocol("peract18").task_names
    recordings = [measure_record(tasks, options.episodes, products, workers) for products in PRODUCTS for workers in (1, 2)]
    text = table(speeds, recordings)
    print(text)
    print(f"Load of the machine before it began: {load:.1f} on {os.cpu_count()} cores")
    if options.out is not None:
        about = {
            "machine": platform.machine(),
            "cores": os.cpu_count(),
            "load_before": round(load, 2),
            "versions": library_versions(),
        }
        results = {"evaluations": [asdict(s) for s in speeds], "recordings": [asdict(f) for f in recordings]}
        options.out.write_text(json.dumps(about | results, indent=1) + "\n", encoding="utf-8")
        options.out.with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
