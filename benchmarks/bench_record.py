"""Recording at scale: demonstrations a minute with and without images, by one worker and by two, their size, a worker's memory.

    python benchmarks/bench_record.py --out docs/results/record.json
    python benchmarks/bench_record.py --every-task --out docs/results/record_tasks.json

The second measures the first variation of every task with five cameras by processor time in one process: episodes that one core
makes in a minute, and kilobytes a frame, in the mean over the tasks. It goes on where it was stopped, as long
as the sources are the same. The first compares workers: rates are those between the first and the last episode, so the start of
the workers is left out; a figure by processor time (which other programs on the machine do not change) stands beside those by the
clock. Both write a table beside the JSON.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import platform
import resource
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from harness import fingerprint

from rlbench_pin.environment.demos import library_versions
from rlbench_pin.processes import ProcessEngine
from rlbench_pin.recording.config import ImageConfig, RecordConfig, WorkItem
from rlbench_pin.recording.record import Recorder, RecordReport, record
from rlbench_pin.tasks import task_names

TASKS = ("reach_target", "pick_and_lift", "push_button", "open_drawer", "put_rubbish_in_bin")
PRODUCTS: tuple[tuple[str, ...], ...] = ((), ("rgb", "depth", "mask"))


@dataclass(frozen=True)
class Figures:
    """The figures of one recording."""

    what: str
    workers: int
    episodes: int
    a_minute: float
    """Episodes a minute, by the clock."""
    processor_seconds: float
    """Processor time of the workers for each episode, their start included [s]."""
    frames: float
    """Frames of an episode, on average."""
    kilobytes: float
    """Size of an episode file, on average [kB]."""
    kilobytes_a_frame: float
    failed_tries: int
    memory_early: float
    """Resident memory of a worker after a tenth of the episodes [MB]."""
    memory_late: float
    """The same at the end [MB]."""


class Stopwatch:
    """Notes when episodes come in, and what the workers hold of the memory then."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.memory: list[float] = []

    def __call__(self, report: RecordReport) -> None:
        """Note one."""
        if report.recorded > len(self.times):
            self.times.append(time.perf_counter())
            self.memory.append(max((_resident(p.pid) for p in multiprocessing.active_children()), default=0.0))

    @property
    def a_minute(self) -> float:
        """Episodes a minute between the first and the last."""
        return 60.0 * (len(self.times) - 1) / (self.times[-1] - self.times[0])


