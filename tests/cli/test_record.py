"""`rlbench-pin record` and `rlbench-pin dataset` as a user types them."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import tyro

from rlbench_pin.cli.main import COMMANDS, main
from rlbench_pin.datasets import DatasetWriter, episode_files, read_demo, read_manifest, task_faults, write_demo
from tests.demos_for_tests import make_demo

Capture = pytest.CaptureFixture[str]
MonkeyPatch = pytest.MonkeyPatch
TASK = "reach_target"
HERE = ("record", TASK, "--workers", "0", "--products")


def _exit_code(*arguments: str) -> int:
    try:
        return main(arguments)
    except SystemExit as stop:
        return int(stop.code or 0)


def test_record_and_resume(tmp_path: Path, capsys: Capture) -> None:
    """The report counts; recording again is refused, resuming finds everything there, growing adds the rest."""
    out = ("--out", str(tmp_path), "--json")
    assert _exit_code(*HERE, "--episodes", "2", *out) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["wanted"], told["recorded"], told["found"], told["failed"]) == (2, 2, 0, [])
    assert told["num_bytes"] == sum(path.stat().st_size for path in episode_files(tmp_path, TASK))
    assert _exit_code(*HERE, "--episodes", "2", *out) == 1
    assert "--resume" in capsys.readouterr().err
    assert _exit_code("record", "--resume", "--workers", "0", *out) == 0
    assert json.loads(capsys.readouterr().out)["found"] == 2
    assert _exit_code(*HERE, "--episodes", "3", "--resume", *out) == 0
    assert json.loads(capsys.readouterr().out)["recorded"] == 1


def test_without_ray_the_engine_is_explained(made_up: Path, tmp_path: Path, capsys: Capture, monkeypatch: MonkeyPatch) -> None:
    """`--engine ray` where Ray cannot be imported says what to install, and begins nothing."""
    monkeypatch.delitem(sys.modules, "rlbench_pin.recording.ray_engine", raising=False)
    monkeypatch.setitem(sys.modules, "ray", None)
    for command in (("record", TASK), ("dataset", "rerender", str(made_up))):
        assert _exit_code(*command, "--engine", "ray", "--out", str(tmp_path / "out")) == 1, command
        told = capsys.readouterr().err
        assert "The engine 'ray' needs 'ray', which is not installed. `pip install 'rlbench-pin[ray]'`" in told, command
        assert "Traceback" not in told
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("reach_targt",), "Did you mean 'reach_target'"),
        ((), "No task was named"),
        ((TASK, "--episodes", "0"), "episodes=0"),
        ((TASK, "--cameras", "frnt"), "Did you mean 'front'"),
    ],
)
def test_misuse_is_explained(tmp_path: Path, capsys: Capture, arguments: tuple[str, ...], words: str) -> None:
    """Wrong names and numbers exit with 2 and write nothing."""
    assert _exit_code("record", *arguments, "--workers", "0", "--out", str(tmp_path / "data")) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "data").exists()


def test_resuming_nothing_is_an_error(tmp_path: Path, capsys: Capture) -> None:
    """A folder without a recording cannot be resumed without naming tasks."""
    assert _exit_code("record", "--resume", "--out", str(tmp_path)) == 1
    assert "Name the tasks" in capsys.readouterr().err


def test_pictures_are_those_asked_for(tmp_path: Path) -> None:
    """Cameras, products and size are as on the command line; depth is exact."""
    options = ("--cameras", "front", "wrist", "--products", "rgb", "depth", "--image-size", "32", "24", "--episodes", "1")
    assert _exit_code("record", TASK, "--workers", "0", *options, "--out", str(tmp_path)) == 0
    demo = read_demo(episode_files(tmp_path, TASK)[0])
    pictures = {name for name, value in vars(demo[0]).items() if isinstance(value, np.ndarray) and value.ndim >= 2}
    assert pictures - {"gripper_matrix"} == {"front_rgb", "front_depth", "wrist_rgb", "wrist_depth"}
    assert demo[0].front_rgb is not None
    assert demo[0].front_rgb.shape == (24, 32, 3)
    assert len({np.asarray(obs.wrist_rgb).tobytes() for obs in demo}) > 5


# dataset --------------------------------------------------------------------------------------------------------------


@pytest.fixture
def made_up(tmp_path: Path) -> Path:
    """A dataset that was never recorded."""
    for seed in range(3):
        DatasetWriter(tmp_path / "data").add(make_demo(frames=seed + 2, seed=seed))
    return tmp_path / "data"


def test_info_counts(made_up: Path, capsys: Capture) -> None:
    """Episodes, frames, lengths, pictures and versions, for people and for programs."""
    assert _exit_code("dataset", "info", str(made_up)) == 0
    out = capsys.readouterr().out
    assert "2..3..4" in out
    assert "rlbench_pin 0.1.0" in out
    assert _exit_code("dataset", "info", str(made_up), "--json") == 0
    (info,) = json.loads(capsys.readouterr().out)
    assert (info["task"], info["episodes"], info["frames"], info["longest"]) == (TASK, 3, 9, 4)
    assert info["pictures"]["front_rgb"] == [12, 16, 3]


def test_verify_names_every_bad_file(made_up: Path, capsys: Capture) -> None:
    """Exit 0 when all is well; 1 and the names of the bad files otherwise."""
    assert _exit_code("dataset", "verify", str(made_up)) == 0
    assert "no faults" in capsys.readouterr().out
    files = episode_files(made_up, TASK)
    os.truncate(files[0], 1000)
    data = bytearray(files[2].read_bytes())
    data[len(data) // 2] ^= 1
    files[2].write_bytes(bytes(data))
    assert _exit_code("dataset", "verify", str(made_up)) == 1
    out = capsys.readouterr().out
    assert str(files[0]) in out
    assert str(files[2]) in out
    assert str(files[1]) not in out


def test_a_folder_without_demonstrations_is_named(tmp_path: Path, capsys: Capture) -> None:
    """So is one that does not exist."""
    for command in ("info", "verify"):
        assert _exit_code("dataset", command, str(tmp_path)) == 1
        assert "holds no demonstrations" in capsys.readouterr().err
        assert _exit_code("dataset", command, str(tmp_path / "nowhere")) == 1
        assert "does not exist" in capsys.readouterr().err


def test_merge_copies(made_up: Path, tmp_path: Path, capsys: Capture) -> None:
    """Episodes of two folders in one; conflicts exit with 1."""
    DatasetWriter(tmp_path / "more").add(make_demo(frames=2, seed=8))
    out = ("--out", str(tmp_path / "all"))
    assert _exit_code("dataset", "merge", str(made_up), str(tmp_path / "more"), *out) == 0
    assert "4 episodes copied" in capsys.readouterr().out
    assert len(read_manifest(tmp_path / "all", TASK)) == 4
    DatasetWriter(tmp_path / "other").add(make_demo(frames=5, seed=8))
    assert _exit_code("dataset", "merge", str(tmp_path / "other"), *out) == 1
    assert "but differ" in capsys.readouterr().err


def test_rerender_gives_the_same_motion_new_pictures(tmp_path: Path, capsys: Capture) -> None:
    """From the files, from the manifest alone, and from a list of seeds: the same joints, and the pictures asked for."""
    source = tmp_path / "source"
    assert _exit_code(*HERE, "--episodes", "1", "--out", str(source)) == 0
    assert _exit_code("dataset", "seeds", str(source), str(tmp_path / "seeds.json")) == 0
    options = ("--workers", "0", "--cameras", "front", "--products", "rgb", "mask", "--image-size", "24", "16")
    outs = [tmp_path / name for name in ("files", "manifest", "seeds")]
    assert _exit_code("dataset", "rerender", str(source), "--out", str(outs[0]), *options) == 0
    assert _exit_code("dataset", "rerender", str(tmp_path / "seeds.json"), "--out", str(outs[2]), *options) == 0
    before = [read_demo(path) for path in episode_files(source, TASK)]
    for path in episode_files(source, TASK):
        path.unlink()
    assert _exit_code("dataset", "rerender", str(source), "--out", str(outs[1]), *options) == 0
    for old, path in zip(before, episode_files(outs[0], TASK), strict=True):
        new = read_demo(path)
        assert np.array_equal([o.joint_positions for o in old], [o.joint_positions for o in new])
        assert np.asarray(new[0].front_rgb).shape == (16, 24, 3)
        assert new[0].front_depth is None
        assert new.random_seed == old.random_seed
    larger = ("--workers", "0", "--cameras", "front", "--products", "rgb", "mask", "--image-size", "48", "32")
    assert _exit_code("dataset", "rerender", str(source), "--out", str(outs[0]), *larger) == 1
    assert "Choose the same, or another folder" in capsys.readouterr().err
    manifests = [(out / TASK / "manifest.json").read_bytes() for out in outs]
    assert manifests[0] == manifests[1] == manifests[2]


def test_rerender_follows_the_states_when_the_seed_does_not(tmp_path: Path, capsys: Capture) -> None:
    """A demo whose seed gives something else now is replayed from its own start and actions; one that cannot be is told."""
    source = tmp_path / "source"
    assert _exit_code(*HERE, "--episodes", "2", "--out", str(source)) == 0
    demos = [read_demo(path) for path in episode_files(source, TASK)]
    nudged, lost = demos
    for observation in nudged:
        observation.joint_positions = np.asarray(observation.joint_positions) + 1e-6
    for observation in lost:
        observation.joint_positions = np.asarray(observation.joint_positions) + 0.1
    for demo in demos:
        DatasetWriter(source).add(demo)
    arguments = ("dataset", "rerender", str(source), "--out", str(tmp_path / "out"), "--workers", "0", "--products", "rgb")
    assert _exit_code(*arguments, "--cameras", "wrist", "--image-size", "16", "16") == 1
    err = capsys.readouterr().err
    assert f"seed {lost.random_seed}" in err
    assert "Neither its seed nor its actions" in err
    (path,) = episode_files(tmp_path / "out", TASK)
    replayed = read_demo(path)
    assert (replayed.random_seed, len(replayed)) == (nudged.random_seed, len(nudged))
    error = np.array([o.joint_positions for o in replayed]) - np.array([o.joint_positions for o in nudged])
    assert 0 < np.abs(error).max() < 1e-3
    assert len({np.asarray(o.wrist_rgb).tobytes() for o in replayed}) > 5


def test_rerender_refuses_nonsense(made_up: Path, tmp_path: Path, capsys: Capture) -> None:
    """Onto itself, from a file that is no list of seeds, of a task that is not there."""
    assert _exit_code("dataset", "rerender", str(made_up), "--out", str(made_up)) == 1
    assert "Choose another folder" in capsys.readouterr().err
    (tmp_path / "seeds.json").write_text("[]")
    assert _exit_code("dataset", "rerender", str(tmp_path / "seeds.json"), "--out", str(tmp_path / "out")) == 1
    assert "holds no list of seeds" in capsys.readouterr().err
    assert _exit_code("dataset", "rerender", str(made_up), "--out", str(tmp_path / "out"), "--tasks", "push_button") == 1
    assert "push_button" in capsys.readouterr().err


def test_replay_tells_what_still_succeeds(tmp_path: Path, capsys: Capture) -> None:
    """A recorded episode reaches its goal again; one whose actions were stilled does not, and the exit code says so."""
    assert _exit_code(*HERE, "--episodes", "1", "--out", str(tmp_path)) == 0
    (path,) = episode_files(tmp_path, TASK)
    assert _exit_code("replay", str(tmp_path)) == 0
    assert f"reached  {path}" in capsys.readouterr().out
    demo = read_demo(path)
    for observation in demo[1:]:
        observation.misc["joint_position_action"] = demo[1].misc["joint_position_action"]
    write_demo(demo, path)
    assert _exit_code("replay", str(path)) == 1
    assert f"MISSED   {path}" in capsys.readouterr().out
    assert _exit_code("replay", str(tmp_path)) == 1
    assert path.name in capsys.readouterr().err, "it is not the file that its manifest lists"
    assert _exit_code("replay", str(tmp_path / "nothing.h5")) == 1
    assert "does not exist" in capsys.readouterr().err


def test_the_commands_of_the_page_exist() -> None:
    """Every command line of docs/datasets.md is one that the program takes."""
    page = (Path(__file__).parents[2] / "docs" / "datasets.md").read_text(encoding="utf-8")
    lines: list[str] = re.findall(r"^rlbench-pin (.*)$", page, re.MULTILINE)
    assert len(lines) > 12
    for line in lines:
        command = tyro.extras.subcommand_cli_from_dict(COMMANDS, args=shlex.split(line, comments=True))
        assert callable(command.run)


# Kills ----------------------------------------------------------------------------------------------------------------


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
def test_interrupted_gently(tmp_path: Path) -> None:
    """Ctrl-C finishes what is under way, says how to go on, exits with 1; the command it says completes the dataset."""
    process = _start(tmp_path, TASK, "--episodes", "60", "--products", "--workers", "1")
    _wait_for_episodes(tmp_path, 2)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    text = err.decode()
    assert process.returncode == 1
    assert "Ctrl-C again to abandon" in text
    assert f"rlbench-pin record --resume --out {tmp_path} --workers 1" in text
    assert "Traceback" not in text
    assert task_faults(tmp_path, TASK) == []
    assert 2 <= len(read_manifest(tmp_path, TASK)) < 60


def test_files_carry_no_time(tmp_path: Path) -> None:
    """Two recordings of the same plan at different times are the same bytes."""
    roots = [tmp_path / "a", tmp_path / "b"]
    for root in roots:
        assert _exit_code(*HERE, "--episodes", "1", "--out", str(root)) == 0
        time.sleep(1.1)
    one, two = (episode_files(root, TASK)[0] for root in roots)
    assert one.read_bytes() == two.read_bytes()
    with h5py.File(one, "r") as file:
        assert file.attrs["task"] == TASK
