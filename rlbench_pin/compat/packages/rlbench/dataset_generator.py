"""Records demonstrations as folders in the layout of RLBench.

Example: `python -m rlbench.dataset_generator --tasks reach_target --save_path data`.

It uses the recorder of this package: `--resume` continues after an interruption, and the same `--seed` gives the same
demonstrations with any number of processes.
"""

from __future__ import annotations

import argparse
import logging
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rlbench.backend.const import VARIATION_NUMBER, VARIATIONS_ALL_FOLDER
from rlbench_pin.datasets.formats.rlbench import Layout, export_rlbench, write_frames
from rlbench_pin.datasets.formats.rlbench_pickle import dump
from rlbench_pin.errors import DatasetConflict, RlbenchPinError, nearest_name
from rlbench_pin.observation import Demo
from rlbench_pin.processes import ProcessEngine, SerialEngine
from rlbench_pin.recording.config import ImageConfig, RecordConfig
from rlbench_pin.recording.record import RECORDING, RecordReport, read_recording, record
from rlbench_pin.tasks import task_names

_LOG = logging.getLogger(__name__)
_RECORDING, _EXPORT = ".recording", ".export"
"""Folders of unfinished data in the save path."""


class UnknownTasks(RlbenchPinError, ValueError):
    """Names that are not tasks of our library."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        guesses = {name: nearest_name(name, task_names()) for name in names}
        near = "".join(f" Did you mean '{guess}' for '{name}'?" for name, guess in guesses.items() if guess)
        super().__init__(f"The library has no tasks {list(names)}.{near} `rlbench-pin list` prints all {len(task_names())}.")


def check_and_make(dir: str | Path) -> None:
    """Create a folder, unless it exists."""
    Path(dir).mkdir(parents=True, exist_ok=True)


def save_demo(demo: Demo, example_path: str | Path, variation: int | None = None) -> None:
    """Write one demonstration into a folder: images as PNG files, the rest as `low_dim_obs.pkl`.

    Args:
        demo: The demonstration; it does not change.
        example_path: The folder; it is created if it does not exist.
        variation: Number of the variation, for the layout with all variations in one folder.
    """
    check_and_make(example_path)
    write_frames(Path(example_path), demo)
    if variation is not None:
        (Path(example_path) / VARIATION_NUMBER).write_bytes(dump(int(variation)))


def parse_args(args: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the settings of a command line; the parts of lists are separated by spaces or commas."""
    parser = argparse.ArgumentParser("rlbench-generate-dataset", description="Write demonstrations as RLBench-style folders.")
    parser.add_argument("--save_path", default=str(Path(tempfile.gettempdir()) / "rlbench_data"), help="root of the data set")
    parser.add_argument("--tasks", nargs="*", default=[], help="names of tasks; all of the library when none is named")
    parser.add_argument("--image_size", nargs="+", default=["128", "128"], help="width and height of the images [px]")
    parser.add_argument(
        "--renderer", type=str.lower, choices=("opengl3", "opengl"), default="opengl3", help="with or without shadows"
    )
    parser.add_argument("--processes", type=int, default=1, help="worker processes")
    parser.add_argument("--episodes_per_task", type=int, default=10, help="of each variation; with --all_variations of each task")
    parser.add_argument("--variations", type=int, default=-1, help="so many variations of a task, the first; -1 is all")
    parser.add_argument("--arm_max_velocity", type=float, default=1.0, help="cap on joint speeds [rad/s]")
    parser.add_argument("--arm_max_acceleration", type=float, default=4.0, help="cap on joint accelerations [rad/s^2]")
    parser.add_argument(
        "--all_variations", nargs="?", type=_truth, const=True, default=False, help="all variations in one folder"
    )
    parser.add_argument("--noall_variations", dest="all_variations", action="store_false", help="a folder for each variation")
    parser.add_argument("--seed", type=int, default=None, help="seed of the data set; drawn when not given")
    parser.add_argument("--resume", action="store_true", help="continue the recording in the save path")
    found = parser.parse_args(args)
    found.tasks = [name for part in found.tasks for name in part.split(",") if name]
    sides = [int(side) for part in found.image_size for side in part.split(",") if side]
    if len(sides) != 2 or min(sides) < 1:
        parser.error(f"--image_size takes a width and a height of at least 1 px, not {' '.join(found.image_size)}")
    found.image_size = sides
    return found


