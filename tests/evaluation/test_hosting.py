"""Another program, such as vla-eval, plays our episodes: the same ones, with the same numbers, as in our own evaluation."""

from __future__ import annotations

import importlib
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from rlbench_pin.errors import InvalidArgument, InvalidValue, MissingExtra, UnknownName
from rlbench_pin.evaluation import (
    EvaluationConfig,
    MappingError,
    PolicyFault,
    PolicyMapping,
    ProtocolConflict,
    evaluate,
    load_mapping,
    load_protocol,
    mapping_names,
    plan_episodes,
)
from rlbench_pin.evaluation.policies.wires import (
    check_vla_eval,
    decode_frame,
    encode_openpi,
    encode_vla_eval,
    vla_eval_specs,
)
from rlbench_pin.evaluation.run.hosting import EpisodeHost, hosting_config
from rlbench_pin.processes import SerialEngine
from tests.evaluation.protocols_for_tests import small_file

BENCHMARK = "rlbench_pin.evaluation.vla_eval_benchmark"
EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples" / "vla_eval").glob("*.yaml"))
REACHING = """
about = "Deltas of at most 5 cm; the state is that of the tip, then that of the ball."
instruction = "task_description"
max_steps = 40

[images."images.front"]
camera = "front"
image_size = [32, 24]

[states]
states = ["tip_position", "task_low_dim_state"]

[action]
arm = "delta_pose"
clip = 1.0
scale = 0.05
"""
EPISODES = 3


@pytest.fixture
def reaching(tmp_path: Path) -> PolicyMapping:
    """A mapping with which a policy of one line reaches the ball."""
    file = tmp_path / "reaching.toml"
    file.write_text(REACHING, encoding="utf-8")
    return load_mapping(str(file))


@pytest.fixture
def host(reaching: PolicyMapping) -> Iterator[EpisodeHost]:
    """A host of reach_target with two episodes."""
    host = EpisodeHost(hosting_config("a program", None, ["reach_target"], 2), reaching)
    yield host
    host.close()


def to_the_ball(observation: dict[str, Any]) -> dict[str, Any]:
    """Return the reply of a policy that moves the tip towards the ball."""
    state = np.asarray(observation["states"])
    return {"actions": np.concatenate([np.clip((state[3:6] - state[:3]) / 0.05, -1.0, 1.0), np.zeros(3), [1.0]])}


def play(host: EpisodeHost, row: str, index: int, policy: Callable[[dict[str, Any]], Any] = to_the_ball) -> list[Any]:
    """Play an episode and return what the policy was sent."""
    instruction, seen = host.reset(row, index)
    sent, end = [], None
    while end is None:
        sent.append(host.mapping.encode(seen, instruction))
        seen, end = host.step(policy(sent[-1]))
    return sent


def test_factors_of_a_protocol_are_applied(reaching: PolicyMapping) -> None:
    """Each episode is played without and with them."""
    factors = "start_configuration:3"
    host = EpisodeHost(replace(hosting_config("a program", None, ["reach_target"], 1), factors=(factors,)), reaching)
    (row,) = host.rows
    tips = {}
    for number, item in enumerate(host.rows[row]):
        instruction, seen = host.reset(row, number)
        tips[item.factors] = np.asarray(host.mapping.encode(seen, instruction)["states"])[:3]
    host.close()
    assert list(tips) == ["", factors]
    assert np.abs(tips[factors] - tips[""]).max() > 0.01


# The same in both directions --------------------------------------------------------------------------------------------------


@contextmanager
def served(kept: list[Any]) -> Iterator[int]:
    """A server of vla-eval with `to_the_ball`, which keeps what it is sent."""
    server = pytest.importorskip("websockets.sync.server")

    def handle(ws: Any) -> None:
        for frame in ws:
            message = decode_frame(frame)
            answer = {**message, "payload": {"protocol_version": 1}}
            if message["type"] == "observation":
                kept.append(message["payload"])
                answer |= {"type": "action", "payload": to_the_ball(message["payload"])}
            if message["type"] in ("hello", "observation"):
                ws.send(encode_vla_eval(answer))

    with server.serve(handle, "127.0.0.1", 0, compression=None) as running:
        thread = threading.Thread(target=running.serve_forever, daemon=True)
        thread.start()
        yield running.socket.getsockname()[1]
        running.shutdown()
        thread.join(5.0)


