"""Record, verify, read and export demonstrations, all through the Python API.

    python scripts/export_demos.py --out out/export --tasks reach_target pick_and_lift --episodes 4 --workers 2

It records (or resumes), verifies, reads one episode lazily, and writes the same data as a LeRobotDataset (if pyarrow is
installed), a robomimic file per task, and RLBench-style folders. A second run uses the recorded episodes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from rlbench_pin.datasets import Episode, read_manifest, stored_tasks, task_faults
from rlbench_pin.datasets.formats import ExportFormat, export_dataset
from rlbench_pin.errors import MissingExtra
from rlbench_pin.processes import ProcessEngine
from rlbench_pin.recording.config import ImageConfig, RecordConfig
from rlbench_pin.recording.record import RecordReport, record


def main() -> None:
    """Record, check, read, export."""
    options = _options()
    root = options.out / "dataset"
    images = ImageConfig(cameras=("front", "wrist"), products=("rgb", "depth"), image_size=(options.image_size,) * 2)
    config = RecordConfig(tasks=tuple(options.tasks), episodes=options.episodes, seed=options.seed, images=images)
    report = record(config, root, engine=ProcessEngine(options.workers), resume=True, on_progress=_show_progress)
    print(f"{report.recorded} recorded now, {report.found} found, {report.missing} missing")

    for task in stored_tasks(root):
        faults = task_faults(root, task)
        entry = read_manifest(root, task)[0]
        with Episode(root / task / entry.file, entry.sha256) as episode:
            middle = episode[len(episode) // 2]
        print(f"{task}: {len(faults)} faults; {episode.path.name} shows {entry.instructions[0]!r} in {entry.frames} frames,")
        print(
            f"    in the middle the tip is at {middle.gripper_pose[:3].round(3)} m, the front image is {middle.front_rgb.shape}"
        )

    for task in stored_tasks(root):
        _export("robomimic", root, options.out / f"{task}.hdf5", (task,))
    _export("rlbench", root, options.out / "rlbench")
    _export("lerobot", root, options.out / "lerobot")


def _export(name: ExportFormat, root: Path, out: Path, tasks: tuple[str, ...] = ()) -> None:
    if out.exists():
        print(f"{out} already exists")
        return
    try:
        print(f"wrote {export_dataset(name, root, out, tasks=tasks)}")
    except MissingExtra as error:
        print(error)


def _show_progress(report: RecordReport) -> None:
    print(f"{report.found + report.recorded} of {report.wanted}", end="\r", flush=True)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/export"))
    parser.add_argument("--tasks", nargs="+", default=["reach_target", "pick_and_lift"])
    parser.add_argument("--episodes", type=int, default=4, help="number of episodes of each task")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--image-size", type=int, default=96, help="width and height of the images [px]")
    parser.add_argument("--workers", type=int, default=2)
    return parser.parse_args()


if __name__ == "__main__":
    main()
