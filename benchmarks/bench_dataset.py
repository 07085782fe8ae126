"""Random frames from a dataset of 20 episodes with five cameras, beside h5py alone, which checks nothing.

    python benchmarks/bench_dataset.py --out docs/results/dataset.json

Each line is the time of one frame; `frames_per_second` and `ratio`, the share of the rate of h5py alone, are in the JSON. `open`
opens a file for every frame, `stays open` keeps all files open, as training does. The dataset is recorded once and kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import h5py
import numpy as np
from harness import Result, main, measure, summary

from rlbench_pin.datasets import Episode, FrameDataset, read_manifest
from rlbench_pin.observation import CAMERAS
from rlbench_pin.recording import ProcessEngine, RecordConfig, record

ROOT = Path(__file__).resolve().parents[1] / "out" / "benchmarks" / "dataset"
TASK = "reach_target"
IMAGES = tuple(f"{camera}_rgb" for camera in CAMERAS)

Read = Callable[[int], object]


def benchmark(episodes: int = 20, repeats: int = 1000) -> list[Result]:
    """Read the same random frames in pairs of ways."""
    root = ROOT.with_name(f"dataset_{episodes}")
    record(RecordConfig(tasks=(TASK,), episodes=episodes), root, engine=ProcessEngine(2), resume=True)
    entries = read_manifest(root, TASK)
    rng = np.random.default_rng(0)
    places = [(int(k), int(rng.integers(entries[k].frames - 1))) for k in rng.integers(len(entries), size=repeats)]
    files = [root / TASK / entry.file for entry in entries]
    starts = np.cumsum([0, *(entry.frames - 1 for entry in entries)])

    def plain_open(fields: Sequence[str]) -> Read:
        def read(i: int) -> object:
            place, frame = places[i]
            with h5py.File(files[place], "r") as file:
                return _plain(file, fields, frame)

        return read

    def checked_open(fields: Sequence[str]) -> Read:
        def read(i: int) -> object:
            place, frame = places[i]
            with Episode(files[place], entries[place].sha256) as episode:
                return [episode.series(name, range(frame, frame + 1)) for name in fields]

        return read

    opened = [h5py.File(file, "r") for file in files]

    def plain(fields: Sequence[str]) -> Read:
        return lambda i: _plain(opened[places[i][0]], fields, places[i][1])

    def checked(fields: Sequence[str]) -> Read:
        dataset = FrameDataset(root, fields=fields)
        return lambda i: dataset[int(starts[places[i][0]]) + places[i][1]]

    pairs: list[tuple[str, Read, Read]] = [
        ("open, one camera", plain_open(IMAGES[:1]), checked_open(IMAGES[:1])),
        ("open, five cameras", plain_open(IMAGES), checked_open(IMAGES)),
        ("stays open, one camera", plain(IMAGES[:1]), checked(IMAGES[:1])),
        ("stays open, five cameras", plain(IMAGES), checked(IMAGES)),
    ]
    results = []
    for what, alone, ours in pairs:
        results += _compared(what, alone, ours, repeats)
    for file in opened:
        file.close()
    return results


def _plain(file: h5py.File, fields: Sequence[str], frame: int) -> list[np.ndarray]:
    """Read fields of a frame; what is stored once for all frames has one row."""
    stored = [file["observations"][name] for name in fields]
    return [dataset[min(frame, len(dataset) - 1)] for dataset in stored]


def _compared(what: str, alone: Read, ours: Read, repeats: int) -> list[Result]:
    """Measure both twice, in turn, and keep the second round: files are in the system's cache, checksums are known."""
    for _ in range(2):
        seconds, plain_seconds = measure(ours, repeats), measure(alone, repeats)
    rate, plain_rate = (repeats / sum(times) for times in (seconds, plain_seconds))
    note = f"{rate:.0f} frames/s, {rate / plain_rate:.2f} of h5py alone"
    return [
        summary(f"random frame, {what}", seconds, note, frames_per_second=rate, ratio=rate / plain_rate),
        summary(f"h5py alone, {what}", plain_seconds, f"{plain_rate:.0f} frames/s", frames_per_second=plain_rate),
    ]


if __name__ == "__main__":
    main(__doc__ or "", benchmark)