@pytest.mark.simulation
def test_both_directions_play_the_same_episodes(reaching: PolicyMapping, tmp_path: Path) -> None:
    """Asked by our evaluation or asked by another program, a policy sees and does the same, byte for byte."""
    kept: list[Any] = []
    with served(kept) as port:
        policy = f"vla-eval://127.0.0.1:{port}?mapping={reaching.source}"
        config = EvaluationConfig(policy=policy, tasks=("reach_target",), episodes=EPISODES)
        results = evaluate(config, tmp_path / "results.json", engine=SerialEngine())
    host, sent, ends = EpisodeHost(hosting_config("a program", None, ["reach_target"], EPISODES), reaching), [], []
    for index in range(EPISODES):
        sent.append(play(host, "reach_target", index))
        ends.append((host.end, host.success_is_stable()))
    host.close()
    assert [len(episode) for episode in sent] == [episode.steps for episode in results.episodes]
    assert ends == [(episode.end, episode.lasts) for episode in results.episodes]
    assert [end for end, _ in ends] == ["success"] * EPISODES
    assert [encode_openpi(seen) for episode in sent for seen in episode] == [encode_openpi(seen) for seen in kept]


@pytest.mark.simulation
def test_peract18_is_the_protocol() -> None:
    """18 rows of 25 episodes, with the seeds, variations and limit of `evaluate --protocol peract18`."""
    host = EpisodeHost(hosting_config("a program", "peract18", None, None), load_mapping("peract_vla_eval"))
    planned = plan_episodes(EvaluationConfig.of_protocol("noop", load_protocol("peract18")))
    ours = [(item.name, item.variation, item.seed) for items in host.rows.values() for item in items]
    assert ours == [(item.name, item.variation, item.seed) for item in planned]
    assert list(host.rows) == list(load_protocol("peract18").task_names) and {len(items) for items in host.rows.values()} == {25}
    assert host.max_steps == 25
    _, seen = host.reset("open_drawer", 24)
    assert np.asarray(seen.front_rgb).shape == (128, 128, 3)
    stay, end = np.append(np.asarray(seen.gripper_pose), 1.0), None
    while end is None:
        end = host.step({"actions": stay})[1]
    assert end == "steps"
    host.close()


def test_a_protocol_that_counts_variations_has_a_row_for_each(tmp_path: Path, reaching: PolicyMapping) -> None:
    """As in our tables of results; the episodes of all seeds are in the row."""
    arm = ('"EndEffectorPoseViaPlanning"', '"EndEffectorPoseViaIK"')
    size = ("[64, 64]", "[32, 24]")
    of_task = EpisodeHost(hosting_config("a program", small_file(tmp_path, arm, size), None, None), reaching)
    assert {row: len(items) for row, items in of_task.rows.items()} == {"reach_target": 4, "push_button": 4}
    file = small_file(tmp_path, arm, size, ('episodes_of = "task"', 'episodes_of = "variation"'))
    rows = EpisodeHost(hosting_config("a program", file, None, None), reaching).rows
    assert list(rows) == ["reach_target+0", "reach_target+1", "reach_target+2", "push_button+4", "push_button+9"]
    assert {len(items) for items in rows.values()} == {4}


# What goes wrong --------------------------------------------------------------------------------------------------------------


def test_a_refused_action_counts_as_in_an_evaluation(host: EpisodeHost) -> None:
    """Nothing moves, and the limit of actions ends the episode."""
    host = EpisodeHost(host.config, replace(host.mapping, action=replace(host.mapping.action, scale=10.0), max_steps=3))
    _, first = host.reset("reach_target", 0)
    seen = [host.step({"actions": [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]}) for _ in range(3)]
    assert [end for _, end in seen] == [None, None, "steps"]
    np.testing.assert_array_equal(seen[-1][0].gripper_pose, first.gripper_pose)
    assert not host.success_is_stable()
    with pytest.raises(InvalidArgument, match="needs a running episode"):
        host.step({"actions": np.zeros(7)})
    host.close()


