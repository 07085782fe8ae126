"""The files of a task that a dataset keeps: whole, checked, and never from outside their folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rlbench_pin.datasets import DatasetWriter, keep_files, kept_task, merge_datasets, stored_tasks, task_faults
from rlbench_pin.errors import DatasetConflict, EpisodeFileError
from tests.demos_for_tests import make_demo

FILES = {"mine.py": b"x = 1\n", "mine.toml": b"format = 2\n", "models/a.obj": b"v 0 0 0\n"}


def test_what_is_kept_is_read_again(tmp_path: Path) -> None:
    """Every byte, below the folder of the task; nothing where nothing was kept."""
    assert kept_task(tmp_path, "mine") is None
    kept = keep_files(tmp_path, "mine", "mine.py", FILES)
    assert kept == kept_task(tmp_path, "mine") and kept.contents() == FILES
    assert kept.path == tmp_path / "mine" / "task_file" / "mine.py"
    assert stored_tasks(tmp_path) == (), "files alone are no episodes"


def test_the_same_files_are_kept_once_and_others_refused(tmp_path: Path) -> None:
    """Keeping again writes what was lost; changed files are named."""
    keep_files(tmp_path, "mine", "mine.py", FILES)
    (tmp_path / "mine" / "task_file" / "mine.toml").unlink()
    assert keep_files(tmp_path, "mine", "mine.py", FILES).contents() == FILES
    with pytest.raises(DatasetConflict, match=r"\['mine.toml'\] differ"):
        keep_files(tmp_path, "mine", "mine.py", {**FILES, "mine.toml": b"format = 1\n"})
    with pytest.raises(DatasetConflict, match=r"\['models/a.obj'\] differ"):
        keep_files(tmp_path, "mine", "mine.py", {n: d for n, d in FILES.items() if n != "models/a.obj"})


def _change(index: Path, **changes: Any) -> None:
    index.write_text(json.dumps({**json.loads(index.read_text()), **changes}))


@pytest.mark.parametrize(
    "changes",
    [
        {"version": 2}, {"task": "other"}, {"file": "../mine.py"}, {"file": "mine.toml"}, {"file": 3}, {"files": 3},
        {"files": {"mine.py": 3}}, {"files": {"mine.py": "a", "../../x": "b"}}, {"files": {"mine.py": "a", "/etc/passwd": "b"}},
        {"files": {"mine.py": "a", "": "b"}}, {"files": {"mine.py": "a", "files.json": "b"}}, {"files": [["mine.py"]]},
    ],
)  # fmt: skip
def test_a_list_that_is_none_is_refused(changes: dict[str, Any], tmp_path: Path) -> None:
    """Other versions, other tasks, paths that lead out, and values of other kinds."""
    index = keep_files(tmp_path, "mine", "mine.py", FILES).folder / "files.json"
    _change(index, **changes)
    with pytest.raises(EpisodeFileError, match="does not list the files of the task 'mine'"):
        kept_task(tmp_path, "mine")


@pytest.mark.parametrize("text", ["", "[]", "null", "{", "[" * 100_000, " " * (1 << 21)])
def test_a_list_that_is_no_json_is_refused(text: str, tmp_path: Path) -> None:
    """Empty, of another kind, nested without end, endless."""
    index = keep_files(tmp_path, "mine", "mine.py", FILES).folder / "files.json"
    index.write_text(text)
    with pytest.raises(EpisodeFileError, match="does not list"):
        kept_task(tmp_path, "mine")


def test_changed_missing_and_foreign_files_are_faults(tmp_path: Path) -> None:
    """`contents` refuses them, and `dataset verify` names them."""
    DatasetWriter(tmp_path).add(make_demo(frames=2, seed=0))
    (task,) = stored_tasks(tmp_path)
    kept = keep_files(tmp_path, task, "mine.py", FILES)
    assert task_faults(tmp_path, task) == []
    kept.path.write_bytes(b"import os\n")
    assert ["SHA-256 differs" in str(fault) for fault in task_faults(tmp_path, task)] == [True]
    kept.path.unlink()
    with pytest.raises(EpisodeFileError, match="not a file of that folder"):
        kept.contents()
    (tmp_path / "elsewhere.py").write_bytes(FILES["mine.py"])
    kept.path.symlink_to(tmp_path / "elsewhere.py")
    with pytest.raises(EpisodeFileError, match="not a file of that folder"):
        kept.contents()


def test_merging_takes_the_files_along(tmp_path: Path) -> None:
    """Where all datasets keep the same; otherwise nothing is written."""
    for name, seed in {"a": 0, "b": 1, "bare": 2, "other": 3}.items():
        DatasetWriter(tmp_path / name).add(make_demo(frames=2, seed=seed))
    (task,) = stored_tasks(tmp_path / "a")
    for name in ("a", "b"):
        keep_files(tmp_path / name, task, "mine.py", FILES)
    keep_files(tmp_path / "other", task, "mine.py", {**FILES, "mine.py": b"x = 2\n"})
    merge_datasets([tmp_path / "a", tmp_path / "b"], tmp_path / "out")
    kept = kept_task(tmp_path / "out", task)
    assert kept is not None and kept.contents() == FILES
    for name, says in {"bare": "stores none", "other": r"\['mine.py'\] differ"}.items():
        with pytest.raises(DatasetConflict, match=says):
            merge_datasets([tmp_path / "a", tmp_path / name], tmp_path / "new")
        assert not (tmp_path / "new").exists()
