"""A run of the challenge: its parts, its files, its interruptions, and learners that fail."""

from __future__ import annotations

import json
import shutil
import threading
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.environment.episode import EVALUATION_SEEDS
from rlbench_pin.errors import InvalidValue, UnknownName
from rlbench_pin.evaluation import (
    ChallengeConfig,
    ChallengeConflict,
    ChallengeProgress,
    ChallengeStopped,
    PolicyContext,
    PolicyFault,
    PolicyReferenceError,
    find_learner,
    read_results,
    run_challenge,
)
from rlbench_pin.evaluation.challenge.client import LearnerClient, batches
from rlbench_pin.evaluation.challenge.config import demonstration_seed
from rlbench_pin.evaluation.challenge.demonstrations import shown_variation
from rlbench_pin.evaluation.challenge.learner import read_learned, write_learned
from rlbench_pin.evaluation.challenge.learner_process import LearnerAnswers
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.processes import ProcessEngine, SerialEngine
from tests.evaluation.challenge.learners import Still

LEARNERS = Path(__file__).with_name("learners.py")
CONFIG = ChallengeConfig(
    learner=f"{LEARNERS}:Still", split="FS10_V1", shots=(2, 1), only=("unplug_charger",), episodes=2, max_seconds=2.0,
)  # fmt: skip

OBSERVATION = Observation(joint_positions=np.zeros(7), gripper_open=1.0)
LEARNED = {"tasks": ["a", "b"], "weights": np.full((2, 2), 0.5)}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that was stopped on the way and went on."""
    folder, stop, seen = tmp_path_factory.mktemp("run"), threading.Event(), list[ChallengeProgress]()

    def watch(progress: ChallengeProgress) -> None:
        seen.append(progress)
        if progress.stage == "1 shot" and progress.done == 1:
            stop.set()

    with pytest.raises(ChallengeStopped, match="--resume"):
        run_challenge(CONFIG, folder, engine=SerialEngine(), on_progress=watch, stop=stop)
    with pytest.raises(ChallengeConflict, match="--resume"):
        run_challenge(CONFIG, folder, engine=SerialEngine())
    run_challenge(CONFIG, folder, engine=SerialEngine(), resume=True)
    assert list(dict.fromkeys(p.stage for p in seen)) == ["practising", "demonstrations", "1 shot"]
    return folder


@pytest.mark.simulation
def test_a_run_leaves_a_file_for_each_number_of_demonstrations(made: Path) -> None:
    """Results with the learner's name, the split, and without the task being told; a curve; demonstrations with their seeds."""
    for shots, label in ((1, "1 shot"), (2, "2 shots")):
        results = read_results(made / f"shots_{shots}.json")
        assert results.policy == f"{CONFIG.learner}, {label}"
        assert results.task_set == "challenge FS10_V1"
        assert results.limits["tell_task"] is False
        assert len(results.episodes) == 2
        assert [e.fault_detail for e in results.episodes] == ["", ""]
        assert [e.steps for e in results.episodes] == [5, 5]
    curve = json.loads((made / "summary.json").read_text())
    assert [point["shots"] for point in curve["points"]] == [1, 2]
    assert curve["points"][0]["results_sha256"] == read_results(made / "shots_1.json").sha256
    lines = (made / "demonstrations" / "unplug_charger" / "demonstrations.jsonl").read_text().splitlines()
    seeds = [json.loads(line)["seed"] for line in lines]
    assert seeds == [demonstration_seed(0, "unplug_charger", i) for i in range(2)]
    assert all(seed < EVALUATION_SEEDS for seed in seeds)


@pytest.mark.slow
@pytest.mark.simulation
def test_the_same_run_elsewhere_writes_the_same_bytes(made: Path, tmp_path: Path) -> None:
    """By two processes, without a stop; another run is refused where this one lies."""
    run_challenge(CONFIG, tmp_path, engine=ProcessEngine(2))
    for name in ("shots_1.json", "shots_2.json", "summary.json"):
        assert (tmp_path / name).read_bytes() == (made / name).read_bytes()
    with pytest.raises(ChallengeConflict, match="seed = 0, but this run has seed = 1"):
        run_challenge(replace(CONFIG, seed=1), tmp_path, engine=SerialEngine(), resume=True)


@pytest.mark.parametrize(
    ("fault", "kind", "says"),
    [("adapt", "crashed", "nothing to learn"), ("exit", "crashed", "exit code 3"), ("hang", "timed out", "longer than 1 s")],
)
def test_faults_have_names(fault: str, kind: str, says: str) -> None:
    """A failure to adapt is that of every episode of the task, and is not waited for again."""
    context = PolicyContext("panda", 8, (-1.0,) * 8, (1.0,) * 8, control_period=0.05, max_steps=3, seed=0)
    with closing(LearnerClient(still(fault), 0, time_limit=1.0, start_limit=100.0, adapt_limit=10.0)) as learner:
        learner.show(lambda: iter([Demo([OBSERVATION], instructions=["Do it."])]), LEARNED)
        for _ in range(2 if fault == "adapt" else 1):
            with pytest.raises(PolicyFault, match=says) as caught:
                learner.reset("Do it.", context)
                learner.act(OBSERVATION)
            assert caught.value.kind == kind


