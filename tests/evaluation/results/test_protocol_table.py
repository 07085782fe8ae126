"""Results of a protocol: its published table, and that unlike protocols do not mix."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import IncompatibleResults, InvalidValue, ResultsFileError
from rlbench_pin.evaluation import (
    Protocol,
    Results,
    compare,
    evaluation_seed,
    load_protocol,
    protocol_table,
    read_results,
    summarise_protocol,
    write_results,
)
from rlbench_pin.evaluation.protocols.plan import split_places
from tests.cli.support import exit_code
from tests.evaluation.protocols_for_tests import small_file
from tests.evaluation.results.made import episode, results


def made(protocol: Protocol, outcomes: str, policy: str = "noop") -> Results:
    """Return results by a protocol, an outcome per episode in order."""
    places = split_places(protocol, "test")
    letters = iter(outcomes)
    episodes = tuple(
        replace(episode(task, 0, next(letters)), variation=variation, seed=evaluation_seed(seed, number))
        for task, found in places.items()
        for variation, seed, number in found
    )
    test = protocol.split("test")
    seeds = tuple(evaluation_seed(seed, number) for seed in test.seeds for number in range(test.episodes))
    blank = results(dict.fromkeys(places, "1"), policy, policy_seed_key="key")
    return replace(blank, seeds=seeds, episodes=episodes, protocol=protocol, task_set=protocol.label)


def test_the_published_table(tmp_path: Path) -> None:
    """Names in its order, means of parts and over all, and the standard error over repetitions."""
    summary = summarise_protocol(made(load_protocol(small_file(tmp_path)), "11100100"))
    assert [(row.title, row.episodes, row.success) for row in summary.rows] == [("Reach", 4, 0.75), ("push_button", 4, 0.25)]
    assert [row.standard_error for row in summary.rows] == [0.25, 0.25]
    assert [(row.title, row.success) for row in summary.means] == [
        ("mean over tasks of easy", 0.75), ("mean over tasks of hard", 0.25), ("mean over tasks", 0.5),
    ]  # fmt: skip
    assert summary.means[-1].standard_error == pytest.approx(np.std([0.75, 0.25], ddof=1) / math.sqrt(2))
    text = protocol_table(summary).text()
    assert f"protocol small, version 1, {summary.protocol.sha256[:12]}" in text
    assert "do not compare these numbers with published ones" in text
    each = load_protocol(small_file(tmp_path, ('"task"\n', '"variation"\n'), ("seeds = [0, 10]", "seeds = [0]")))
    summary = summarise_protocol(made(each.of_part("hard"), "1000"))
    assert [row.title for row in (*summary.rows, *summary.means)] == [
        "push_button+4", "push_button+9", "mean over variations of hard",
    ]  # fmt: skip
    assert summary.rows[0].standard_error is None
    with pytest.raises(InvalidValue, match="without a protocol"):
        summarise_protocol(results({"reach_target": "1"}))


def test_the_file_records_the_protocol(tmp_path: Path) -> None:
    """Format 3 has name, version, SHA-256 and content; a file without a protocol is as before."""
    protocol = load_protocol(small_file(tmp_path)).of_part("easy")
    path = write_results(tmp_path / "easy.json", made(protocol, "1111"))
    content = json.loads(path.read_text())
    assert content["format"] == 3
    assert {name: content["protocol"][name] for name in ("name", "part", "version", "sha256")} == {
        "name": "small", "part": "easy", "version": 1, "sha256": protocol.sha256,
    }  # fmt: skip
    assert read_results(path).protocol == protocol
    assert "protocol" not in results({"reach_target": "1"}, policy_seed_key="key").content()
    content["protocol"]["version"] = 2
    path.write_text(json.dumps(content))
    with pytest.raises(ResultsFileError, match="contradicts its content"):
        read_results(path)


@pytest.mark.parametrize("change", [("version = 1", "version = 2"), ("max_steps = 5", "max_steps = 6")])
def test_unlike_protocols_do_not_mix(tmp_path: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str]) -> None:
    """Another version, other content, or no protocol at all: the error names both; parts of one protocol go together."""
    one, other = (load_protocol(small_file(tmp_path, *changes)) for changes in ((), (change,)))
    first, second = (made(protocol, "11100100") for protocol in (one, other))
    with pytest.raises(IncompatibleResults, match="protocol small version 1 .* against small version"):
        compare(first, second, np.random.default_rng(0))
    paths = [str(write_results(tmp_path / f"{i}.json", r)) for i, r in enumerate((first, second, replace(first, protocol=None)))]
    assert exit_code("results", paths[0], paths[1]) == 1
    assert "against small version" in capsys.readouterr().err
    assert exit_code("results", paths[0], paths[2]) == 1
    assert "against none" in capsys.readouterr().err
    later = replace(first, task_versions=dict.fromkeys(first.tasks, 2))
    assert exit_code("results", paths[0], str(write_results(tmp_path / "later.json", later))) == 1
    assert "has version 1 in the first and 2 in the second" in capsys.readouterr().err
    part = str(write_results(tmp_path / "part.json", made(one.of_part("easy"), "1111")))
    assert exit_code("results", paths[0], part) == 0
    assert "mean over tasks of easy" in capsys.readouterr().out
    assert exit_code("results", paths[0], "--json") == 0
    assert json.loads(capsys.readouterr().out)["results"][0]["protocol"]["means"][-1]["success"] == 0.5
