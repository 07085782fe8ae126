"""Profiles over factors: success at each level, paired with the same episodes without, and never averaged."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.errors import InvalidValue, ResultsFileError
from rlbench_pin.evaluation.results.plots import draw_profiles
from rlbench_pin.evaluation.results.profile import factor_profile, profile_table
from rlbench_pin.evaluation.results.records import Results, read_results, write_results
from tests.evaluation.results.made import episode, results

SETTINGS = ("light_color:1", "light_color:3", "damping:2")


def with_factors(policy: str = "noop") -> Results:
    """Return results of two tasks; one of them has no joints."""
    plain = results({"reach_target": "1110", "open_drawer": "1111"}, policy)
    outcomes = {"light_color:1": ("1110", "1111"), "light_color:3": ("0000", "1100"), "damping:2": ("", "1110")}
    reach, drawer = list(plain.of_task("reach_target")), list(plain.of_task("open_drawer"))
    for setting, (one, other) in outcomes.items():
        reach += [episode("reach_target", i, letter, factors=setting) for i, letter in enumerate(one)]
        drawer += [episode("open_drawer", i, letter, factors=setting) for i, letter in enumerate(other)]
    return replace(plain, episodes=(*reach, *drawer), factors=SETTINGS, trained_on="light_color:1")


def test_each_setting_is_paired_with_its_own_episodes() -> None:
    """A task that cannot take a factor is left out of both sides."""
    versions = {"reach_target": 1, "open_drawer": 2}
    profile = factor_profile(replace(with_factors(), task_versions=versions))
    assert profile.base.success.value == pytest.approx(7 / 8)
    same, strong, damping = profile.rows
    assert (same.setting, same.tasks, same.comparison.difference.value) == ("light_color:1", 2, 0.0)
    assert strong.summary.success.value == pytest.approx(0.25) and strong.comparison.difference.value == pytest.approx(-0.625)
    assert strong.comparison.pairs.only_first == 5 and strong.comparison.pairs.only_second == 0
    assert (damping.tasks, damping.base.success.value, damping.summary.success.value) == (1, 1.0, 0.75)


def test_the_table_has_a_row_for_each_setting_and_says_what_was_trained_on() -> None:
    """The first row is without factors."""
    text = profile_table(factor_profile(with_factors())).text()
    rows = [line.split()[0] for line in text.splitlines() if line]
    assert [rows.index(name) for name in ("none", *SETTINGS)] == sorted(rows.index(name) for name in ("none", *SETTINGS))
    assert "-62.5" in text and "light_color:1." in text


def test_files_keep_factors_and_are_read_again(tmp_path: Path) -> None:
    """Format 4; without factors the lower formats stay."""
    made = with_factors()
    path = write_results(tmp_path / "r.json", made)
    assert json.loads(path.read_text())["format"] == 4
    assert read_results(path) == made and made.of_factors("damping:2").tasks == ("open_drawer",)
    assert json.loads(write_results(tmp_path / "p.json", made.of_factors("")).read_text())["format"] == 1
    path.write_text(path.read_text().replace('"factors": "damping:2"', '"factors": "damping:1"', 1))
    with pytest.raises(ResultsFileError):
        read_results(path)


def test_results_without_factors_have_no_profile() -> None:
    """The error says how to make one."""
    with pytest.raises(InvalidValue, match="--factors"):
        factor_profile(results({"reach_target": "1"}))


def test_the_command_prints_and_draws_profiles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As text and as JSON; a file without factors beside it is refused."""
    path, plot = write_results(tmp_path / "r.json", with_factors()), tmp_path / "r.png"
    assert main(["results", str(path), "--plot", str(plot)]) == 0
    assert "light_color:3" in capsys.readouterr().out and plot.read_bytes()[:4] == b"\x89PNG"
    again = draw_profiles(tmp_path / "again.png", [factor_profile(with_factors())])
    assert again.read_bytes() == plot.read_bytes()
    assert main(["results", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["profiles"][0]
    assert [row["factors"] for row in found["factors"]] == list(SETTINGS) and found["trained_on"] == "light_color:1"
    plain = write_results(tmp_path / "p.json", with_factors().of_factors(""))
    assert main(["results", str(path), str(plain)]) == 2
    assert "without factors" in capsys.readouterr().err