@pytest.mark.parametrize(
    ("reply", "says"),
    [
        ({"action": np.zeros(7)}, "has no 'actions'; its keys: action"),
        ({"actions": np.zeros(8)}, r"shape \(8,\).*has 7 numbers"),
        ({"actions": np.zeros((2, 7))}, "several actions. Send one at a time"),
        ({"actions": np.full(7, np.nan)}, "NaN or infinity"),
        ({"actions": "left"}, "is a str"),
        (None, "has no 'actions'; its keys: none"),
    ],
)
def test_a_reply_without_an_action_is_a_fault(host: EpisodeHost, reply: object, says: str) -> None:
    """It is named; the episode can go on."""
    host.reset("reach_target", 1)
    with pytest.raises(PolicyFault, match=says):
        host.step(reply)
    assert host.step({"actions": np.zeros((1, 7))})[1] is None


def test_episodes_that_do_not_exist_are_named(host: EpisodeHost) -> None:
    """A row, or a number beyond the last; a step before the first reset."""
    with pytest.raises(InvalidArgument, match="Call `reset` first"):
        host.step({"actions": np.zeros(7)})
    with pytest.raises(UnknownName, match="Did you mean 'reach_target'"):
        host.reset("reach_targt", 0)
    for index in (2, -1, 0.5, None):
        with pytest.raises(InvalidArgument, match="episode"):
            host.reset("reach_target", index)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("protocol", "tasks", "episodes", "error", "says"),
    [
        (None, None, None, InvalidArgument, "are required without a protocol"),
        ("peract18", ["reach_target"], None, InvalidArgument, "not allowed with one"),
        ("peract18", None, 3, InvalidArgument, "which fixes them"),
        ("peract81", None, None, UnknownName, "Did you mean 'peract18'"),
        (None, ["reach_targt"], None, UnknownName, "Did you mean 'reach_target'"),
        (None, "reach_target", None, InvalidValue, "has to be a list of names"),
        (None, ["reach_target"], 0, InvalidArgument, "episodes"),
        (7, None, None, InvalidValue, "protocol"),
    ],
)
def test_settings_that_cannot_be_are_refused(protocol: Any, tasks: Any, episodes: Any, error: type[Exception], says: str) -> None:
    """Before a world is built."""
    with pytest.raises(error, match=says):
        hosting_config("a program", protocol, tasks, episodes)


def test_a_mapping_that_contradicts_is_refused(tmp_path: Path) -> None:
    """The protocol has other actions; the arm other joints."""
    with pytest.raises(ProtocolConflict, match="EndEffectorPoseViaIK.*peract18.*Change the policy 'mapping=libero_vla_eval'"):
        EpisodeHost(hosting_config("a program", "peract18", None, None), load_mapping("libero_vla_eval"))
    config = EvaluationConfig(policy="a program", tasks=("reach_target",), robot="ur5e")
    with pytest.raises(MappingError, match="'action.joints' has to be 6 for 'ur5e'. Got 7"):
        EpisodeHost(config, load_mapping("droid"))


# vla-eval ---------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", mapping_names())
def test_specs_agree_with_their_mapping(name: str) -> None:
    """What we say of a mapping is what we would accept of a server with it; each observation has a name of its own."""
    mapping = load_mapping(name)
    specs = vla_eval_specs(mapping)
    check_vla_eval(mapping, specs)
    assert len(specs["observation_spec"]) == len(mapping.keys)
    assert sum(spec["dims"] for spec in specs["action_spec"].values()) == mapping.action.size


def test_specs_are_in_the_words_of_vla_eval() -> None:
    """Those of its own client for LIBERO."""
    specs = vla_eval_specs(load_mapping("libero_vla_eval"))
    formats = {name: spec["format"] for part in specs.values() for name, spec in part.items()}
    assert formats == {
        "position": "delta_xyz", "rotation": "axis_angle", "gripper": "binary_close_positive", "language": "language",
        "agentview": "rgb_hwc_uint8", "wrist": "rgb_hwc_uint8", "state": "eef_pos3_axisangle3_gripper2",
    }  # fmt: skip
    with pytest.raises(MappingError, match="the sum of 'dims' 7"):
        check_vla_eval(load_mapping("peract_vla_eval"), specs)


