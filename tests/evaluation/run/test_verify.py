"""A results file is verified: its episodes, played again, give the same records to the byte; any other record is reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation import (
    EvaluationConfig,
    EvaluationProgress,
    Results,
    Verification,
    VerificationRefused,
    evaluate,
    load_protocol,
    read_results,
    verify_results,
    write_results,
)
from rlbench_pin.evaluation.protocols import ProtocolConflict
from rlbench_pin.processes import SerialEngine
from tests.evaluation.protocols_for_tests import small_file
from tests.evaluation.run import policies

pytestmark = pytest.mark.simulation

CONFIG = EvaluationConfig(policy="random", tasks=("reach_target", "push_button"), episodes=2, max_seconds=0.5)
STILL = replace(CONFIG, policy=f"{policies.__file__}:Still", tasks=("reach_target",), episodes=1, policy_seed_key="k")
"""One episode of a policy that holds still: with this key it does nothing else."""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A results file of four episodes."""
    out = tmp_path_factory.mktemp("made") / "results.json"
    evaluate(CONFIG, out, engine=SerialEngine())
    return out


def verified(results: Results, share: float = 1.0, **settings: Any) -> Verification:
    """Verify results in this process."""
    return verify_results(results, share, np.random.default_rng(0), engine=SerialEngine(), **settings)


def test_the_same_episodes_are_verified(made: Path) -> None:
    """All of them or a part, with progress; deaths of workers are not compared."""
    results, seen = read_results(made), list[EvaluationProgress]()
    assert results.task_versions == {"push_button": 1, "reach_target": 1}
    died = replace(results, episodes=(replace(results.episodes[0], worker_deaths=1), *results.episodes[1:]))
    assert verified(died, on_progress=seen.append) == Verification(4, 4, (), ())
    assert [(p.wanted, p.done) for p in seen] == [(4, n) for n in range(5)]
    assert verified(results, 0.3).played == 2 and verified(results, 1e-9).played == 1
    with pytest.raises(InvalidValue, match="share"):
        verified(results, 0.0)


def test_another_record_is_reported(made: Path) -> None:
    """With both records, the fields that differ, and what else differs between the file and this run."""
    results = read_results(made)
    first = results.episodes[0]
    better = replace(first, steps=first.steps - 1, success=True, end="success")
    found = verified(replace(results, episodes=(better, *results.episodes[1:]), versions={"numpy": "1.0"}, commit="abc"))
    (difference,) = found.differences
    assert (difference.recorded, difference.played) == (better, first)
    assert difference.fields == ("success", "steps", "end")
    assert "numpy 1.0" in found.remarks[0] and "abc" in found.remarks[1]
    keyless = verified(replace(results, policy_seed_key=""))
    assert keyless.differences and "no key of the policy's seeds" in keyless.remarks[-1]


def test_what_cannot_be_verified_is_refused(made: Path) -> None:
    """Before anything is played, with the reason and the next step."""
    results = read_results(made)
    versions = {"reach_target": 2, "push_button": 1}
    cases: list[tuple[Results, str, str]] = [
        (replace(results, policy="evil.py:make"), "", "their policy is code.*name it with `--policy`"),
        (replace(results, limits={"episodes": 2}), "", "their limits lack seed, max_steps"),
        (replace(results, task_versions=versions), "", "version 2 in the file, but version 1 is installed"),
        (replace(results, settings={"observation": {}}), "", "the policy has .*Name the policy that was evaluated"),
        (
            replace(results, episodes=results.episodes[1:]),
            "",
            "they lack 1 episodes of their settings, such as reach_target",
        ),
        (replace(results, limits={**results.limits, "episodes": 1}), "", "they have 2 episodes that are not in their settings"),
    ]
    for wrong, policy, says in cases:
        with pytest.raises(VerificationRefused, match=says) as raised:
            verified(wrong, policy=policy)
        assert raised.value.policy == wrong.policy and raised.value.problem in str(raised.value)


def test_a_policy_of_the_user_plays(tmp_path: Path) -> None:
    """One that the file only names is not run; the user's is, when it asks for the same."""
    results = evaluate(STILL, tmp_path / "x.json", engine=SerialEngine())
    with pytest.raises(VerificationRefused, match="their policy is code"):
        verified(results)
    assert verified(results, policy=STILL.policy).differences == ()
    with pytest.raises(VerificationRefused, match="but the policy of the results has"):
        verified(results, policy="expert")


def test_results_of_a_protocol_are_verified(tmp_path: Path) -> None:
    """Its episodes are those of the protocol; a policy that does not follow it is refused."""
    protocol = load_protocol(f"{small_file(tmp_path)}:easy")
    results = evaluate(EvaluationConfig.of_protocol("noop", protocol), tmp_path / "x.json", engine=SerialEngine())
    assert verified(results, 0.3) == Verification(2, 4, (), ())
    still = evaluate(STILL, tmp_path / "y.json", engine=SerialEngine())
    with pytest.raises(ProtocolConflict):
        verified(replace(results, settings=still.settings), policy=STILL.policy)


def test_the_command(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """0 and one line where all is as recorded; 1 and a line for each episode that differs; 2 for a share that is none."""
    words = ("results", "verify", str(made), "--sample", "100%", "--workers", "0")
    assert main(words) == 0
    assert capsys.readouterr().out == f"{made}: 4 of 4 episodes played again, none of them differ from the file.\n"
    results = read_results(made)
    last = results.episodes[-1]
    changed = replace(results, episodes=(*results.episodes[:-1], replace(last, collisions=99)))
    path = write_results(tmp_path / "changed.json", changed)
    assert main(("results", "verify", str(path), "--sample", "100%", "--workers", "0")) == 1
    out = capsys.readouterr().out
    assert f"push_button, variation {last.variation}, seed {last.seed}: collisions 99 in the file, 0 now\n" in out
    assert "4 of 4 episodes played again, 1 of them differs from the file." in out
    for share in ("5", "0%", "101%", "-5%", "all"):
        assert main(("results", "verify", str(made), f"--sample={share}")) == 2
        assert "Use a percentage above 0" in capsys.readouterr().err
    assert main(("results", "verify", str(tmp_path / "none.json"))) == 1
