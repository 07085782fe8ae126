"""Learning by trial: what is seen and done, demonstrations as experience, training that goes on, its files, and the policy."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("stable_baselines3")
pytest.importorskip("safetensors")
pytest.importorskip("tensorboard")

from rlbench_pin.baselines.cloning.training import CHECKPOINT, MODEL, SETTINGS, ModelFileError  # noqa: E402
from rlbench_pin.baselines.reinforcement import (  # noqa: E402
    CurvePoint,
    LearningEnv,
    ReinforcementConfig,
    TrainingProgress,
    draw_curves,
    policy,
    read_curve,
    train_reinforcement,
)
from rlbench_pin.baselines.reinforcement.algorithms import gather  # noqa: E402
from rlbench_pin.baselines.reinforcement.environment import (  # noqa: E402
    REACH,
    SHAPED,
    TICKS,
    as_command,
    as_unit,
)
from rlbench_pin.baselines.reinforcement.training import CURVE  # noqa: E402
from rlbench_pin.errors import InvalidArgument, TaskEnvironmentError, UnknownName  # noqa: E402
from rlbench_pin.evaluation.policies import PolicyReferenceError, find_policy  # noqa: E402
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext  # noqa: E402
from rlbench_pin.evaluation.policies.policy_server import NoPolicy  # noqa: E402
from tests.cli.support import exit_code  # noqa: E402

TASK = "reach_target"
KEPT = (MODEL, SETTINGS, CURVE, "curve.png", CHECKPOINT)
"""Files that are equal whether a training was ended or not; those of TensorBoard have times in them."""
Capture = pytest.CaptureFixture[str]


def tiny(algorithm: str, shaped: bool = True, **changes: int) -> ReinforcementConfig:
    """Return a training of three segments that takes a second."""
    counts = {"steps": 48, "episode_steps": 4, "validation_episodes": 2, "imitation_steps": 20}
    settings = {**counts, "checkpoint_steps": 16, **changes}
    return ReinforcementConfig(algorithm, TASK, shaped=shaped, **settings)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def env() -> Iterator[LearningEnv]:
    """`reach_target` with its own reward."""
    made = LearningEnv(TASK, True, 30)
    yield made
    made.close()


@pytest.fixture(scope="module", params=["ppo", "sac"])
def trained(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """An algorithm and a folder with what it trained."""
    out = tmp_path_factory.mktemp(request.param)
    assert train_reinforcement(tiny(request.param), out)
    return request.param, out


def test_actions_are_joint_differences_of_a_decision() -> None:
    """What goes towards joints, done for the ticks of a decision, arrives; more than the largest action is cut off."""
    joints, wanted = np.zeros(2), np.array([0.06, -1.0])
    unit = as_unit(joints, wanted, is_open=True)
    command = as_command(unit, np.array([0.1, 0.1, 0.04]))
    np.testing.assert_allclose(TICKS * command[:2], [0.06, -TICKS * REACH])
    assert command[2] == 0.04
    assert as_command(as_unit(joints, wanted, is_open=False), np.array([0.1, 0.1, 0.04]))[2] == 0.0


def test_a_decision_lasts_some_ticks_and_pays(env: LearningEnv) -> None:
    """The same seed is the same episode; a failed one ends at the limit, and pays a share of the task's reward."""
    first, info = env.reset(options={"episode": 5})
    assert info["instructions"]
    np.testing.assert_array_equal(env.reset(options={"episode": 5})[0], first)
    rewards = []
    for _ in range(30):
        seen, reward, over, cut, info = env.step(np.zeros(8))
        rewards.append(reward)
    assert cut and not over and not info["is_success"]
    last = env.task.task.reward()
    assert last is not None and rewards[-1] == pytest.approx(SHAPED * last)
    assert seen.dtype == np.float32 and env.observation_space.contains(seen)


def test_demonstrations_succeed_with_the_actions_of_the_learner(env: LearningEnv) -> None:
    """The last transition of each pays success, and the joints move as the actions say, but for the noise of control."""
    found = gather(env, 2)
    assert 2 <= found.ends.sum() <= 4 and found.ends[-1] == 1.0
    assert np.all(found.rewards[found.ends == 1.0] > 0.8)
    assert np.abs(found.actions).max() <= 1.0
    moved = found.then[:, :7] - found.seen[:, :7]
    assert np.corrcoef(moved[:, 0], found.actions[:, 0])[0, 1] > 0.7
    np.testing.assert_array_equal(gather(env, 2).actions, found.actions)


