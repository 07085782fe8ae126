"""What a learner is given leads neither to the task, nor to the scene, nor to the seed of a test episode."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.errors import InvalidArgument
from rlbench_pin.evaluation import (
    ChallengeConfig,
    ChallengeConflict,
    PolicySettingsError,
    evaluation_seed,
    learning_curve,
    read_secret,
    run_challenge,
)
from rlbench_pin.evaluation.challenge.client import validate_settings
from rlbench_pin.evaluation.challenge.config import demonstration_seed
from rlbench_pin.evaluation.challenge.demonstrations import ShownDemonstrations
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.processes import SerialEngine
from tests.evaluation.challenge.learners import Still

SPY, LEARNERS = (Path(__file__).with_name(name) for name in ("spy.py", "learners.py"))


@pytest.mark.simulation
def test_thirteen_ways_lead_nowhere(tmp_path: Path) -> None:
    """Each of the ways that a spy tries finds nothing, while it does get its demonstrations and the instruction."""
    report = tmp_path / "spy" / "report.json"
    report.parent.mkdir()
    config = ChallengeConfig(
        learner=f"{SPY}:Spy?report={report}", split="FS10_V1", shots=(2,), only=("unplug_charger",), episodes=2,
        seed=1,
    )  # fmt: skip
    curve = run_challenge(config, tmp_path / "run", engine=SerialEngine())
    found = json.loads(report.read_text())
    ways = {name: value for name, value in found.items() if name[0].isdigit()}
    assert len(ways) == 13
    assert {name: value for name, value in ways.items() if value} == {}
    assert found["demonstrations"] == 2
    assert found["instruction"]
    assert curve.points[0].summary.tasks[0].faults == {}


@pytest.mark.parametrize("asked", ["masks", "state", "distances"])
def test_what_is_withheld_cannot_be_asked_for(asked: str) -> None:
    """Masks, the state of the task and distances to the scene."""
    learner = Still(asked)
    with pytest.raises(PolicySettingsError, match="is withheld in the challenge"):
        validate_settings(PolicySettings.of(learner.action_mode, learner.obs_config))


@pytest.mark.slow
def test_it_is_refused_before_anything_is_played(tmp_path: Path) -> None:
    """Nothing is made then."""
    config = ChallengeConfig(learner=f"{LEARNERS}:Still?fault=masks", split="FS10_V1", shots=(1,))
    with pytest.raises(PolicySettingsError, match="is withheld in the challenge"):
        run_challenge(config, tmp_path, engine=SerialEngine())
    assert sorted(path.name for path in tmp_path.iterdir() if not path.name.startswith(".")) == ["challenge.json"]


SECRET = b"0123456789abcdef"


def test_a_secret_draws_other_seeds_and_is_never_written(tmp_path: Path) -> None:
    """Demonstrations and episodes follow from its keyed hash; who has the secret can compute it, others see the SHA-256."""
    plain = ChallengeConfig(learner="nearest", split="FS10_V1", shots=(1,), only=("unplug_charger",), seed=3)
    secret = replace(plain, secret=SECRET)
    assert (plain.drawing_seed, plain.secret_sha256) == (3, "")
    assert plain.evaluation(1).task_set == "challenge FS10_V1"
    assert secret.drawing_seed == 0xA00CBD7C577D
    assert secret.drawing_seed != replace(secret, seed=4).drawing_seed != replace(secret, secret=SECRET[::-1]).drawing_seed
    assert secret.evaluation(1).seeds()[0] == evaluation_seed(secret.drawing_seed, 0)
    digest = hashlib.sha256(SECRET).hexdigest()
    assert secret.secret_sha256 == digest
    assert secret.evaluation(1).task_set == f"challenge FS10_V1, secret sha256:{digest}"
    assert "abcdef" not in repr(secret)
    seeds = [{item.seed for item in ShownDemonstrations(tmp_path).missing(config)} for config in (plain, secret)]
    assert seeds[0] == {demonstration_seed(3, "unplug_charger", 0)} != seeds[1]
    for config, known in ((plain, {}), (secret, {"secret_sha256": digest})):
        content = learning_curve("nearest", "FS10_V1", {}, config.secret_sha256).content()
        assert {name: value for name, value in content.items() if "secret" in name} == known


def test_files_of_secrets(tmp_path: Path) -> None:
    """All bytes count; a file that is missing, or that could be guessed, is refused."""
    path = tmp_path / "secret"
    with pytest.raises(InvalidArgument, match="cannot be read"):
        read_secret(path)
    path.write_bytes(b"short")
    with pytest.raises(InvalidArgument, match="16 to"):
        read_secret(path)
    path.write_bytes(SECRET + b"\n")
    assert read_secret(path) == SECRET + b"\n"


@pytest.mark.parametrize("name", ["challenge.json", "demonstrations", "shots_1.json", ".recording.lock"])
def test_links_in_the_folder_of_a_run_are_refused(name: str, tmp_path: Path) -> None:
    """Nothing is written through them."""
    folder, elsewhere = tmp_path / "run", tmp_path / "elsewhere"
    folder.mkdir()
    (folder / name).symlink_to(elsewhere)
    config = ChallengeConfig(learner="nearest", split="FS10_V1", shots=(1,), only=("unplug_charger",))
    with pytest.raises(ChallengeConflict, match="is a link"):
        run_challenge(config, folder, engine=SerialEngine(), resume=True)
    assert not elsewhere.exists()
    assert [path.name for path in folder.iterdir()] == [name]
