"""`rlbench-pin train` as a user types it: what it writes, what it refuses, and how it goes on."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("torch")
pytest.importorskip("safetensors")
pytest.importorskip("tensorboard")

from rlbench_pin.baselines.cloning import policy
from rlbench_pin.datasets import DatasetWriter
from tests.baselines.demos_that_reach import gliding_demo
from tests.cli.support import exit_code

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A dataset of two demonstrations."""
    for seed in range(2):
        DatasetWriter(tmp_path / "data", compression="lzf").add(gliding_demo(seed))
    return tmp_path / "data"


def test_it_trains_once_and_says_what_the_policy_is_called(data: Path, tmp_path: Path, capsys: Capture) -> None:
    """A model per task, curves beside it; the same folder again only with --resume, which finds nothing left to do."""
    words = ("train", "cloning", str(data), "--out", str(tmp_path / "m"), "--steps", "20", "--demos", "1")
    assert exit_code(*words) == 0
    assert f"cloning:policy?folder={tmp_path / 'm'}" in capsys.readouterr().out
    assert list((tmp_path / "m" / "reach_target" / "curves").glob("events*"))
    assert policy(str(tmp_path / "m")).action_mode is not None
    before = (tmp_path / "m" / "reach_target" / "model.safetensors").read_bytes()
    assert exit_code(*words) == 2
    assert "--resume" in capsys.readouterr().err
    assert exit_code(*words, "--resume") == 0
    assert (tmp_path / "m" / "reach_target" / "model.safetensors").read_bytes() == before


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("cloning",), "No dataset"),
        (("cloning", "DATA", "--steps", "0"), "--steps"),
        (("cloning", "DATA", "--demos", "0"), "--demos"),
        (("cloning", "DATA", "--demos", "7"), "7 demos"),
        (("cloning", "DATA", "--tasks", "reach_targt"), "reach_target"),
        (("cloning", "nowhere"), "does not exist"),
        (("key-frames", "DATA", "--cameras", "front"), "--cameras"),
    ],
)
def test_misuse_is_named(words: tuple[str, ...], hint: str, data: Path, tmp_path: Path, capsys: Capture) -> None:
    """What is missing or wrong, and nothing is written."""
    typed = [str(data) if word == "DATA" else word for word in words]
    assert exit_code("train", *typed, "--out", str(tmp_path / "m")) in (1, 2)
    assert hint in capsys.readouterr().err
    assert not (tmp_path / "m").exists()