@pytest.mark.parametrize(
    ("changes", "kind", "says"),
    [
        ({"algorithm": "pppo"}, UnknownName, "ppo"),
        ({"steps": 0}, InvalidArgument, "steps"),
        ({"steps": 2.5}, InvalidArgument, "steps"),
        ({"demonstrations": -1}, InvalidArgument, "demonstrations"),
        ({"shaped": "yes"}, InvalidArgument, "shaped"),
        ({"workers": 300}, InvalidArgument, "checkpoint_steps"),
        ({"episode_steps": 0}, InvalidArgument, "episode_steps"),
        ({"seed": -1}, InvalidArgument, "seed"),
    ],
)
def test_bad_settings_are_named(changes: dict[str, object], kind: type[Exception], says: str) -> None:
    """Before anything is loaded."""
    with pytest.raises(kind, match=says):
        ReinforcementConfig(**{"algorithm": "sac", "task": TASK, **changes})  # type: ignore[arg-type]


def test_a_task_without_a_reward_of_its_own_is_said(tmp_path: Path) -> None:
    """With what to do in its place, and without a folder."""
    with pytest.raises(TaskEnvironmentError, match="--demonstrations"):
        train_reinforcement(ReinforcementConfig("sac", "close_drawer", shaped=True), tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("algorithm", "demonstrations"), [("ppo", 1), ("sac", 1)])
def test_training_that_was_ended_goes_on_to_the_same_files(algorithm: str, demonstrations: int, tmp_path: Path) -> None:
    """Ended within the second segment, and begun again: weights, checkpoint, curve and image have the same bytes."""
    config = tiny(algorithm, demonstrations=demonstrations, episode_steps=30 if demonstrations else 4)
    assert train_reinforcement(config, tmp_path / "a")
    stop = threading.Event()

    def end(progress: TrainingProgress) -> None:
        if progress.steps == 20:
            stop.set()

    assert not train_reinforcement(config, tmp_path / "b", end, stop)
    assert len(read_curve(tmp_path / "b" / TASK)) == 2
    assert train_reinforcement(config, tmp_path / "b")
    for name in KEPT:
        assert (tmp_path / "b" / TASK / name).read_bytes() == (tmp_path / "a" / TASK / name).read_bytes(), name


@pytest.mark.slow
def test_a_killed_training_goes_on_to_the_same_files(tmp_path: Path, capsys: Capture) -> None:
    """`kill -9` in the middle of the second segment, then `--resume`."""
    words = ("train", "ppo", TASK, "--steps", "48", "--checkpoint-steps", "16", "--episode-steps", "4", "--out")
    assert exit_code(*words, str(tmp_path / "a")) == 0
    assert f"ppo:{tmp_path / 'a'}" in capsys.readouterr().out
    process = subprocess.Popen(
        [sys.executable, "-m", "rlbench_pin.cli.main", *words, str(tmp_path / "b")], stderr=subprocess.PIPE
    )
    deadline = time.monotonic() + 120
    while not (tmp_path / "b" / TASK / CHECKPOINT).exists() and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert len(read_curve(tmp_path / "b" / TASK)) < 4
    assert exit_code(*words, str(tmp_path / "b")) == 2
    assert "--resume" in capsys.readouterr().err
    assert exit_code(*words, str(tmp_path / "b"), "--resume") == 0
    for name in KEPT:
        assert (tmp_path / "b" / TASK / name).read_bytes() == (tmp_path / "a" / TASK / name).read_bytes(), name


def test_a_training_is_prolonged_but_not_changed(trained: tuple[str, Path]) -> None:
    """With more steps it goes on from its end; with another seed it is refused."""
    algorithm, out = trained
    steps: list[int] = []
    assert train_reinforcement(tiny(algorithm, steps=64), out, lambda progress: steps.append(progress.steps))
    assert steps[0] == 49 and steps[-1] == 64
    with pytest.raises(ModelFileError, match="'seed': 1"):
        train_reinforcement(tiny(algorithm, seed=1), out)


def test_the_policy_acts_as_it_was_trained(trained: tuple[str, Path], env: LearningEnv) -> None:
    """It is a policy, decides anew after the ticks of a decision, forgets at a reset, and is in files that hold no pickle."""
    algorithm, out = trained
    acting = policy(str(out), algorithm)
    assert isinstance(acting, Policy) and acting.max_steps == 2 * TICKS * 4
    assert acting.joint_names == env.task.runtime.description.arm_joints
    instructions, seen = env.task.reset(seed=3)
    context = PolicyContext("panda", 7, (), tuple(env.task.action_bounds()[1]), 0.05, 100, 0)
    acting.reset(instructions[0], context)
    first = acting.act(seen)
    later, _, _ = env.task.step(first)
    np.testing.assert_array_equal(acting.act(later), first)
    np.testing.assert_array_equal(acting.act(later), first)
    assert not np.array_equal(acting.act(later), first)
    acting.reset(instructions[0], context)
    np.testing.assert_array_equal(acting.act(seen), first)
    assert first.shape == (8,) and np.abs(first[:7]).max() <= REACH
    assert not list(out.rglob("*.zip")) and not list(out.rglob("*.p*kl"))
    assert list((out / TASK / "tensorboard").glob("events*"))


