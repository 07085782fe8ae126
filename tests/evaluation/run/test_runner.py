"""One episode after the other: how each ends, what is counted, and policies that misbehave."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaPlanning,
    Environment,
    JointPosition,
    MoveArmThenGripper,
    TaskEnvironment,
)
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.evaluation.policies import PolicyReferenceError, open_policy
from rlbench_pin.evaluation.results.records import EpisodeRecord
from rlbench_pin.evaluation.run import EpisodeOutcome, EpisodeRunner, EvaluationConfig, plan_episodes, runner
from rlbench_pin.evaluation.run.episode import KEY_FRAMES, LONGEST_DETAIL, shortened
from tests.evaluation.run import policies

pytestmark = pytest.mark.simulation

FILE = Path(policies.__file__)
CONFIG = EvaluationConfig(policy="noop", tasks=("reach_target",), episodes=2, max_seconds=1.0)


def outcomes(config: EvaluationConfig) -> list[EpisodeOutcome]:
    """Play all episodes here."""
    with EpisodeRunner(config) as worker:
        return [worker.make(item) for item in plan_episodes(config)]


def test_seconds_end_an_episode() -> None:
    """Holding still for a second is twenty steps, and one answer of the policy for each."""
    for outcome in outcomes(CONFIG):
        record = outcome.record
        assert (record.end, record.steps, record.seconds, record.success) == ("seconds", 20, 1.0, False)
        assert len(outcome.action_times) == 20


def test_slow_arms_have_more_seconds() -> None:
    """The joints of the Jaco are 3.46 times slower than those of the Panda."""
    (outcome,) = outcomes(replace(CONFIG, episodes=1, robot="jaco"))
    assert (outcome.record.end, outcome.record.steps) == ("seconds", 70)


def test_steps_end_an_episode() -> None:
    """Those that the user asks for."""
    assert [(o.record.end, o.record.steps) for o in outcomes(replace(CONFIG, max_steps=3))] == [("steps", 3)] * 2


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the policies of the tests in this process: quicker, and nothing can end them."""
    made = {"Still": policies.Still, "Poses": policies.Poses}
    monkeypatch.setattr(runner, "open_policy", lambda reference, **limits: open_policy(made[reference]()))


@pytest.mark.usefixtures("here")
def test_refused_actions_are_counted_by_cause_and_never_go_on_forever() -> None:
    """An arm that is asked for what it cannot reach stays where it is, for the 25 actions that planned poses have."""
    config = replace(CONFIG, policy="Poses", episodes=1, max_seconds=120.0)
    (outcome,) = outcomes(config)
    assert outcome.record.end == "steps"
    assert outcome.record.refused == {"outside the workspace": KEY_FRAMES}
    assert (outcome.record.steps, outcome.record.seconds) == (KEY_FRAMES, 0.0)


def test_refusals_say_why_in_fixed_words() -> None:
    """The kind of fault, the same for all actions that have it; of a motion that is not found, the planner's reason."""
    planned, joints = (
        MoveArmThenGripper(arm, Discrete()) for arm in (EndEffectorPoseViaPlanning(collision_checking=True), JointPosition())
    )
    down, far = [0.3, 0.0, 0.9, 0.0, 1.0, 0.0, 0.0, 1.0], [0.7, 0.6, 1.7, 0.0, 1.0, 0.0, 0.0, 1.0]
    refused = {
        "outside the workspace": (planned, [9.0, *down[1:]]),
        "not a rotation": (planned, [*down[:4], 3.0, 0.0, 0.0, 1.0]),
        "unreachable": (planned, far),
        "gripper out of range": (joints, [0.0] * 7 + [1.5]),
        "wrong shape": (joints, [0.0] * 5),
        "not finite": (joints, [float("nan")] * 8),
    }
    for cause, (mode, action) in refused.items():
        with Environment(mode, obs_config=low_dim_config(), seed=0) as environment:
            task = environment.get_task("reach_target")
            task.reset(seed=1)
            with pytest.raises(InvalidActionError) as caught:
                task.step(action)
        assert caught.value.cause == cause


@pytest.mark.usefixtures("here")
def test_refused_actions_use_up_time() -> None:
    """Each counts as one control tick, where steps are not limited."""
    config = replace(CONFIG, policy="Poses", episodes=1, max_steps=1000, max_seconds=2.0)
    (outcome,) = outcomes(config)
    assert (outcome.record.end, outcome.record.steps, outcome.record.seconds) == ("seconds", 40, 0.0)