def _truth(text: str) -> bool:
    """Convert the text of an argument to a bool, or raise ArgumentTypeError."""
    words = {"true": True, "1": True, "yes": True, "false": False, "0": False, "no": False}
    if text.lower() not in words:
        raise argparse.ArgumentTypeError(f"true or false, not {text!r}")
    return words[text.lower()]


def run(args: argparse.Namespace) -> RecordReport:
    """Record the demonstrations of `args`, a result of `parse_args`, and write them as folders in `args.save_path`.

    Raises:
        UnknownTasks: A task is not in the library (also a ValueError).
        DatasetConflict: The save path already contains episodes of these tasks, or an unfinished recording.
    """
    tasks = [name.removesuffix(".py") for name in args.tasks] or list(task_names())
    unknown = [name for name in tasks if name not in task_names()]
    if unknown:
        raise UnknownTasks(unknown)
    root = Path(args.save_path)
    _check_free(root, tasks, args.all_variations, args.resume)
    check_and_make(root)
    config = RecordConfig(
        tasks=tuple(tasks),
        episodes=args.episodes_per_task,
        per_variation=not args.all_variations,
        variations=args.variations,
        draw_variations=False,
        seed=_seed(root, args),
        max_velocity=args.arm_max_velocity,
        max_acceleration=args.arm_max_acceleration,
        images=ImageConfig(image_size=(args.image_size[0], args.image_size[1]), render_mode=args.renderer),
    )
    engine = SerialEngine() if args.processes <= 1 else ProcessEngine(args.processes)
    report = record(config, root / _RECORDING, engine=engine, resume=args.resume, on_progress=_say)
    _publish(root, "peract" if args.all_variations else "upstream", keep=report.missing > 0)
    return report


def _seed(root: Path, args: argparse.Namespace) -> int:
    """Return the given seed; without one, the seed of the recording to continue, or a new seed."""
    if args.seed is not None:
        return int(args.seed)
    begun = root / _RECORDING
    return read_recording(begun).seed if (begun / RECORDING).exists() else int(np.random.SeedSequence().generate_state(1)[0] >> 1)


def _say(report: RecordReport) -> None:
    """Log the progress."""
    done = report.found + report.recorded
    _LOG.info("%d of %d episodes, %d failed", done, report.wanted, len(report.failed))


def _check_free(root: Path, tasks: Sequence[str], together: bool, resume: bool) -> None:
    """Raise DatasetConflict if the save path contains episodes of these tasks, or an unfinished recording without `resume`."""
    begun = (root / _RECORDING / RECORDING).exists()
    if begun and not resume:
        raise DatasetConflict(f"'{root}' contains an unfinished recording. Use `--resume`, or choose another folder.")
    pattern = VARIATIONS_ALL_FOLDER if together else "variation[0-9]*"
    stored = [name for name in tasks if list((root / name).glob(pattern))]
    if stored and not begun:
        raise DatasetConflict(f"'{root}' already contains episodes of {stored}. Choose another folder.")


def _publish(root: Path, layout: Layout, keep: bool) -> None:
    """Convert the recording to folders, each atomically; `keep` the recording if episodes are missing."""
    shutil.rmtree(root / _EXPORT, ignore_errors=True)
    folders = export_rlbench(root / _RECORDING, root / _EXPORT, layout=layout)
    for variation in sorted(folders.glob("*/*")):
        target = root / variation.relative_to(folders)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(target, ignore_errors=True)
        os.replace(variation, target)
    shutil.rmtree(folders)
    if not keep:
        shutil.rmtree(root / _RECORDING)


def main(args: Sequence[str] | None = None) -> int:
    """Run the command and return the exit code: 1 if episodes are missing at the end, otherwise 0."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    settings = parse_args(args)
    report = run(settings)
    for result in report.failed:
        _LOG.info("%s, variation %d: %s", result.item.name, result.item.variation, "; ".join(result.failures))
    _LOG.info("Data saved to %s", settings.save_path)
    return 1 if report.missing else 0


if __name__ == "__main__":
    sys.exit(main())
