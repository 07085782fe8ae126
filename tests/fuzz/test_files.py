"""Damaged, exchanged and made-up files are read rightly or refused by name, by every reader; none ends or stops the process."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.datasets import (
    merge_datasets,
    read_demo,
    read_manifest,
    stored_demos,
    stored_images,
    stored_tasks,
    task_faults,
    task_info,
)
from rlbench_pin.datasets.formats import export_rlbench, export_robomimic, read_folder
from rlbench_pin.datasets.trust import Inspector
from rlbench_pin.planning.problems import read_motion_bench, read_problem
from rlbench_pin.recording import RecordConfig, SerialEngine, read_recording, record
from tests.demos_for_tests import fill
from tests.fuzz.cases import Case, Tally
from tests.fuzz.mutations import changed, damaged

TASK = "reach_target"
Readers = dict[str, Callable[[], object]]


def made(folder: Path) -> Path:
    """Write a dataset, its settings, and a planning problem."""
    root = fill(folder / "data", range(2))
    record(RecordConfig(tasks=(TASK,), episodes=1), folder / "recorded", engine=SerialEngine())
    shutil.copy(folder / "recorded" / "recording.json", root / "recording.json")
    export_rlbench(root, folder / "rlbench")
    return root


def readers(root: Path, folder: Path, inspector: Inspector) -> Readers:
    """Return everything that opens files of a dataset."""
    episode = root / TASK / "variation0" / "episodes" / "episode0.h5"
    new = iter(range(10**9))
    return {
        "read_manifest": lambda: read_manifest(root, TASK),
        "stored_demos": lambda: stored_demos(root, TASK, -1, -1, random_selection=False),
        "task_faults": lambda: [str(fault) for fault in task_faults(root, TASK)],
        "task_info": lambda: task_info(root, TASK),
        "stored_tasks": lambda: stored_tasks(root),
        "read_recording": lambda: read_recording(root),
        "merge_datasets": lambda: merge_datasets([root], folder / f"merged{next(new)}"),
        "read_demo": lambda: read_demo(episode, inspector=inspector),
        "stored_images": lambda: stored_images(episode),
        "export_robomimic": lambda: export_robomimic(root, folder / f"exported{next(new)}"),
    }


def spoil(root: Path, source: Path, rng: np.random.Generator) -> str:
    """Make `root` a damaged copy of `source` and say how."""
    shutil.rmtree(root, ignore_errors=True)
    shutil.copytree(source, root, symlinks=True)
    files = sorted(path for path in root.rglob("*") if path.is_file())
    path = files[int(rng.integers(len(files)))]
    kind = int(rng.integers(10))
    if path.suffix == ".json" and kind < 6:
        path.write_text(json.dumps(changed(json.loads(path.read_text()), rng)))
    elif kind == 6:
        path.unlink()
        path.symlink_to(["/etc/passwd", "/dev/null", path.name, "../../.."][int(rng.integers(4))])
    elif kind == 7:
        path.write_bytes(files[int(rng.integers(len(files)))].read_bytes())
    elif kind == 8 and path.suffix == ".json":
        path.write_text("[" * 50_000)
    elif kind == 9:
        path.unlink()
        path.mkdir()
    else:
        path.write_bytes(damaged(path.read_bytes(), rng))
    if rng.random() < 0.3:
        (root / TASK / "manifest.json").unlink(missing_ok=True) if not (root / TASK / "manifest.json").is_dir() else None
    return f"{path.relative_to(root)}, change {kind}"


def try_files(tally: Tally, folder: Path, seed: int, count: int) -> None:
    """Damage a dataset many times, and open it with each reader."""
    source, root = made(folder / "good"), folder / "bad"
    with Inspector() as inspector:
        every = readers(root, folder, inspector)
        for number in range(count):
            rng = np.random.default_rng((seed, number))
            how = spoil(root, source, rng)
            for name in rng.permutation(list(every))[:4]:
                tally.run(Case(str(name), f"{how} (number {number} of seed {seed})", every[str(name)], finite=False))


def try_foreign(tally: Tally, folder: Path, seed: int, count: int) -> None:
    """Damage the files of other programs: pickled demonstrations, planning problems, settings."""
    pickled = folder / "good" / "rlbench" / TASK / "variation0" / "episodes" / "episode0"
    bad, problem = folder / "foreign", folder / "problem.json"
    for number in range(count):
        rng = np.random.default_rng((seed, number, 1))

        shutil.rmtree(bad, ignore_errors=True)
        shutil.copytree(pickled, bad)
        file = bad / "low_dim_obs.pkl"
        file.write_bytes(damaged(file.read_bytes(), rng))
        tally.run(Case("read_folder", f"number {number} of seed {seed}", lambda: read_folder(bad), finite=False))
        tree = {"format": "rlbench_pin.problem", "version": 1, "name": "x", "bodies": [], "arm": [0.0] * 7, "goal": [0.0] * 7}
        problem.write_text(json.dumps(changed(tree, rng)))
        tally.run(Case("read_problem", f"number {number} of seed {seed}", lambda: read_problem(problem), finite=False))
        tally.run(Case("read_motion_bench", f"number {number}", lambda: read_motion_bench(problem, problem), finite=False))


@pytest.mark.simulation
def test_files(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Some damage, some readers."""
    try_files(tally, elsewhere, seed, 40)
    try_foreign(tally, elsewhere, seed, 20)
    assert not tally.faults, f"seed {seed}:\n{tally.report()}"
    assert tally.cases > 200


@pytest.mark.slow
def test_files_many_times(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Much damage."""
    try_files(tally, elsewhere, seed, 60)
    try_foreign(tally, elsewhere, seed, 150)
    assert not tally.faults, f"seed {seed}:\n{tally.report()}"
    assert tally.cases > 650
