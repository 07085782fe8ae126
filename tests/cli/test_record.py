"""`rlbench-pin record` as a user types it: what it writes, what it reports, and how it goes on after a kill."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.datasets import episode_files, read_demo, read_manifest, stored_tasks, task_faults
from tests.cli.support import RECORD, TASK, exit_code

Capture = pytest.CaptureFixture[str]
MonkeyPatch = pytest.MonkeyPatch


def test_record_and_resume(tmp_path: Path, capsys: Capture) -> None:
    """The report counts; recording again is refused, resuming finds everything there, growing adds the rest."""
    out = ("--out", str(tmp_path), "--json")
    assert exit_code(*RECORD, "--episodes", "2", *out) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["wanted"], report["recorded"], report["found"], report["failed"]) == (2, 2, 0, [])
    assert report["num_bytes"] == sum(path.stat().st_size for path in episode_files(tmp_path, TASK))
    assert exit_code(*RECORD, "--episodes", "2", *out) == 1
    assert "--resume" in capsys.readouterr().err
    assert exit_code("record", "--resume", "--workers", "0", *out) == 0
    assert json.loads(capsys.readouterr().out)["found"] == 2
    assert exit_code(*RECORD, "--episodes", "3", "--resume", *out) == 0
    assert json.loads(capsys.readouterr().out)["recorded"] == 1


def test_without_ray_the_engine_is_explained(made_up: Path, tmp_path: Path, capsys: Capture, monkeypatch: MonkeyPatch) -> None:
    """`--engine ray` where Ray cannot be imported says what to install, and begins nothing."""
    monkeypatch.delitem(sys.modules, "rlbench_pin.processes.ray_engine", raising=False)
    monkeypatch.setitem(sys.modules, "ray", None)
    for command in (("record", TASK), ("dataset", "rerender", str(made_up))):
        assert exit_code(*command, "--engine", "ray", "--out", str(tmp_path / "out")) == 1, command
        err = capsys.readouterr().err
        assert "The engine 'ray' needs 'ray', which is not installed. Install it with `pip install -e '.[ray]'`" in err, command
        assert "Traceback" not in err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("reach_targt",), "Did you mean 'reach_target'"),
        ((), "No task was named"),
        ((TASK, "--episodes", "0"), "episodes has to be a whole number"),
        ((TASK, "--cameras", "frnt"), "Did you mean 'front'"),
    ],
)
def test_misuse_is_explained(tmp_path: Path, capsys: Capture, arguments: tuple[str, ...], words: str) -> None:
    """Wrong names and numbers exit with 2 and write nothing."""
    assert exit_code("record", *arguments, "--workers", "0", "--out", str(tmp_path / "data")) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "data").exists()


def test_tasks_with_commas_between_them(tmp_path: Path, capsys: Capture) -> None:
    """Recorded, checked and exported like tasks with spaces between them."""
    names = f"{TASK},push_button"
    assert exit_code("record", names, "--workers", "0", "--episodes", "1", "--out", str(tmp_path / "data"), "--products") == 0
    assert stored_tasks(tmp_path / "data") == ("push_button", TASK)
    assert exit_code("dataset", "export", "rlbench", str(tmp_path / "data"), str(tmp_path / "x"), "--tasks", names) == 0
    assert "2 episodes" in capsys.readouterr().out
    for command in (("check",), ("problems", "export"), ("video",), ("evaluate", "expert", "--tasks")):
        assert exit_code(*command, "reach_targt,push_buton") == 2
        assert "Did you mean 'reach_target'" in capsys.readouterr().err


def test_resuming_takes_the_recorded_settings(tmp_path: Path, capsys: Capture) -> None:
    """Flags that are left out are those of the folder, also for a further task; another value is refused, as flags."""
    out, small = (
        ("--workers", "0", "--out", str(tmp_path)),
        ("--cameras", "front", "--image-size", "16", "12", "--products", "rgb"),
    )
    assert exit_code("record", TASK, "--seed", "7", "--episodes", "1", *small, *out) == 0
    assert exit_code("record", "push_button", "--resume", *out) == 0
    demo = read_demo(episode_files(tmp_path, "push_button")[0])
    assert demo[0].front_rgb is not None and demo[0].front_rgb.shape == (12, 16, 3) and demo[0].wrist_rgb is None
    assert len(episode_files(tmp_path, "push_button")) == 1
    assert exit_code("record", "--resume", "--episodes", "2", "--save_path", str(tmp_path), "--workers", "0") == 0
    assert len(episode_files(tmp_path, TASK)) == 2
    capsys.readouterr()
    assert exit_code("record", TASK, "--resume", "--seed", "0", *out) == 1
    assert "was recorded with `--seed 7`, not with `--seed 0`" in capsys.readouterr().err


def test_an_unknown_command_names_the_near_one(capsys: Capture) -> None:
    """As wrong usage."""
    assert exit_code("recrod", TASK) == 2
    assert "No command is called 'recrod'. Did you mean 'record'?" in capsys.readouterr().err


def test_resuming_nothing_is_an_error(tmp_path: Path, capsys: Capture) -> None:
    """A folder without a recording cannot be resumed without naming tasks."""
    assert exit_code("record", "--resume", "--out", str(tmp_path)) == 1
    assert "rlbench-pin record TASK... --out" in capsys.readouterr().err


def test_images_are_those_asked_for(tmp_path: Path) -> None:
    """Cameras, products and size are as on the command line; depth is exact."""
    options = ("--cameras", "front", "wrist", "--products", "rgb", "depth", "--image-size", "32", "24", "--episodes", "1")
    assert exit_code("record", TASK, "--workers", "0", *options, "--out", str(tmp_path)) == 0
    demo = read_demo(episode_files(tmp_path, TASK)[0])
    images = {name for name, value in vars(demo[0]).items() if isinstance(value, np.ndarray) and value.ndim >= 2}
    assert images - {"gripper_matrix"} == {"front_rgb", "front_depth", "wrist_rgb", "wrist_depth"}
    assert demo[0].front_rgb is not None
    assert demo[0].front_rgb.shape == (24, 32, 3)
    assert len({np.asarray(obs.wrist_rgb).tobytes() for obs in demo}) > 5


def _start(out: Path, *arguments: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "rlbench_pin.cli.main", "record", *arguments, "--out", str(out)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def _wait_for_episodes(out: Path, count: int) -> None:
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline:
        if len(list(out.glob(f"{TASK}/variation*/episodes/episode*.h5"))) >= count:
            return
        time.sleep(0.01)
    raise AssertionError(f"no {count} episodes in time")


@pytest.mark.slow
def test_killed_three_times_and_resumed(tmp_path: Path) -> None:
    """SIGKILL at three random moments, with and without a process of its own: the same dataset as undisturbed."""
    rng = np.random.default_rng()
    plan = (TASK, "--episodes", "30", "--products")
    calm, rough = tmp_path / "calm", tmp_path / "rough"
    assert main(["record", *plan, "--workers", "0", "--out", str(calm)]) == 0
    for kill, workers in enumerate(("0", "1", "2")):
        more = ("--resume", "--workers", workers) if kill else (*plan, "--workers", workers)
        process = _start(rough, *more)
        _wait_for_episodes(rough, 6 * kill + 2)
        time.sleep(rng.uniform(0.0, 0.5))
        process.send_signal(signal.SIGKILL)
        process.communicate()
        assert len(read_manifest(rough, TASK)) < 30
    assert main(["record", "--resume", "--workers", "0", "--out", str(rough)]) == 0
    assert (rough / TASK / "manifest.json").read_bytes() == (calm / TASK / "manifest.json").read_bytes()
    assert task_faults(rough, TASK) == []
    assert not list(rough.rglob("*.part"))


@pytest.mark.slow
def test_an_interrupt_finishes_what_is_under_way(tmp_path: Path) -> None:
    """Ctrl-C finishes what is under way, says how to go on, exits with 130; the command it says completes the dataset."""
    process = _start(tmp_path, TASK, "--episodes", "60", "--products", "--workers", "1")
    _wait_for_episodes(tmp_path, 2)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    text = err.decode()
    assert process.returncode == 130
    assert "Press Ctrl-C again to stop at once" in text
    assert f"rlbench-pin record --resume --out {tmp_path} --workers 1" in text
    assert "Traceback" not in text
    assert task_faults(tmp_path, TASK) == []
    assert 2 <= len(read_manifest(tmp_path, TASK)) < 60


def test_files_carry_no_time(tmp_path: Path) -> None:
    """Two recordings of the same plan at different times are the same bytes."""
    roots = [tmp_path / "a", tmp_path / "b"]
    for root in roots:
        assert exit_code(*RECORD, "--episodes", "1", "--out", str(root)) == 0
        time.sleep(1.1)
    one, two = (episode_files(root, TASK)[0] for root in roots)
    assert one.read_bytes() == two.read_bytes()
    with h5py.File(one, "r") as file:
        assert file.attrs["task"] == TASK
