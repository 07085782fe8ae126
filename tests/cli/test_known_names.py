"""`rlbench-pin record` with the flags of other generators."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from rlbench_pin.cli import record as command
from rlbench_pin.cli.record import spelled_out
from rlbench_pin.datasets import episode_files, read_demo
from rlbench_pin.recording.config import ImageConfig, RecordConfig, plan_items
from tests.cli.support import TASK, exit_code

Capture = pytest.CaptureFixture[str]


class Stopped(Exception):
    """Raised in the place of recording."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Keep what a command would record, and record nothing."""
    kept: dict[str, Any] = {}

    def keep(config: RecordConfig, out: Path, **settings: object) -> None:
        kept.update(config=config, out=out, **settings)
        raise Stopped

    monkeypatch.setattr(sys.modules["rlbench_pin.recording.record"], "record", keep)
    monkeypatch.setattr(command, "make_engine", lambda name, workers: workers)
    return kept


def config_of(asked: dict[str, Any], *arguments: str) -> RecordConfig:
    """Return what a command asks for."""
    with pytest.raises(Stopped):
        exit_code("record", *arguments)
    config: RecordConfig = asked["config"]
    return config


def test_the_flags_of_upstream_mean_what_they_mean_there(asked: dict[str, Any], tmp_path: Path) -> None:
    """Underscores, several values with spaces, episodes counted for each variation."""
    config = config_of(
        asked, "--save_path", str(tmp_path), "--tasks", "reach_target", "push_button", "--image_size", "64", "48",
        "--renderer", "opengl", "--processes", "3", "--episodes_per_task", "5", "--variations", "2",
        "--arm_max_velocity", "0.5", "--arm_max_acceleration", "2.0",
    )  # fmt: skip
    assert (asked["out"], asked["engine"]) == (tmp_path, 3)
    assert config == RecordConfig(
        tasks=("reach_target", "push_button"), episodes=5, per_variation=True, variations=2,
        max_velocity=0.5, max_acceleration=2.0, images=ImageConfig(image_size=(64, 48), render_mode="opengl"),
    )  # fmt: skip
    assert config.images.obs_config().camera("front").render_mode == "opengl"
    assert len(plan_items(config)) == 20


@pytest.mark.parametrize("flag", [("--all_variations=True",), ("--all_variations",), ("--all-variations", "true")])
def test_the_absl_style_is_understood(asked: dict[str, Any], flag: tuple[str, ...]) -> None:
    """Commas in lists and pairs, `=`, and episodes that are spread over all variations."""
    config = config_of(asked, "--tasks=reach_target,push_button", "--image_size=64,48", "--episodes_per_task=7", *flag)
    assert config.tasks == ("reach_target", "push_button")
    assert config.images.image_size == (64, 48)
    assert (config.episodes, config.per_variation) == (7, False)
    assert config_of(asked, TASK, "--all_variations=False").per_variation


def test_our_own_flags_are_as_before(asked: dict[str, Any]) -> None:
    """Without the other names nothing is changed, and both kinds can be mixed."""
    assert config_of(asked, TASK) == RecordConfig(tasks=(TASK,))
    mixed = config_of(asked, TASK, "--processes", "2", "--episodes", "3", "--image-size", "32", "32")
    assert (mixed.episodes, mixed.per_variation, mixed.tasks, asked["engine"]) == (3, False, (TASK,), 2)
    arguments = ["record", "a,b", "--seed=1", "--image-size", "8", "9"]
    assert spelled_out(arguments) == arguments


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--out", "here", "--save_path", "there"), "--out is here and --save_path is there, but both are the same setting"),
        (("--workers", "2", "--processes", "3"), "--workers is 2 and --processes is 3"),
        (("--arm_max_velocity", "0"), "max_velocity has to be a finite number > 0"),
        (("--renderer", "vulkan"), "opengl3"),
        (("--episodes_per_task", "0"), "episodes has to be a whole number"),
    ],
)
def test_contradictions_and_mistakes_are_explained(capsys: Capture, arguments: tuple[str, ...], words: str) -> None:
    """With exit code 2, and the names that were typed."""
    assert exit_code("record", TASK, *arguments) == 2
    captured = capsys.readouterr()
    assert words in captured.err + captured.out


def test_help_shows_them_together(capsys: Capture) -> None:
    """In a group of their own, with what they stand for."""
    assert exit_code("record", "--help") == 0
    shown = capsys.readouterr().out
    group = shown[shown.index("Flags of RLBench's generators") :]
    assert all(name in group for name in ("--tasks", "--save-path", "--processes", "--episodes-per-task", "--all-variations"))


@pytest.mark.simulation
def test_the_speed_of_the_arm_is_recorded_and_kept(tmp_path: Path, capsys: Capture) -> None:
    """A slower arm takes more frames; going on needs the folder alone."""
    frames = []
    for speed in ("1.0", "0.4"):
        out = tmp_path / speed
        plain = ("--products", "--processes", "0", "--save_path", str(out), "--json")
        assert exit_code("record", TASK, "--episodes", "1", "--arm_max_velocity", speed, *plain) == 0
        frames.append(len(read_demo(next(iter(episode_files(out, TASK))))))
        capsys.readouterr()
        assert exit_code("record", "--resume", *plain) == 0
        assert json.loads(capsys.readouterr().out)["found"] == 1
    assert frames[1] > 1.5 * frames[0]