def test_wrong_folders_and_damaged_files_are_named(trained: tuple[str, Path], tmp_path: Path) -> None:
    """No folder, the other algorithm, settings and weights that were tampered with, another task."""
    algorithm, out = trained
    with pytest.raises(PolicyReferenceError, match=f"rlbench-pin train {algorithm}"):
        find_policy(f"{algorithm}:{tmp_path}")
    assert find_policy(f"{algorithm}:{out}").place == "subprocess"
    with pytest.raises(ModelFileError, match="kind"):
        policy(str(out), "sac" if algorithm == "ppo" else "ppo")
    with pytest.raises(NoPolicy, match="ppo or sac"):
        policy(str(out), "dqn")
    place = tmp_path / TASK
    place.mkdir()
    (place / SETTINGS).write_text((out / TASK / SETTINGS).read_text().replace('"ticks": 3', '"ticks": 0'))
    with pytest.raises(ModelFileError, match="ticks"):
        policy(str(tmp_path), algorithm)
    settings = json.loads((out / TASK / SETTINGS).read_text())
    (place / SETTINGS).write_text(json.dumps({**settings, "seen": settings["seen"] + 1}))
    (place / MODEL).write_bytes((out / TASK / MODEL).read_bytes())
    context = PolicyContext("panda", 7, (), (), 0.05, 100, 0)
    with pytest.raises(ModelFileError, match="does not match the settings"):
        policy(str(tmp_path), algorithm).reset("", context)
    (place / SETTINGS).write_bytes((out / TASK / SETTINGS).read_bytes())
    (place / MODEL).write_bytes((out / TASK / MODEL).read_bytes()[:100])
    with pytest.raises(ModelFileError, match="damaged"):
        policy(str(tmp_path), algorithm).reset("", context)
    (place / CHECKPOINT).write_bytes((out / TASK / CHECKPOINT).read_bytes()[:1000])
    with pytest.raises(ModelFileError, match="damaged"):
        train_reinforcement(tiny(algorithm), tmp_path)


def test_curves_hold_intervals_and_are_drawn_alike(trained: tuple[str, Path], tmp_path: Path) -> None:
    """A point before the first segment and one after each; the same points give the same image."""
    _, out = trained
    rows = json.loads((out / TASK / CURVE).read_text())
    assert [row["steps"] for row in rows][:4] == [0, 16, 32, 48]
    assert rows[0]["of"] == 2 and rows[0]["wilson_95"][0] <= rows[0]["successes"] / 2 <= rows[0]["wilson_95"][1]
    assert rows[1]["successes"] is None and rows[1]["wilson_95"] is None
    points = [CurvePoint(0, 0, None, None, 1, 20), CurvePoint(16, 4, -1.0, 0.5), CurvePoint(32, 4, -0.5, 0.75, 12, 20)]
    pictures = [draw_curves(tmp_path / f"{name}.svg", {"ppo": points, "sac": points[:1]}).read_bytes() for name in "ab"]
    assert pictures[0] == pictures[1] and b"decisions of training" in pictures[0]
    (tmp_path / CURVE).write_text("[{}]")
    with pytest.raises(ModelFileError, match="damaged"):
        read_curve(tmp_path)


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("ppo",), "rlbench-pin train ppo TASK..."),
        (("sac", "reach_targt"), "reach_target"),
        (("sac", TASK, "--steps", "0"), "--steps"),
        (("sac", TASK, "--workers", "0"), "--workers"),
        (("sac", TASK, "--checkpoint-steps", "9", "--workers", "2"), "checkpoint_steps"),
        (("ppo", TASK, "--demonstrations", "-1"), "--demonstrations"),
        (("ppo", "push_button", "--shaped"), "no shaped reward"),
        (("ppo", TASK, "--plot", "curve.pdf"), ".png or .svg"),
    ],
)
def test_misuse_is_named(words: tuple[str, ...], hint: str, tmp_path: Path, capsys: Capture) -> None:
    """What is missing or wrong, and nothing is written."""
    assert exit_code("train", *words, "--out", str(tmp_path / "m")) in (1, 2)
    assert hint in capsys.readouterr().err
    assert not (tmp_path / "m").exists()


@pytest.mark.slow
def test_sac_learns_and_is_evaluated(tmp_path: Path) -> None:
    """Two hundred decisions after twenty demonstrations; the evaluation of what comes of them is better than chance."""
    words = ("--steps", "256", "--checkpoint-steps", "128", "--demonstrations", "20", "--out", str(tmp_path / "m"))
    assert exit_code("train", "sac", TASK, *words) == 0
    out = tmp_path / "results.json"
    assert exit_code("evaluate", f"sac:{tmp_path / 'm'}", "--tasks", TASK, "--episodes", "10", "--out", str(out)) == 0
    assert sum(episode["success"] for episode in json.loads(out.read_text())["episodes"]) >= 3