def test_the_examples_name_what_exists() -> None:
    """The class, its arguments, and a mapping that fits."""
    assert [file.name for file in EXAMPLES] == ["peract18.yaml", "tasks.yaml"]
    for file in EXAMPLES:
        (entry,) = yaml.safe_load(file.read_text(encoding="utf-8"))["benchmarks"]
        assert entry["benchmark"] == f"{BENCHMARK}:RlbenchPinBenchmark"
        chosen = {"protocol": None, "tasks": None, "episodes": None, **entry["params"]}
        host = EpisodeHost(
            hosting_config("vla-eval", chosen["protocol"], chosen["tasks"], chosen["episodes"]), load_mapping(chosen["mapping"])
        )
        assert {len(items) for items in host.rows.values()} == {entry["episodes_per_task"]}


def test_without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    """The module says which extra brings it; everything else works without."""
    monkeypatch.delitem(sys.modules, BENCHMARK, raising=False)
    monkeypatch.setitem(sys.modules, "vla_eval", None)
    with pytest.raises(MissingExtra, match=r"needs 'vla_eval.*\[vla-eval\]"):
        importlib.import_module(BENCHMARK)


@pytest.mark.simulation
def test_vla_eval_plays_what_we_play(reaching: PolicyMapping, tmp_path: Path) -> None:
    """vla-eval itself, with a served policy: the same successes, actions and observations as `EpisodeHost` alone."""
    pytest.importorskip("vla_eval")
    api = importlib.import_module("vla_eval.api")
    kept: list[Any] = []

    class Served(importlib.import_module("vla_eval.model_servers.predict").PredictModelServer):  # type: ignore[misc]
        def predict(self, obs: dict[str, Any], ctx: object) -> dict[str, Any]:
            kept.append(obs)
            return to_the_ball(obs)

    entry = {
        "benchmark": f"{BENCHMARK}:RlbenchPinBenchmark",
        "episodes_per_task": 2,
        "params": {"mapping": reaching.source, "tasks": ["reach_target", "push_button"], "episodes": 2},
    }
    with api.serve_background(Served()) as server:
        (found,) = api.run({"benchmarks": [entry]}, server_url=server.url, output_dir=tmp_path, docker=False)
    host, sent, ends = EpisodeHost(hosting_config("vla-eval", None, entry["params"]["tasks"], 2), reaching), [], []  # type: ignore[index]
    for row in host.rows:
        for index in range(2):
            sent.append(play(host, row, index))
            ends.append({"success": host.end == "success", "stable_success": host.success_is_stable(), "end": host.end})
    host.close()
    tasks = {task["task"]: task for task in found["tasks"]}
    episodes = [episode for row in host.rows for episode in tasks[row]["episodes"]]
    assert [episode["metrics"] for episode in episodes] == ends
    assert [episode["steps"] for episode in episodes] == [len(episode) for episode in sent]
    assert [tasks[row]["mean_success"] for row in host.rows] == [1.0, 0.0]
    assert [encode_openpi(seen) for episode in sent for seen in episode] == [encode_openpi(seen) for seen in kept]


def test_vla_eval_wants_no_more_than_the_class_has() -> None:
    """Every method that its base class asks for is there, and specs are its own records."""
    pytest.importorskip("vla_eval")
    specs = importlib.import_module("vla_eval.specs")
    benchmark = importlib.import_module(BENCHMARK).RlbenchPinBenchmark("libero_vla_eval", tasks=["reach_target"], episodes=2)
    assert benchmark.get_tasks() == [{"name": "reach_target", "suite": "rlbench_pin"}]
    assert benchmark.get_metadata() == {"max_steps": None, "max_episodes_per_task": 2}
    wanted = {"position": specs.POSITION_DELTA, "rotation": specs.ROTATION_AA, "gripper": specs.GRIPPER_CLOSE_POS}
    seen = {"agentview": specs.IMAGE_RGB, "state": specs.STATE_EEF_POS_AA_GRIP, "language": specs.LANGUAGE}
    assert specs.check_specs(wanted, benchmark.get_action_spec(), seen, benchmark.get_observation_spec()) == []
    benchmark.cleanup()
