"""`rlbench-pin dataset` as a user types it."""

from __future__ import annotations

import json
import os
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.cli.running import parse
from rlbench_pin.datasets import DatasetWriter, episode_files, read_demo, read_manifest
from tests.cli.support import RECORD, TASK, exit_code
from tests.demos_for_tests import make_demo

Capture = pytest.CaptureFixture[str]
MonkeyPatch = pytest.MonkeyPatch


def test_info_counts(made_up: Path, capsys: Capture) -> None:
    """Episodes, frames, lengths, images and versions, for people and for programs."""
    assert exit_code("dataset", "info", str(made_up)) == 0
    out = capsys.readouterr().out
    assert "2..3..4" in out
    assert "rlbench_pin 0.1.0" in out
    assert exit_code("dataset", "info", str(made_up), "--json") == 0
    (info,) = json.loads(capsys.readouterr().out)
    assert (info["task"], info["episodes"], info["frames"], info["longest"]) == (TASK, 3, 9, 4)
    assert info["images"]["front_rgb"] == [12, 16, 3]


def test_verify_names_every_bad_file(made_up: Path, capsys: Capture) -> None:
    """Exit 0 when all is well; 1 and the names of the bad files otherwise."""
    assert exit_code("dataset", "verify", str(made_up)) == 0
    assert "no faults" in capsys.readouterr().out
    files = episode_files(made_up, TASK)
    os.truncate(files[0], 1000)
    data = bytearray(files[2].read_bytes())
    data[len(data) // 2] ^= 1
    files[2].write_bytes(bytes(data))
    assert exit_code("dataset", "verify", str(made_up)) == 1
    out = capsys.readouterr().out
    assert str(files[0]) in out
    assert str(files[2]) in out
    assert str(files[1]) not in out


def test_a_folder_without_demonstrations_is_named(tmp_path: Path, capsys: Capture) -> None:
    """So is one that does not exist."""
    for command in ("info", "verify"):
        assert exit_code("dataset", command, str(tmp_path)) == 1
        assert "contains no demonstrations" in capsys.readouterr().err
        assert exit_code("dataset", command, str(tmp_path / "nowhere")) == 1
        assert "does not exist" in capsys.readouterr().err


def test_merge_copies(made_up: Path, tmp_path: Path, capsys: Capture) -> None:
    """Episodes of two folders in one; conflicts exit with 1."""
    DatasetWriter(tmp_path / "more").add(make_demo(frames=2, seed=8))
    out = ("--out", str(tmp_path / "all"))
    assert exit_code("dataset", "merge", str(made_up), str(tmp_path / "more"), *out) == 0
    assert "4 episodes copied" in capsys.readouterr().out
    assert len(read_manifest(tmp_path / "all", TASK)) == 4
    DatasetWriter(tmp_path / "other").add(make_demo(frames=5, seed=8))
    assert exit_code("dataset", "merge", str(tmp_path / "other"), *out) == 1
    assert "but differ" in capsys.readouterr().err


def test_rerender_gives_the_same_motion_new_images(tmp_path: Path, capsys: Capture) -> None:
    """From the files, from the manifest alone, and from a list of seeds: the same joints, and the images asked for."""
    source = tmp_path / "source"
    assert exit_code(*RECORD, "--episodes", "1", "--arm-max-velocity", "0.6", "--out", str(source)) == 0
    assert exit_code("dataset", "seeds", str(source), str(tmp_path / "seeds.json")) == 0
    options = ("--workers", "0", "--cameras", "front", "--products", "rgb", "mask", "--image-size", "24", "16")
    outs = [tmp_path / name for name in ("files", "manifest", "seeds")]
    assert exit_code("dataset", "rerender", str(source), "--out", str(outs[0]), *options) == 0
    assert exit_code("dataset", "rerender", str(tmp_path / "seeds.json"), "--out", str(outs[2]), *options) == 0
    before = [read_demo(path) for path in episode_files(source, TASK)]
    for path in episode_files(source, TASK):
        path.unlink()
    assert exit_code("dataset", "rerender", str(source), "--out", str(outs[1]), *options) == 0
    for old, path in zip(before, episode_files(outs[0], TASK), strict=True):
        new = read_demo(path)
        assert np.array_equal([o.joint_positions for o in old], [o.joint_positions for o in new])
        assert np.asarray(new[0].front_rgb).shape == (16, 24, 3)
        assert new[0].front_depth is None
        assert new.random_seed == old.random_seed
    larger = ("--workers", "0", "--cameras", "front", "--products", "rgb", "mask", "--image-size", "48", "32")
    assert exit_code("dataset", "rerender", str(source), "--out", str(outs[0]), *larger) == 1
    assert "Use the same images, or choose another folder" in capsys.readouterr().err
    manifests = [(out / TASK / "manifest.json").read_bytes() for out in outs]
    assert manifests[0] == manifests[1] == manifests[2]


def test_rerender_follows_the_states_when_the_seed_does_not(tmp_path: Path, capsys: Capture) -> None:
    """A demo whose seed gives something else now is replayed from its own start and actions; one that cannot be is named."""
    source = tmp_path / "source"
    assert exit_code(*RECORD, "--episodes", "2", "--out", str(source)) == 0
    demos = [read_demo(path) for path in episode_files(source, TASK)]
    nudged, lost = demos
    for observation in nudged:
        observation.joint_positions = np.asarray(observation.joint_positions) + 1e-6
    for observation in lost:
        observation.joint_positions = np.asarray(observation.joint_positions) + 0.1
    for demo in demos:
        DatasetWriter(source).add(demo)
    arguments = ("dataset", "rerender", str(source), "--out", str(tmp_path / "out"), "--workers", "0", "--products", "rgb")
    assert exit_code(*arguments, "--cameras", "wrist", "--image-size", "16", "16") == 1
    err = capsys.readouterr().err
    assert f"seed {lost.random_seed}" in err
    assert "Neither the seed nor the actions" in err
    (path,) = episode_files(tmp_path / "out", TASK)
    replayed = read_demo(path)
    assert (replayed.random_seed, len(replayed)) == (nudged.random_seed, len(nudged))
    error = np.array([o.joint_positions for o in replayed]) - np.array([o.joint_positions for o in nudged])
    assert 0 < np.abs(error).max() < 1e-3
    assert len({np.asarray(o.wrist_rgb).tobytes() for o in replayed}) > 5


def test_rerender_refuses_nonsense(made_up: Path, tmp_path: Path, capsys: Capture) -> None:
    """Onto itself, from a file that is no list of seeds, of a task that is not there."""
    assert exit_code("dataset", "rerender", str(made_up), "--out", str(made_up)) == 1
    assert "Choose another folder" in capsys.readouterr().err
    (tmp_path / "seeds.json").write_text("[]")
    assert exit_code("dataset", "rerender", str(tmp_path / "seeds.json"), "--out", str(tmp_path / "out")) == 1
    assert "is not a list of seeds" in capsys.readouterr().err
    assert exit_code("dataset", "rerender", str(made_up), "--out", str(tmp_path / "out"), "--tasks", "push_button") == 1
    assert "push_button" in capsys.readouterr().err


def test_the_commands_of_the_page_exist() -> None:
    """Every command line of docs/datasets.md is one that the program takes."""
    page = (Path(__file__).parents[2] / "docs" / "datasets.md").read_text(encoding="utf-8")
    lines: list[str] = re.findall(r"^rlbench-pin (.*)$", page, re.MULTILINE)
    assert len(lines) > 12
    for line in lines:
        assert callable(parse(shlex.split(line, comments=True)).run)
