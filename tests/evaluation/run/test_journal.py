"""Finished episodes survive whatever kills their evaluation, and are used for no other."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rlbench_pin.evaluation.results.records import EpisodeRecord
from rlbench_pin.evaluation.run import EpisodeItem, EpisodeOutcome, EvaluationConfig, EvaluationConflict
from rlbench_pin.evaluation.run.evaluate import EpisodeJournal, evaluate, journal_path
from rlbench_pin.processes import SerialEngine, exclusive

HEAD = {"policy": "noop", "tasks": ("reach_target",), "limits": {"max_seconds": 1.0}}
ITEMS = [EpisodeItem("reach_target", "reach_target", i, 0, 2**53 + 2 * i, 5) for i in range(3)]


def outcome(item: EpisodeItem) -> EpisodeOutcome:
    """Some outcome, with numbers that are no round ones."""
    record = EpisodeRecord(
        task=item.name, variation=item.variation, seed=item.seed, success=False, lasts=False, steps=20, seconds=0.1 + 0.2,
        end="seconds", refused={"unreachable": 3}, collisions=2, max_force=1.0 / 3.0, violations={"joint velocity": 1},
    )  # fmt: skip
    return EpisodeOutcome(item, record, (0.001, 0.25))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A journal of two episodes."""
    path = tmp_path / "folder" / "x.journal.jsonl"
    journal = EpisodeJournal(path, HEAD, resume=False)
    for item in ITEMS[:2]:
        journal.add(outcome(item))
    return path


def test_what_is_added_is_found(path: Path) -> None:
    """To the last digit; what was not played is not."""
    journal = EpisodeJournal(path, HEAD, resume=True)
    assert journal.found(ITEMS) == [outcome(item) for item in ITEMS[:2]]


def test_a_line_that_was_being_written_is_cut_off(path: Path) -> None:
    """Wherever it ends: what is added next is a line of its own, and the episodes before it are whole."""
    whole = path.read_bytes()
    second = whole[: whole.rindex(b"\n", 0, -1) + 1]
    for length in range(len(second) + 1, len(whole), 7):
        path.write_bytes(whole[:length])
        journal = EpisodeJournal(path, HEAD, resume=True)
        assert journal.found(ITEMS) == [outcome(ITEMS[0])]
        journal.add(outcome(ITEMS[2]))
        journal = EpisodeJournal(path, HEAD, resume=True)
        assert journal.found(ITEMS) == [outcome(ITEMS[0]), outcome(ITEMS[2])]


def test_a_damaged_line_is_played_again(path: Path) -> None:
    """Neither text nor wrong values stop the others from being used."""
    head, first, second = path.read_text().splitlines()
    wrong = json.loads(first)
    wrong["record"]["steps"] = -1
    for line in ("]", "[]", "{}", '{"record": 3}', json.dumps(wrong), "\x00\x00"):
        path.write_text("\n".join((head, line, second)) + "\n")
        journal = EpisodeJournal(path, HEAD, resume=True)
        assert journal.found(ITEMS) == [outcome(ITEMS[1])]


def test_without_resume_it_must_not_be_there(path: Path) -> None:
    """The error says what to do, and the file stays."""
    before = path.read_bytes()
    with pytest.raises(EvaluationConflict, match="contains 2 episodes.*--resume"):
        EpisodeJournal(path, HEAD, resume=False)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"policy": "random"}, "policy = 'noop', but this evaluation has policy = 'random'"),
        ({"limits": {"max_seconds": 2.0}}, "max_seconds"),
        ({"tasks": ["reach_target", "push_button"]}, "push_button"),
        ({"task_files": {"x": "1"}}, "task_files = None"),
    ],
)
def test_it_is_of_one_evaluation(path: Path, change: dict[str, object], words: str) -> None:
    """Another policy, limit or task is another evaluation; the error names the first difference."""
    with pytest.raises(EvaluationConflict, match=words):
        EpisodeJournal(path, {**HEAD, **change}, resume=True)


def test_a_foreign_file_is_refused(path: Path) -> None:
    """It is not written to."""
    path.write_text("episode,success\n1,1\n")
    with pytest.raises(EvaluationConflict, match="is not a journal"):
        EpisodeJournal(path, HEAD, resume=True)
    assert path.read_text() == "episode,success\n1,1\n"


def test_two_evaluations_do_not_write_to_one_journal(tmp_path: Path) -> None:
    """The second is refused while the first one runs."""
    out = tmp_path / "x.json"
    config = EvaluationConfig(policy="random", tasks=("reach_target",), episodes=1)
    with exclusive(journal_path(out)), pytest.raises(EvaluationConflict, match="Another evaluation"):
        evaluate(config, out, engine=SerialEngine())
