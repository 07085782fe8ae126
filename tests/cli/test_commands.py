"""The commands as a user types them: what they print, what they write, how they end."""

from __future__ import annotations

import json
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image

from rlbench_pin.datasets import episode_files, read_demo, verify_task
from rlbench_pin.tasks import task_names
from tests.cli.support import exit_code

Capture = pytest.CaptureFixture[str]


def test_list_names_every_task(capsys: Capture) -> None:
    """One line per task, name first."""
    assert exit_code("list") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(task_names())
    assert all(len(line.split()) > 3 and line.split()[1] == "v1" for line in lines)


def test_list_for_programs(capsys: Capture) -> None:
    """`--json` prints one object, with title and version of each task."""
    assert exit_code("list", "--json") == 0
    content = json.loads(capsys.readouterr().out)
    assert list(content) == list(task_names())
    assert content["open_drawer"] == {"title": "Pull out one drawer of a chest.", "version": 1}


@pytest.mark.parametrize("arguments", [(), ("fly",), ("demo",), ("demo", "reach_target", "--episodes", "many")])
def test_misuse_ends_with_two(arguments: tuple[str, ...], capsys: Capture) -> None:
    """A wrong command line is explained on stderr and exits with 2."""
    assert exit_code(*arguments) == 2
    captured = capsys.readouterr()
    assert captured.err


@pytest.mark.parametrize("command", ["demo", "check", "view"])
def test_an_unknown_task_is_misuse(command: str, capsys: Capture) -> None:
    """The nearest name is proposed."""
    assert exit_code(command, "reach_targt") == 2
    assert "Did you mean 'reach_target'" in capsys.readouterr().err


def test_an_unknown_variation_is_misuse(tmp_path: Path, capsys: Capture) -> None:
    """The possible ones are named."""
    assert exit_code("demo", "take_lid_off_saucepan", "--variation", "7", "--out", str(tmp_path)) == 2
    assert "no variation 7" in capsys.readouterr().err


def test_demo_writes_an_episode(tmp_path: Path, capsys: Capture) -> None:
    """The episode holds images of the size asked for, depth, and a passing checksum; twice is once."""
    arguments = ("demo", "reach_target", "--seed", "4", "--out", str(tmp_path), "--no-video", "--json")
    options = ("--image-size", "24", "16", "--cameras", "front", "wrist")
    assert exit_code(*arguments, *options) == 0
    (recorded,) = json.loads(capsys.readouterr().out)
    assert (recorded["task"], recorded["seed"], recorded["video"]) == ("reach_target", 4, None)
    assert exit_code(*arguments, *options) == 0
    (path,) = episode_files(tmp_path, "reach_target")
    assert str(path) == recorded["episode"]
    demo = read_demo(path)
    assert len(demo) == recorded["frames"]
    assert demo[0].front_rgb is not None
    assert demo[0].front_rgb.shape == (16, 24, 3)
    assert demo[0].wrist_depth is not None
    assert demo[0].overhead_rgb is None
    assert np.ptp(demo[-1].front_rgb) > 50
    verify_task(tmp_path, "reach_target")


@pytest.mark.slow
def test_demo_videos(tmp_path: Path, capsys: Capture) -> None:
    """The video lies beside the episode, runs in real time and shows motion."""
    assert exit_code("demo", "take_lid_off_saucepan", "--out", str(tmp_path), "--cameras", "front") == 0
    out = capsys.readouterr().out
    film = tmp_path / "take_lid_off_saucepan" / "variation0" / "videos" / "episode0.mp4"
    assert str(film) in out
    with av.open(str(film)) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.height, float(stream.average_rate)) == (640, 480, 20.0)
        images = [frame.to_ndarray(format="rgb24").astype(int) for frame in container.decode(stream)]
    assert len(images) > 60
    assert np.abs(images[0] - images[-1]).max() > 50
    assert not list(tmp_path.glob(".recording*"))


@pytest.mark.slow
def test_view_draws_a_contact_sheet(tmp_path: Path, capsys: Capture) -> None:
    """The task view with the five cameras beside it, the events below each other."""
    out = tmp_path / "sheet.png"
    assert exit_code("view", "reach_target", "--out", str(out), "--size", "64") == 0
    assert capsys.readouterr().out.strip() == str(out)
    with Image.open(out) as sheet:
        assert sheet.width > 64 + 3 * 10
        assert sheet.height > 4 * 64