def test_the_expert_succeeds_and_is_judged_like_the_others() -> None:
    """Its demonstration reaches the goal, which lasts; where time is short it fails like anybody."""
    for outcome in outcomes(replace(CONFIG, policy="expert", max_seconds=60.0)):
        record = outcome.record
        assert (record.success, record.lasts, record.end, record.collisions, record.violations) == (True, True, "success", 0, {})
        assert record.steps == round(record.seconds / 0.05) > 20
    late = [outcome.record.end for outcome in outcomes(replace(CONFIG, policy="expert"))]
    assert late == ["seconds"] * 2


def play(config: EvaluationConfig, faults: tuple[str, ...]) -> list[EpisodeRecord]:
    """Play an episode for each fault; those without a name go well, which is checked."""
    items = plan_episodes(replace(config, episodes=len(faults)))
    told = [replace(i, policy_seed=policies.FAULTS.index(f)) for i, f in zip(items, faults, strict=True)]
    with EpisodeRunner(config) as worker:
        records = [worker.make(item).record for item in told]
    good = [record for fault, record in zip(faults, records, strict=True) if not fault]
    assert [(record.end, record.fault, record.steps) for record in good] == [("seconds", "", 20)] * len(good)
    bad = [record for fault, record in zip(faults, records, strict=True) if fault]
    assert [(record.end, record.success, record.seconds) for record in bad] == [("fault", False, 0.05)] * len(bad)
    return bad


@pytest.mark.usefixtures("here")
def test_wrong_answers_cost_their_episodes_alone() -> None:
    """The fault has its name in the record; the episodes after it are played as if nothing had been."""
    crash, nan, shape, text = play(replace(CONFIG, policy="Still"), ("", "crash", "nan", "", "shape", "text", ""))
    assert crash.fault == "crashed"
    assert "ZeroDivisionError: one by nothing" in crash.fault_detail
    assert [nan.fault, shape.fault, text.fault] == ["wrong answer"] * 3
    assert "NaN" in nan.fault_detail
    assert "(5,)" in shape.fault_detail


def test_a_policy_that_dies_or_hangs_costs_its_episodes_alone() -> None:
    """It is ended, and started again for the next one."""
    dead, hanging = play(replace(CONFIG, policy=f"{FILE}:Still", time_limit=2.0), ("exit", "", "hang"))
    assert (dead.fault, hanging.fault) == ("crashed", "timed out")


def test_what_is_around_an_episode_ends_with_it() -> None:
    """It begins when the task stands, and ends also with a fault."""
    seen: list[str] = []

    @contextmanager
    def around(task: TaskEnvironment):  # type: ignore[no-untyped-def]
        seen.append(task.get_name())
        yield
        seen.append("end")

    with EpisodeRunner(CONFIG) as worker:
        outcome = worker.play(plan_episodes(CONFIG)[0], around)
    assert outcome.record.end == "seconds"
    assert seen == ["reach_target", "end"]


def test_a_task_that_cannot_be_played_costs_its_episodes(tmp_path: Path) -> None:
    """What its code raises is in the record, and the other tasks are played."""
    scene = Path(policies.__file__).parents[3] / "rlbench_pin" / "tasks" / "library" / "reach_target.toml"
    (tmp_path / "broken_reach.toml").write_text(scene.read_text())
    (tmp_path / "broken_reach.py").write_text(
        "from rlbench_pin.tasks.library.reach_target import ReachTarget\n\n\n"
        "class BrokenReach(ReachTarget):\n"
        "    def init_episode(self, variation, rng):\n"
        "        raise ZeroDivisionError('one by nothing')\n"
    )
    config = replace(CONFIG, tasks=(str(tmp_path / "broken_reach.py"), "reach_target"), episodes=1)
    broken, sound = outcomes(config)
    assert (broken.record.task, broken.record.end, broken.record.fault) == ("broken_reach", "fault", "not played")
    assert "ZeroDivisionError: one by nothing" in broken.record.fault_detail
    assert sound.record.end == "seconds"


def test_unknown_policies_are_refused_before_anything_runs() -> None:
    """A file that is not there."""
    with pytest.raises(PolicyReferenceError, match="nowhere.py"):
        EpisodeRunner(replace(CONFIG, policy="nowhere.py:make"))


def test_long_texts_are_shortened() -> None:
    """Their end stays, where errors say what happened."""
    text = shortened("x" * 5000 + "the reason")
    assert len(text) == LONGEST_DETAIL
    assert text.endswith("the reason")