def measure(tasks: Sequence[str], episodes: int, products: tuple[str, ...], workers: int) -> Figures:
    """Record into a temporary folder."""
    config = RecordConfig(tasks=tuple(tasks), episodes=episodes, seed=1, images=ImageConfig(products=products))
    watch, before = Stopwatch(), _children()
    with tempfile.TemporaryDirectory() as folder:
        report = record(config, folder, engine=ProcessEngine(workers), on_progress=watch)
    early = watch.memory[max(len(watch.memory) // 10, 2)]
    return Figures(
        what="5 cameras of 128 px: rgb, depth, mask" if products else "no images",
        workers=workers,
        episodes=report.recorded,
        a_minute=round(watch.a_minute, 1),
        processor_seconds=round((_children() - before) / report.recorded, 3),
        frames=round(report.frames / report.recorded, 1),
        kilobytes=round(report.num_bytes / report.recorded / 1e3, 1),
        kilobytes_a_frame=round(report.num_bytes / report.frames / 1e3, 2),
        failed_tries=sum(report.causes.values()),
        memory_early=round(early, 1),
        memory_late=round(watch.memory[-1], 1),
    )


def table(figures: Sequence[Figures]) -> str:
    """Return the figures for people."""
    each = "Processor s per episode | Frames per episode | kB per episode | kB per frame"
    head = f"| Contents | Workers | Episodes | Episodes per minute | {each} | Worker MB |"
    lines = [head, "|---|---|---|---|---|---|---|---|---|"]
    lines += [
        f"| {f.what} | {f.workers} | {f.episodes} | {f.a_minute} | {f.processor_seconds} | {f.frames} | {f.kilobytes} "
        f"| {f.kilobytes_a_frame} | {f.memory_early} to {f.memory_late} |"
        for f in figures
    ]
    return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class TaskFigures:
    """Cost of the episodes of one task, with five cameras of 128 px, rgb, depth and mask, and shadows."""

    task: str
    episodes: int
    seconds: float
    """Processor time of an episode, on average; the first, which also loads the task, does not count [s]."""
    frames: float
    """Frames of an episode, on average."""
    kilobytes_a_frame: float


def measure_task(task: str, episodes: int) -> TaskFigures:
    """Record some episodes of the first variation of one task, after one that does not count."""
    recorder = Recorder(ImageConfig(products=PRODUCTS[1]))
    seconds = frames = size = 0.0
    for index in range(episodes + 1):
        began = time.process_time()
        item = WorkItem(task=task, name=task, variation=0, index=index, seed=1000 + index, attempts=tuple(range(10)))
        result = recorder.make(item)
        if result.data is None or result.entry is None:
            raise SystemExit(f"No episode of {task} with seed {item.seed}: {'; '.join(result.failures)}")
        if index:
            seconds += time.process_time() - began
            frames, size = frames + result.entry.frames, size + len(result.data)
    recorder.close()
    return TaskFigures(task, episodes, round(seconds / episodes, 3), frames / episodes, round(size / frames / 1e3, 2))


def measure_tasks(tasks: Sequence[str], episodes: int, kept: Path | None) -> list[TaskFigures]:
    """Measure tasks; those that the file `kept` has of the same sources are taken from it, and each is added to it at once."""
    results: list[TaskFigures] = []
    sources = fingerprint()
    if kept is not None and kept.exists():
        content = json.loads(kept.read_text(encoding="utf-8"))
        results = [TaskFigures(**figures) for figures in content["results"] if content.get("sources") == sources]
    done = {figures.task for figures in results if figures.episodes == episodes}
    results = [figures for figures in results if figures.task in done]
    for number, task in enumerate(tasks, start=1):
        if task in done:
            continue
        results.append(measure_task(task, episodes))
        print(f"{number}/{len(tasks)} {results[-1]}", flush=True)
        if kept is not None:
            kept.parent.mkdir(parents=True, exist_ok=True)
            about = {"machine": _machine(), "versions": library_versions(), "sources": sources}
            content = about | {"results": [asdict(f) for f in results]}
            kept.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return [figures for figures in results if figures.task in tasks]


def table_of_tasks(figures: Sequence[TaskFigures]) -> str:
    """Return the figures for people, the mean over the tasks last."""
    lines = [
        "| Task | Processor s per episode | Episodes per minute and core | Frames | ms per frame | kB per frame |",
        "|---|---|---|---|---|---|",
    ]
    rows = [(f.task, f.seconds, f.frames, 1e3 * f.seconds / f.frames, f.kilobytes_a_frame) for f in figures]
    means = [sum(column) / len(rows) for column in zip(*(row[1:] for row in rows))]
    rows.append(("mean", means[0], means[1], means[2], means[3]))
    lines += [f"| {n} | {s:.2f} | {60.0 / s:.1f} | {frames:.0f} | {ms:.1f} | {kb:.1f} |" for n, s, frames, ms, kb in rows]
    return "\n".join(lines) + "\n"


def _machine() -> dict[str, object]:
    return {"machine": platform.machine(), "cores": os.cpu_count(), "load": round(os.getloadavg()[0], 2)}


def _children() -> float:
    """Processor time of all processes that were started here and have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _resident(pid: int | None) -> float:
    """Resident memory of a process [MB]."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    """Measure, print, save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+")
    parser.add_argument(
        "--every-task", action="store_true", help="processor time of every task, or of those named, in one process"
    )
    parser.add_argument("--episodes", type=int, nargs="+", default=[20, 6], help="of each task, without and with images")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    if options.every_task:
        episodes = options.episodes[0] if len(options.episodes) == 1 else 2
        text = table_of_tasks(measure_tasks(options.tasks or task_names(), episodes, options.out))
        print(text)
        if options.out is not None:
            options.out.with_suffix(".md").write_text(text, encoding="utf-8")
        return
    tasks = options.tasks or list(TASKS)
    load = os.getloadavg()[0]
    figures = [
        measure(tasks, episodes, products, workers)
        for episodes, products in zip(options.episodes, PRODUCTS, strict=True)
        for workers in options.workers
    ]
    text = table(figures)
    print(text)
    print(f"Load of the machine before it began: {load:.1f} on {os.cpu_count()} cores")
    if options.out is not None:
        machine = {"machine": platform.machine(), "cores": os.cpu_count(), "load_before": round(load, 2), "tasks": tasks}
        content = {"machine": machine, "versions": library_versions(), "results": [asdict(f) for f in figures]}
        options.out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        options.out.with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
