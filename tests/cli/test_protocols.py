"""`evaluate`, `record` and `list` with a protocol: what it fixes, what is refused, and the same test episodes in all of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.datasets import read_manifest, stored_demos
from rlbench_pin.environment import low_dim_config, make_environment
from rlbench_pin.evaluation import evaluation_seed, load_protocol, read_results
from rlbench_pin.recording.config import item_seed, read_recording
from tests.cli.support import exit_code
from tests.evaluation.protocols_for_tests import small_file


def test_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    """A line per protocol and part, with what is missing; JSON has all data."""
    assert exit_code("list", "--protocols") == 0
    lines = {line.split()[0]: line.split() for line in capsys.readouterr().out.splitlines()}
    assert lines["peract18"][:7] == ["peract18", "2", "18", "249", "450", "128x128", "25"]
    assert lines["gembench:L1"][2:5] == ["16", "31", "3100"]
    assert lines["gembench:L4"][2:5] == ["6", "12", "1200"] and "missing" not in lines["gembench:L4"]
    assert exit_code("list", "--protocols", "--json") == 0
    assert json.loads(capsys.readouterr().out)["peract18"] == load_protocol("peract18").record()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("evaluate", "noop", "--protocol", "peract8"), "Did you mean 'peract18'?"),
        (("evaluate", "noop", "--protocol", "colosseum", "--factors", "mass:1"), "`--factors mass:1` contradicts"),
        (("evaluate", "noop", "--protocol", "peract18", "--max-steps", "50"), "`--max-steps 50` contradicts"),
        (("evaluate", "noop", "--protocol", "peract18", "--tasks", "close_jar"), "`--tasks close_jar` contradicts"),
        (("evaluate", "noop", "--protocol", "peract18", "--tell-task"), "which has `--no-tell-task`"),
        (("evaluate", "noop", "--protocol", "agnostos", "--seed", "1"), "which has `--seed 0`"),
        (("record", "--protocol", "peract18", "--image-size", "64", "64"), "which has `--image-size 128 128`"),
        (("record", "close_jar", "--protocol", "peract18"), "`TASK... close_jar` contradicts"),
        (("record", "--protocol", "peract18", "--cameras", "overhead"), "`--cameras overhead` contradicts"),
        (("record", "--protocol", "peract18", "--split", "test", "--max-attempts", "2"), "which has `--max-attempts 1`"),
        (("record", "--protocol", "gembench:L2", "--split", "train"), "Use `--protocol gembench:L1`"),
        (("record", "--protocol", "gembench", "--split", "validation"), "Known: test, train"),
        (("record", "reach_target", "--split", "test"), "needs a protocol"),
    ],
)
def test_wrong_command_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str) -> None:
    """They are wrong usage; the message names value, what was possible, and the next step. Nothing is written."""
    assert exit_code(*words, "--out", str(tmp_path / "out")) == 2
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_evaluate_by_a_protocol(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Flags that agree are accepted; the file records the protocol, and `results` prints its table."""
    path, out = small_file(tmp_path), tmp_path / "results.json"
    words = ("evaluate", "noop", "--protocol", f"{path}:easy", "--workers", "0", "--out", str(out), "--policy-seed-key", "key")
    assert exit_code(*words, "--max-steps", "5", "--tasks", "reach_target", "--max-seconds", "20") == 0
    results = read_results(out)
    assert results.protocol == load_protocol(f"{path}:easy")
    assert (results.task_set, results.limits["max_steps"], results.limits["tell_task"]) == ("small:easy", 5, False)
    assert [(e.variation, e.seed) for e in results.episodes] == [
        (v, evaluation_seed(*at)) for v, at in ((0, (0, 0)), (2, (0, 1)), (0, (10, 0)), (2, (10, 1)))
    ]
    capsys.readouterr()
    assert exit_code("results", str(out)) == 0
    assert "Reach                           4    0.0 %             0.0" in capsys.readouterr().out
    assert exit_code(*words, "--resume") == 0
    changed = small_file(tmp_path, ("version = 1", "version = 2"))
    assert exit_code(*(f"{changed}:easy" if word == f"{path}:easy" else word for word in words), "--resume") == 1
    assert "another evaluation" in capsys.readouterr().err


def test_record_the_splits(tmp_path: Path) -> None:
    """`train` has recording seeds; `test` begins in the states of the evaluation; `--resume` needs the folder only."""
    path = small_file(tmp_path)
    train, test = tmp_path / "train", tmp_path / "test"
    assert exit_code("record", "--protocol", f"{path}:easy", "--products", "--workers", "0", "--out", str(train)) == 0
    entries = read_manifest(train, "reach_target")
    assert {(e.variation, e.episode, e.random_seed) for e in entries} == {
        (v, 0, item_seed(0, "reach_target", v, 0)) for v in range(3)
    }
    assert read_recording(train).images.cameras == ("front", "wrist")
    words = ("record", "--protocol", f"{path}:easy", "--split", "test", "--products", "--workers", "0", "--out", str(test))
    assert exit_code(*words) == 0
    assert exit_code("record", "--resume", "--workers", "0", "--out", str(test)) == 0
    demos = stored_demos(test, "reach_target", -1, -1, random_selection=False)
    assert sorted(demo.random_seed for demo in demos) == [evaluation_seed(*at) for at in ((0, 0), (0, 1), (10, 0), (10, 1))]
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("reach_target")
        for demo in demos:
            _, seen = task.reset(seed=demo.random_seed, variation=demo.variation_number)
            assert np.array_equal(seen.task_low_dim_state, demo[0].task_low_dim_state)
            assert np.array_equal(seen.joint_positions, demo[0].joint_positions)