@pytest.mark.parametrize(
    ("fault", "says"), [("no policy", "which is not a policy"), ("other", "the observations of its learner")]
)
def test_what_adapt_must_return(fault: str, says: str) -> None:
    """A policy, with the action mode and the observations of its learner."""
    answers = LearnerAnswers(lambda: Still(fault))
    assert answers.to({"call": "act"})["kind"] == "wrong question"
    assert answers.to({"call": "recall", "learned": LEARNED}) == {"ok": None}
    frames = [{"joint_positions": np.zeros(7), "misc": {}}]
    shown = {"call": "frames", "demonstration": 0, "instructions": ["Do it."], "observations": frames}
    assert answers.to(shown) == {"ok": None}
    answer = answers.to({"call": "adapt"})
    assert answer["kind"] == "wrong answer"
    assert says in answer["error"]


def still(fault: str) -> str:
    """Return the reference of a learner with a fault."""
    return f"{LEARNERS}:Still?fault={fault.replace(' ', '%20')}"


@pytest.mark.slow
@pytest.mark.simulation
def test_a_learner_that_fails_costs_its_episodes(made: Path, tmp_path: Path) -> None:
    """Named, and nothing else: the run goes on to its end."""
    shutil.copytree(made / "demonstrations", tmp_path / "demonstrations")
    run_challenge(replace(CONFIG, learner=still("exit"), shots=(1,)), tmp_path, engine=SerialEngine())
    episodes = read_results(tmp_path / "shots_1.json").episodes
    assert [e.fault for e in episodes] == ["crashed", "crashed"]
    assert all("exit code 3" in e.fault_detail for e in episodes)


@pytest.mark.slow
@pytest.mark.parametrize(("fault", "says"), [("train", "nothing to practise"), ("pictures", "'all' or 'first'")])
def test_a_learner_that_fails_before_the_test(fault: str, says: str, tmp_path: Path) -> None:
    """There is nothing to test then."""
    with pytest.raises(PolicyFault, match=says):
        run_challenge(replace(CONFIG, learner=still(fault)), tmp_path, engine=SerialEngine())


def test_long_demonstrations_go_in_several_messages() -> None:
    """Each below the limit, all frames in order."""
    frames = [{"number": i, "front_rgb": np.zeros((1024, 1024, 3 * 12), dtype=np.uint8)} for i in range(5)]
    assert [[frame["number"] for frame in batch] for batch in batches(frames)] == [[0, 1], [2, 3], [4]]
    assert list(batches([])) == []


@pytest.mark.parametrize(("reference", "error"), [
    ("nearst", UnknownName), ("noop", UnknownName), ("", PolicyReferenceError), ("missing.py:make", PolicyReferenceError),
    ("tcp://127.0.0.1:5555", PolicyReferenceError), (f"{LEARNERS}:Stil", PolicyReferenceError),
])  # fmt: skip
def test_references_that_lead_to_no_learner(reference: str, error: type[Exception]) -> None:
    """Said before anything runs."""
    with pytest.raises(error):
        find_learner(reference)


@pytest.mark.parametrize("change", [
    {"shots": ()}, {"shots": (0,)}, {"only": ("reach_target",)}, {"episodes": 0}, {"train_limit": 0.0}, {"split": "V2"},
])  # fmt: skip
def test_settings_that_make_no_sense(change: dict[str, object]) -> None:
    """Are refused when they are made."""
    with pytest.raises((InvalidValue, UnknownName)):
        replace(CONFIG, **change)  # type: ignore[arg-type]


def test_variations_come_once_before_any_comes_again() -> None:
    """In an order that the seed draws."""
    shown = [shown_variation(3, 5, index) for index in range(10)]
    assert sorted(shown[:5]) == sorted(shown[5:]) == list(range(5))
    assert shown != [shown_variation(4, 5, index) for index in range(10)]


def test_what_was_learned_is_kept(tmp_path: Path) -> None:
    """Nothing, or plain data; a damaged file is named."""
    path = tmp_path / "learned.msgpack"
    assert read_learned(path) is None
    write_learned(path, None)
    assert read_learned(path) is None
    write_learned(path, {"a": [1, "x"]})
    assert read_learned(path) == {"a": [1, "x"]}
    path.write_bytes(b"xxxxyyyy")
    with pytest.raises(ChallengeConflict, match="damaged"):
        read_learned(path)
