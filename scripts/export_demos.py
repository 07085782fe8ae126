"""Record demonstrations, look after them, and hand them to other libraries: all through the Python API.

    python scripts/export_demos.py --out out/export --tasks reach_target pick_and_lift --episodes 4 --workers 2

It records (or resumes), verifies, reads one episode lazily, and writes the same data as a LeRobotDataset (when pyarrow is
there), a robomimic file per task, and RLBench-style folders. Run it again: what is recorded is found, not made again.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from rlbench_pin.datasets import Episode, read_manifest, stored_tasks, task_faults
from rlbench_pin.datasets.formats.rlbench_folders import export_rlbench
from rlbench_pin.datasets.formats.robomimic import export_robomimic
from rlbench_pin.recording.config import PictureConfig, RecordConfig
from rlbench_pin.recording.engines import ProcessEngine
from rlbench_pin.recording.record import RecordReport, record

try:
    from rlbench_pin.datasets.formats.lerobot import export_lerobot
except ImportError:  # the extra `lerobot` is not installed
    export_lerobot = None  # type: ignore[assignment]


def main() -> None:
    """Record, check, read, export."""
    options = _options()
    root = options.out / "dataset"
    pictures = PictureConfig(cameras=("front", "wrist"), products=("rgb", "depth"), image_size=(options.image_size,) * 2)
    config = RecordConfig(tasks=tuple(options.tasks), episodes=options.episodes, seed=options.seed, pictures=pictures)
    report = record(config, root, engine=ProcessEngine(options.workers), resume=True, on_progress=_tell)
    print(f"{report.recorded} recorded now, {report.found} found, {report.missing} missing")

    for task in stored_tasks(root):
        faults = task_faults(root, task)
        entry = read_manifest(root, task)[0]
        with Episode(root / task / entry.file, entry.sha256) as episode:
            middle = episode[len(episode) // 2]
        print(f"{task}: {len(faults)} faults; {episode.path.name} shows {entry.instructions[0]!r} in {entry.frames} frames,")
        print(
            f"    in the middle the tip is at {middle.gripper_pose[:3].round(3)} m, the front picture is {middle.front_rgb.shape}"
        )

    for task in stored_tasks(root):
        _export(options.out / f"{task}.hdf5", lambda out, task=task: export_robomimic(root, out, tasks=(task,)))
    _export(options.out / "rlbench", lambda out: export_rlbench(root, out))
    if export_lerobot is not None:
        _export(options.out / "lerobot", lambda out: export_lerobot(root, out))


def _export(out: Path, export: Callable[[Path], Path]) -> None:
    if out.exists():
        print(f"{out} is there already")
    else:
        print(f"wrote {export(out)}")


def _tell(report: RecordReport) -> None:
    print(f"{report.found + report.recorded} of {report.wanted}", end="\r", flush=True)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/export"))
    parser.add_argument("--tasks", nargs="+", default=["reach_target", "pick_and_lift"])
    parser.add_argument("--episodes", type=int, default=4, help="of each task")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--image-size", type=int, default=96, help="width and height of the pictures [px]")
    parser.add_argument("--workers", type=int, default=2)
    return parser.parse_args()


if __name__ == "__main__":
    main()
