"""Memory of one worker over hundreds of demonstrations with images of five cameras, and the size of an episode.

    python benchmarks/bench_record_memory.py --out docs/results/record_memory.json

The tasks take turns, a few episodes each, so that a worker loads every task again and again. The first round warms up: meshes
are read, caches fill. From the second on, the median of a round is compared with that of the last, and a line is fitted through
all that was seen. After each demonstration a line of JSON goes beside the result, so that an interrupted run keeps its figures.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import platform
import statistics
import tempfile
import threading
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from rlbench_pin.environment.demos import library_versions
from rlbench_pin.processes import GivenUp, ProcessEngine, WorkerDeath
from rlbench_pin.recording.config import ImageConfig, RecordConfig, WorkItem, plan_items
from rlbench_pin.recording.record import Recorder

TASKS = ("reach_target", "push_button", "beat_the_buzz", "close_microwave", "take_lid_off_saucepan", "slide_block_to_target")


@dataclass(frozen=True)
class Sample:
    """Memory after one demonstration."""

    task: str
    frames: int
    kilobytes: float
    resident: float
    """Memory of the worker [MB]."""
    seconds: float
    """Since the work began, by the clock [s]."""
    processor_seconds: float
    """Processor time of the worker so far [s]."""


@dataclass(frozen=True)
class Memory:
    """Summary of the samples."""

    demos: int
    warm: int
    """Demonstrations before the comparison begins."""
    start: float
    """Median of the first round after the warm-up [MB]."""
    end: float
    """Median of the last round [MB]."""
    growth: float
    """From start to end [%]."""
    slope: float
    """Of a line through all demonstrations after the warm-up [MB per 100 demonstrations]."""
    largest: float
    """Largest after a demonstration [MB]."""
    kilobytes: float
    """Size of an episode file, on average [kB]."""
    kilobytes_a_frame: float
    frames: float
    """Frames of an episode, on average."""


def in_turn(items: Sequence[WorkItem], tasks: Sequence[str], at_once: int) -> list[WorkItem]:
    """Return the work with `at_once` pieces of each task in turn."""
    per_task = [[item for item in items if item.name == task] for task in tasks]
    starts = range(0, len(per_task[0]), at_once)
    return [item for start in starts for of_task in per_task for item in of_task[start : start + at_once]]


def summary(samples: Sequence[Sample], a_round: int) -> Memory:
    """Return the figures of demonstrations of which `a_round` make a round."""
    resident = np.array([s.resident for s in samples])
    warm = resident[a_round:]
    start, end = float(np.median(warm[:a_round])), float(np.median(warm[-a_round:]))
    frames, size = sum(s.frames for s in samples), sum(s.kilobytes for s in samples)
    return Memory(
        demos=len(samples),
        warm=a_round,
        start=round(start, 1),
        end=round(end, 1),
        growth=round(100 * (end / start - 1), 2),
        slope=round(float(np.polyfit(np.arange(len(warm)), warm, 1)[0]) * 100, 2),
        largest=round(float(resident.max()), 1),
        kilobytes=round(size / len(samples), 1),
        kilobytes_a_frame=round(size / frames, 2),
        frames=round(frames / len(samples), 1),
    )


def measure(items: Sequence[WorkItem], images: ImageConfig, log: Path, a_round: int) -> list[Sample]:
    """Let one worker do the work; the size of what it makes is measured, then it is deleted."""
    samples: list[Sample] = []
    began = time.perf_counter()
    events = ProcessEngine(1).map(partial(Recorder, images), items, threading.Event())
    with closing(events), log.open("w", encoding="utf-8") as lines:
        for event in events:
            if isinstance(event, WorkerDeath | GivenUp):
                raise RuntimeError(f"The worker died ({event.cause}), so its memory says nothing.")
            if event.entry is None:
                continue
            resident, processor = _use(multiprocessing.active_children()[0].pid)
            size, seconds = event.entry.num_bytes / 1e3, time.perf_counter() - began
            samples.append(Sample(event.item.name, event.entry.frames, size, resident, round(seconds, 2), processor))
            lines.write(json.dumps(asdict(samples[-1])) + "\n")
            lines.flush()
            if len(samples) % a_round == 0:
                middle = statistics.median(s.resident for s in samples[-a_round:])
                print(
                    f"{len(samples):4d} demonstrations: {middle:.1f} MB, {seconds:.0f} s, of the processor {processor:.0f} s",
                    flush=True,
                )
    return samples


def _use(pid: int | None) -> tuple[float, float]:
    """Resident memory of a process [MB] and the processor time it took [s]."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    ticks = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6, (int(ticks[11]) + int(ticks[12])) / os.sysconf("SC_CLK_TCK")


def main() -> None:
    """Measure, print, save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+", default=list(TASKS))
    parser.add_argument("--episodes", type=int, default=50, help="of each task")
    parser.add_argument("--at-once", type=int, default=5, help="episodes of a task before the next has its turn")
    parser.add_argument("--image-size", type=int, nargs=2, default=(128, 128))
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    load = os.getloadavg()[0]
    config = RecordConfig(tasks=tuple(options.tasks), episodes=options.episodes, seed=1)
    images = replace(config.images, image_size=tuple(options.image_size))
    items = in_turn(plan_items(config), options.tasks, options.at_once)
    a_round = options.at_once * len(options.tasks)
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log" if options.out is None else options.out.with_suffix(".jsonl")
        samples = measure(items, images, log, a_round)
    memory = summary(samples, a_round)
    print(json.dumps(asdict(memory), indent=1))
    print(f"Load of the machine before it began: {load:.1f} on {os.cpu_count()} cores")
    if options.out is not None:
        machine = {"machine": platform.machine(), "cores": os.cpu_count(), "load_before": round(load, 2), "tasks": options.tasks}
        series = [round(s.resident, 1) for s in samples]
        content = {"machine": machine, "versions": library_versions(), "result": asdict(memory), "resident": series}
        options.out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
