"""What a learner is given leads neither to the task, nor to the scene, nor to the seed of a test episode."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rlbench_pin.evaluation import ChallengeConfig, PolicySettingsError, run_challenge
from rlbench_pin.evaluation.challenge.confinement import beside, can_confine
from rlbench_pin.evaluation.challenge.withheld import check_settings
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.processes import SerialEngine
from tests.evaluation.challenge.learners import Still

SPY, LEARNERS = (Path(__file__).with_name(name) for name in ("spy.py", "learners.py"))


@pytest.mark.simulation
def test_fifteen_ways_lead_nowhere(tmp_path: Path) -> None:
    """Each of the ways that a spy tries finds nothing, while it does get its demonstrations and the instruction."""
    report = tmp_path / "spy" / "report.json"
    report.parent.mkdir()
    config = ChallengeConfig(
        learner=f"{SPY}:Spy?report={report}", split="FS10_V1", shots=(2,), only=("unplug_charger",), episodes=2, available=True,
        seed=1,
    )  # fmt: skip
    curve = run_challenge(config, tmp_path / "run", engine=SerialEngine())
    found = json.loads(report.read_text())
    ways = {name: value for name, value in found.items() if name[0].isdigit()}
    assert len(ways) == 15
    if not can_confine():
        ways = {name: value for name, value in ways.items() if not name.startswith(("12", "13"))}
    assert {name: value for name, value in ways.items() if value} == {}
    assert found["demonstrations"] == 2
    assert found["instruction"]
    assert curve.points[0].summary.tasks[0].faults == {}


@pytest.mark.parametrize("asked", ["masks", "state", "distances"])
def test_what_is_withheld_cannot_be_asked_for(asked: str) -> None:
    """Masks, the state of the task and distances to the scene."""
    learner = Still(asked)
    with pytest.raises(PolicySettingsError, match="is withheld in the challenge"):
        check_settings(PolicySettings.of(learner.action_mode, learner.obs_config))


@pytest.mark.slow
def test_it_is_refused_before_anything_is_played(tmp_path: Path) -> None:
    """Nothing is made then."""
    config = ChallengeConfig(learner=f"{LEARNERS}:Still?fault=masks", split="FS10_V1", shots=(1,), available=True)
    with pytest.raises(PolicySettingsError, match="is withheld in the challenge"):
        run_challenge(config, tmp_path, engine=SerialEngine())
    assert sorted(path.name for path in tmp_path.iterdir() if not path.name.startswith(".")) == ["challenge.json"]


def test_what_lies_beside_a_folder(tmp_path: Path) -> None:
    """All but what leads to it; links are left out."""
    for name in ("out/run", "out/other", "models"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "out" / "run")
    found = {path for path in beside(tmp_path / "out" / "run") if path.is_relative_to(tmp_path)}
    assert found == {tmp_path / "out" / "other", tmp_path / "models"}
