"""A policy that was made for other joints than those of the arm is refused before any episode is played."""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from rlbench_pin.evaluation import (
    ChallengeConfig,
    EvaluationConfig,
    PolicyOfAnotherArm,
    PolicySettingsError,
    evaluate,
    run_challenge,
)
from rlbench_pin.evaluation.policies import PolicySettings, open_policy
from rlbench_pin.evaluation.policies.policy_server import Answers, listen, plain_settings, serve_answers
from rlbench_pin.processes import SerialEngine
from rlbench_pin.robot import SUPPORTED_ROBOTS
from tests.evaluation.policies.policies_for_tests import Obedient

FILE = Path(__file__).with_name("policies_for_tests.py")
PANDA = SUPPORTED_ROBOTS["panda"].arm_joints
JOINTS = f"joint_names={json.dumps(PANDA, separators=(',', ':'))}"
PLAIN = {"action_mode": {"mode": "JointPositionActionMode"}, "obs_config": {"joint_positions": True}}


def test_the_error_says_what_to_do() -> None:
    """It names the joints, the arm that was asked for, the arm that has the joints, and the flag."""
    settings = PolicySettings.of(*PLAIN.values(), joint_names=list(PANDA))
    settings.check_robot("panda")
    with pytest.raises(PolicyOfAnotherArm, match="panda_joint1.*'panda'. Use `--robot panda`") as caught:
        settings.check_robot("iiwa")
    assert isinstance(caught.value, PolicySettingsError)
    assert (caught.value.robot, caught.value.joint_names, caught.value.owners) == ("iiwa", PANDA, ("panda",))
    assert "'iiwa': iiwa_joint_1, " in str(caught.value)
    with pytest.raises(PolicyOfAnotherArm, match=r"No arm of the catalogue has them") as caught:
        replace(settings, joint_names=PANDA[::-1]).check_robot("panda")
    assert caught.value.owners == ()


def test_policies_that_do_not_say_work_with_every_arm() -> None:
    """Their settings are the same plain data as before."""
    settings = PolicySettings.of(*PLAIN.values())
    for robot in SUPPORTED_ROBOTS:
        settings.check_robot(robot)
    assert list(settings.plain()) == ["action_mode", "observation", "max_steps"]
    with pytest.raises(PolicySettingsError, match="joint_names"):
        PolicySettings.of(*PLAIN.values(), joint_names="panda_joint1")


def test_names_travel(tmp_path: Path) -> None:
    """From an object, from a subprocess, and over a socket without rlbench_pin."""
    here = Obedient()
    here.joint_names = PANDA  # type: ignore[attr-defined]
    assert open_policy(here).settings.joint_names == PANDA
    client = open_policy(f"{FILE}:MadeFor?{JOINTS}")
    try:
        assert client.settings.joint_names == PANDA
    finally:
        client.close()
    address = f"unix:{tmp_path}/policy.sock"
    policy = SimpleNamespace(**PLAIN, joint_names=list(PANDA))
    server = (lambda: Answers(lambda: policy, plain_settings), listen(address))
    threading.Thread(target=serve_answers, args=server, daemon=True).start()
    client = open_policy(address)
    assert client.settings.joint_names == PANDA
    client.close()


@pytest.mark.simulation
def test_an_evaluation_ends_before_it_begins(tmp_path: Path) -> None:
    """Nothing is written."""
    config = EvaluationConfig(policy=f"{FILE}:MadeFor?{JOINTS}", tasks=("reach_target",), episodes=1, robot="ur5e")
    with pytest.raises(PolicyOfAnotherArm, match="--robot panda"):
        evaluate(config, tmp_path / "results.json", engine=SerialEngine())
    assert not list(tmp_path.iterdir())
    results = evaluate(replace(config, robot="panda", max_steps=1), tmp_path / "results.json", engine=SerialEngine())
    assert results.settings["joint_names"] == list(PANDA) and results.episodes[0].end == "steps"


@pytest.mark.simulation
def test_a_challenge_ends_before_it_practises(tmp_path: Path) -> None:
    """A learner may name joints, too."""
    learners = Path(__file__).parents[1] / "challenge" / "learners.py"
    config = ChallengeConfig(learner=f"{learners}:MadeForPanda", only=("unplug_charger",), shots=(1,), episodes=1, robot="xarm7")
    with pytest.raises(PolicyOfAnotherArm, match="--robot panda"):
        run_challenge(config, tmp_path, engine=SerialEngine())
    assert not (tmp_path / "learned.msgpack").exists() and not (tmp_path / "demonstrations").exists()
