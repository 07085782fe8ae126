"""Common parts of all benchmarks: warm up, repeat, median and tails, JSON, comparison of two runs."""

from __future__ import annotations

import argparse
import hashlib
import json
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from rlbench_pin.environment import Discrete, Environment, JointVelocity, MoveArmThenGripper, ObservationConfig
from rlbench_pin.environment.demos import library_versions

ROOT = Path(__file__).resolve().parents[1]
SOURCES = (("rlbench_pin", "*.py"), ("rlbench_pin", "*.toml"), ("benchmarks", "*.py"), (".", "constraints.txt"))


@dataclass(frozen=True)
class Result:
    """Processor time of one operation [s], so that other work on the machine counts little."""

    name: str
    repeats: int
    median: float
    p95: float
    p99: float
    note: str = ""
    extra: dict[str, float] = field(default_factory=dict)
    """Further figures that belong to it."""

    def line(self) -> str:
        """One line for people, in [ms]."""
        return f"{self.name:<44} {1e3 * self.median:10.3f} {1e3 * self.p95:10.3f} {1e3 * self.p99:10.3f}  {self.note}"


HEADER = f"{'benchmark':<44} {'median ms':>10} {'p95 ms':>10} {'p99 ms':>10}"


def summary(name: str, seconds: Sequence[float], note: str = "", **extra: float) -> Result:
    """Sum up measured durations [s]."""
    median, p95, p99 = (float(np.percentile(seconds, p)) for p in (50, 95, 99))
    return Result(name, len(seconds), median, p95, p99, note, extra)


def measure(operation: Callable[[int], object], repeats: int, warm_up: int = 3) -> list[float]:
    """Return the processor time of `operation(i)` for each i in 0..repeats-1, after some calls that do not count [s]."""
    for i in range(warm_up):
        operation(i)
    durations = []
    for i in range(repeats):
        began = time.process_time()
        operation(i)
        durations.append(time.process_time() - began)
    return durations


def fingerprint() -> str:
    """Return a digest of everything that a figure depends on, the machine apart."""
    digest = hashlib.sha256()
    for folder, pattern in SOURCES:
        for file in sorted((ROOT / folder).rglob(pattern) if folder != "." else (ROOT / folder).glob(pattern)):
            digest.update(f"{file.relative_to(ROOT)}\0".encode() + file.read_bytes())
    return digest.hexdigest()


def state_only() -> ObservationConfig:
    """Joint and gripper data, no images."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    return config


def velocity_environment() -> Environment:
    """An environment in joint velocity control without images, as reinforcement learning uses it."""
    return Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=state_only(), seed=0)


def report(results: Sequence[Result], out: Path | None = None, against: Path | None = None) -> None:
    """Print results, save them, and set them beside an earlier run."""
    earlier = {} if against is None else {r["name"]: r["median"] for r in json.loads(against.read_text())["results"]}
    print(HEADER)
    for result in results:
        ratio = f"  {result.median / earlier[result.name]:.2f} x the earlier" if result.name in earlier else ""
        print(result.line() + ratio)
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        machine = {"machine": platform.machine(), "python": platform.python_version(), "system": platform.system()}
        content = {"machine": machine, "versions": library_versions(), "results": [asdict(r) for r in results]}
        out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def main(description: str, benchmark: Callable[[], Sequence[Result]]) -> None:
    """Command line of a single benchmark."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--out", type=Path, help="JSON file to write")
    parser.add_argument("--against", type=Path, help="JSON file of an earlier run to compare with")
    arguments = parser.parse_args()
    report(benchmark(), arguments.out, arguments.against)
