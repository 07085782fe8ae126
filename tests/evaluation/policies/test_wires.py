"""A policy that openpi or vla-eval serves is asked as its mapping says; what its server does wrong costs the episode."""

from __future__ import annotations

import importlib
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rlbench_pin.environment.observations import ObservationConfig
from rlbench_pin.errors import MissingExtra, UnknownName
from rlbench_pin.evaluation import EvaluationConfig, evaluate
from rlbench_pin.evaluation.policies import (
    MappingError,
    PolicyClient,
    PolicyContext,
    PolicyFault,
    PolicyReferenceError,
    find_policy,
    load_mapping,
    open_policy,
    wires,
)
from rlbench_pin.evaluation.policies.policy_server import WireError
from rlbench_pin.evaluation.policies.wires import check_openpi, check_vla_eval, decode_frame, encode_openpi, encode_vla_eval
from rlbench_pin.observation import Observation
from rlbench_pin.processes import SerialEngine
from tests.evaluation.policies.served import Handler, served

CONTEXT = PolicyContext("panda", 7, (-1.0,) * 8, (1.0,) * 8, 0.05, 100, seed=1, task="reach_target")
IMAGE = np.full((256, 256, 3), 7, np.uint8)
SEEN = Observation(
    front_rgb=IMAGE, wrist_rgb=IMAGE, gripper_pose=np.array([0.3, 0, 1, 1, 0, 0, 0.0]), gripper_joint_positions=np.full(2, 0.04)
)


@contextmanager
def client(port: int, query: str = "", scheme: str = "openpi", time_limit: float = 5.0) -> Iterator[PolicyClient]:
    """A client of the preset for LIBERO."""
    mapping = "libero" if scheme == "openpi" else "libero_vla_eval"
    policy = open_policy(f"{scheme}://127.0.0.1:{port}?mapping={mapping}{query}", time_limit=time_limit, start_limit=5.0)
    try:
        yield policy
    finally:
        policy.close()


class OpenPi:
    """A server of openpi that answers with chunks of ten; `x` counts actions."""

    def __init__(self, metadata: object = (), reply: Callable[[Any], None] | None = None) -> None:
        self.metadata, self.reply, self.seen, self.connections = dict(metadata), reply, [], 0  # type: ignore[call-overload]

    def __call__(self, ws: Any) -> None:
        self.connections += 1
        self.header = ws.request.headers.get("Authorization", "")
        ws.send(encode_openpi(self.metadata))
        for frame in ws:
            self.seen.append(decode_frame(frame))
            if self.reply is not None:
                self.reply(ws)
                continue
            actions = np.zeros((10, 7), np.float32)
            actions[:, 0] = np.arange(10) / 10.0
            ws.send(encode_openpi({"actions": actions, "server_timing": {"infer_ms": 1.0}}))


class VlaEval:
    """A server of vla-eval that answers with one action."""

    def __init__(self, hello: object = (), error_at: str = "", seq: int = 0) -> None:
        self.hello, self.error_at, self.seq, self.kinds = dict(hello), error_at, seq, []  # type: ignore[call-overload]

    def __call__(self, ws: Any) -> None:
        for frame in ws:
            message = decode_frame(frame)
            self.kinds.append(message["type"])
            self.last = message["payload"]
            answer = {
                "type": "action",
                "payload": {"actions": np.full(7, 0.5)},
                "seq": message["seq"] + self.seq,
                "timestamp": 0.0,
            }
            if message["type"] == "hello":
                answer |= {"type": "hello", "seq": message["seq"], "payload": {"protocol_version": 1, **self.hello}}
            elif message["type"] == self.error_at:
                answer |= {"type": "error", "payload": {"error": "observation_failed: no such image"}}
            elif message["type"] != "observation":
                continue
            ws.send(encode_vla_eval(answer))


def fault_of(policy: PolicyClient) -> PolicyFault:
    """Return the fault of one episode of one action."""
    with pytest.raises(PolicyFault) as caught:
        policy.reset("Push.", CONTEXT)
        policy.act(SEEN)
    return caught.value


# What goes well ---------------------------------------------------------------------------------------------------------------


def test_openpi_is_asked_once_for_a_chunk() -> None:
    """`replan` actions are played, then the next chunk is asked for; an episode begins with a new one."""
    handle = OpenPi()
    with served(handle) as port, client(port, "&replan=3&token=key") as policy:
        assert policy.settings.action_mode["arm"] == "EndEffectorPoseViaIK"
        assert isinstance(policy.settings.make_obs_config(), ObservationConfig)
        policy.reset("Push.", CONTEXT)
        played = [policy.act(SEEN)[0] for _ in range(4)]
        np.testing.assert_allclose(played, [0.0, 0.005, 0.01, 0.0], atol=1e-8)
        policy.reset("Pull.", CONTEXT)
        assert policy.act(SEEN).shape == (8,)
    assert [seen["prompt"] for seen in handle.seen] == ["Push.", "Push.", "Pull."]
    assert handle.seen[0]["observation/image"].shape == (224, 224, 3) and handle.seen[0]["observation/image"].dtype == np.uint8
    assert handle.header == "Api-Key key" and handle.connections == 1


def test_vla_eval_is_told_when_episodes_begin_and_end() -> None:
    """A single action is a chunk of one."""
    handle = VlaEval()
    with served(handle) as port, client(port, scheme="vla-eval") as policy:
        for _ in range(2):
            policy.reset("Push.", CONTEXT)
            np.testing.assert_allclose(policy.act(SEEN)[:3], 0.025)
    assert handle.kinds == ["hello", "episode_start", "observation", "episode_end", "episode_start", "observation"]
    assert handle.last["images"]["agentview"].shape == (256, 256, 3)


def test_a_mapping_for_other_joints_costs_the_episode() -> None:
    """Seven joints of DROID, and an arm with six."""
    with served(OpenPi()) as port:
        policy = open_policy(f"openpi://127.0.0.1:{port}?mapping=droid")
        with pytest.raises(PolicyFault, match="is for 7 joints, the arm has 6"):
            policy.reset("Push.", replace(CONTEXT, joints=6))
        policy.close()


def test_a_token_may_stand_in_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """So it is not in the reference, which results files have."""
    monkeypatch.setenv("WIRE_TOKEN", "secret")
    handle = OpenPi()
    with served(handle) as port, client(port, "&token=env:WIRE_TOKEN") as policy:
        policy.reset("Push.", CONTEXT)
        policy.act(SEEN)
    assert handle.header == "Api-Key secret"
    monkeypatch.delenv("WIRE_TOKEN")
    with pytest.raises(PolicyReferenceError, match="'WIRE_TOKEN', which is not set"):
        find_policy("openpi://h:1?mapping=libero&token=env:WIRE_TOKEN")


# What goes wrong --------------------------------------------------------------------------------------------------------------


def _hang(ws: Any) -> None:
    time.sleep(1.0)


@pytest.mark.parametrize(
    ("reply", "kind", "says"),
    [
        (lambda ws: ws.close(1011, "out of memory"), "unreachable", "ended during `act`.*code 1011 'out of memory'"),
        (
            lambda ws: ws.send("Traceback:\n  File\nValueError: no such key"),
            "crashed",
            "The server says: ValueError: no such key",
        ),
        (lambda ws: ws.send(b"\xc1garbage"), "wrong answer", "is not msgpack"),
        (lambda ws: ws.send(b"\x91" * 5000), "wrong answer", "is not msgpack"),
        (lambda ws: ws.send(b"\xdd\x00\x02\x00\x00" + b"\x80" * 2**17), "wrong answer", "more than 100000 maps and lists"),
        (lambda ws: ws.send(b"\x01"), "wrong answer", r"has the shape \(\)"),
        (lambda ws: ws.socket.sendall(b"\xff\xff\xff\xff"), "wrong answer", "broken or larger"),
        (lambda ws: ws.send(encode_openpi({"action": 1})), "wrong answer", "has no 'actions'; its keys: action"),
        (lambda ws: ws.send(encode_openpi({"actions": "left"})), "wrong answer", "is a str"),
        (lambda ws: ws.send(encode_openpi({"actions": np.zeros((10, 8))})), "wrong answer", r"shape \(10, 8\).*has 7 numbers"),
        (lambda ws: ws.send(encode_openpi({"actions": np.zeros((0, 7))})), "wrong answer", r"shape \(0, 7\)"),
        (lambda ws: ws.send(encode_openpi({"actions": np.zeros((1, 2, 7))})), "wrong answer", r"shape \(1, 2, 7\)"),
        (
            lambda ws: ws.send(encode_openpi({"actions": np.full((2, 7), np.nan)})),
            "wrong answer",
            r"NaN or infinity at .*\[0, 0\]",
        ),
    ],
)
def test_a_reply_that_is_wrong_costs_the_episode(reply: Handler, kind: str, says: str) -> None:
    """The kind and the text say what happened; the next `reset` connects again."""
    handle = OpenPi(reply=reply)
    with served(handle) as port, client(port) as policy:
        fault = fault_of(policy)
        assert fault.kind == kind
        with pytest.raises(PolicyFault, match=f"(?s){says}"):
            raise fault
        with pytest.raises(PolicyFault, match="`reset` connects again"):
            policy.act(SEEN)
        handle.reply = None
        policy.reset("Push.", CONTEXT)
        assert policy.act(SEEN).shape == (8,) and handle.connections == 2


def test_a_traceback_is_kept() -> None:
    """All of it is in `printed`, as what a process prints."""
    with served(OpenPi(reply=lambda ws: ws.send("Traceback:\n  File\nValueError: why"))) as port, client(port) as policy:
        assert fault_of(policy).printed.startswith("Traceback")


def test_a_server_that_hangs_is_cut_off() -> None:
    """After the time limit, not later."""
    with served(OpenPi(reply=_hang)) as port, client(port, time_limit=0.2) as policy:
        fault = fault_of(policy)
    assert fault.kind == "timed out" and "`act` took longer than 0.2 s" in fault.detail


def test_a_server_that_reads_nothing_is_cut_off(monkeypatch: pytest.MonkeyPatch) -> None:
    """An observation that does not fit into the buffers of the sockets waits no longer than the limit."""
    done = threading.Event()

    def handle(ws: Any) -> None:
        ws.send(encode_openpi({}))
        ws.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        done.wait(5.0)

    with served(handle, max_queue=1) as port, client(port, time_limit=0.3) as policy:
        policy.reset("Push.", CONTEXT)
        monkeypatch.setattr(wires, "encode_openpi", lambda message: [b"\x00" * 2**20] * 60)  # fragments fill the queue
        with pytest.raises(PolicyFault) as caught:
            policy.act(SEEN)
        done.set()
    assert caught.value.kind == "timed out"


@pytest.mark.parametrize("scheme", ["openpi", "vla-eval"])
def test_a_port_where_nobody_listens(scheme: str) -> None:
    """The fault names the address, without arguments."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with client(port, "&token=secret", scheme=scheme) as policy, pytest.raises(PolicyFault, match="Connection refused") as caught:
        _ = policy.settings
    assert caught.value.kind == "unreachable" and f"{scheme}://127.0.0.1:{port}:" in str(caught.value)
    assert "secret" not in str(caught.value)


def _raw(answer: bytes) -> Iterator[int]:
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def run() -> None:
            connection, _ = listener.accept()
            connection.recv(4096)
            connection.sendall(answer)
            time.sleep(0.3)
            connection.close()

        threading.Thread(target=run, daemon=True).start()
        yield listener.getsockname()[1]


@pytest.mark.parametrize("answer", [b"HTTP/1.1 404 Not Found\r\n\r\n", b"\x00\x01\x02\x03 no HTTP at all\r\n\r\n"])
def test_another_kind_of_server(answer: bytes) -> None:
    """What does not answer as a WebSocket server is unreachable."""
    for port in _raw(answer):
        with client(port) as policy, pytest.raises(PolicyFault) as caught:
            _ = policy.settings
        assert caught.value.kind == "unreachable"


def test_a_token_that_is_refused() -> None:
    """The hint says how one is named."""

    def refuse(connection: Any, request: Any) -> Any:
        return connection.respond(401, "no")

    with served(OpenPi(), process_request=refuse) as port, client(port) as policy, pytest.raises(PolicyFault, match="`token=`"):
        _ = policy.settings


@pytest.mark.parametrize(
    ("greeting", "kind"),
    [("Traceback\nKeyError: 'x'", "crashed"), (b"\xc1", "wrong answer"), (b"\x93\x01\x02\x03", "wrong answer")],
)
def test_what_comes_when_one_connects(greeting: str | bytes, kind: str) -> None:
    """It has to be a map of metadata."""
    with served(lambda ws: ws.send(greeting)) as port, client(port) as policy, pytest.raises(PolicyFault) as caught:
        _ = policy.settings
    assert caught.value.kind == kind


def test_a_server_that_has_restarted_between_episodes_costs_nothing() -> None:
    """The connection has ended, and the next episode connects anew."""
    handle = OpenPi()
    with served(handle) as port, client(port) as policy:
        policy.reset("Push.", CONTEXT)
        handle.reply = lambda ws: (ws.send(encode_openpi({"actions": np.zeros((1, 7))})), ws.close())[0]
        policy.act(SEEN)
        time.sleep(1.0)  # until the client has seen the end
        handle.reply = None
        policy.reset("Push.", CONTEXT)
        assert policy.act(SEEN).shape == (8,)
    assert handle.connections == 2


def test_another_server_at_the_same_address_costs_the_episode() -> None:
    """Connected again, it says something else: that is its fault, not an error of the evaluation."""
    handle = OpenPi({"action_dim": 7}, reply=lambda ws: ws.close())
    with served(handle) as port, client(port) as policy:
        fault_of(policy)
        handle.metadata = {"action_dim": 9}
        fault = fault_of(policy)
    assert fault.kind == "wrong answer" and "action_dim 9" in fault.detail


@pytest.mark.parametrize("error_at", ["observation", "episode_start"])
def test_an_error_of_vla_eval(error_at: str) -> None:
    """Its text is in the fault."""
    with served(VlaEval(error_at=error_at)) as port, client(port, scheme="vla-eval") as policy:
        fault = fault_of(policy)
    assert fault.kind == "crashed" and "no such image" in fault.detail


def test_a_reply_of_vla_eval_to_another_request() -> None:
    """Each reply has the number of its request."""
    with served(VlaEval(seq=1)) as port, client(port, scheme="vla-eval") as policy:
        fault = fault_of(policy)
    assert fault.kind == "wrong answer" and "has number" in fault.detail


# Arrays -----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("encode", [encode_openpi, encode_vla_eval])
@pytest.mark.parametrize("dtype", ["<f4", "<f8", "|u1", "<i8", "|b1", "<f2"])
def test_arrays_arrive_as_they_were(encode: Callable[[object], bytes], dtype: str) -> None:
    """Both spellings of keys; also an empty array, and one that is not contiguous."""
    for array in (
        np.arange(12).reshape(3, 4).astype(dtype),
        np.zeros((0, 7), dtype),
        np.arange(12).reshape(3, 4).T.astype(dtype),
    ):
        back = decode_frame(encode({"a": array}))["a"]
        assert back.dtype == array.dtype
        np.testing.assert_array_equal(back, array)


def test_arrays_are_spelled_as_the_servers_expect() -> None:
    """Keys are bytes for openpi, and text for vla-eval."""
    array = np.array([[1.0, 2.0]], np.float32)
    parts = {"__ndarray__": True, "data": array.tobytes(), "dtype": "<f4", "shape": [1, 2]}
    assert msgpack.unpackb(encode_vla_eval({"a": array})) == {"a": parts}
    sent = msgpack.unpackb(encode_openpi({"a": array}), strict_map_key=False)
    assert sent == {"a": {key.encode(): value for key, value in parts.items()}}


@pytest.mark.parametrize(
    ("parts", "says"),
    [
        ({"dtype": "|O"}, "type '|O' is refused"),
        ({"dtype": "<c8"}, "is refused"),
        ({"dtype": "f4,f4"}, "is refused"),
        ({"dtype": "<M8[s]"}, "is refused"),
        ({"dtype": None}, "is refused"),
        ({"shape": [3]}, "wrong size, 8 bytes"),
        ({"shape": [2**40, 2**40]}, "wrong size, 8 bytes"),
        ({"shape": [-1]}, "has no valid shape"),
        ({"shape": [1] * 9}, "has no valid shape"),
        ({"shape": "ab"}, "has no valid shape"),
        ({"data": "abcdefgh"}, "wrong size, 0 bytes"),
    ],
)
def test_arrays_that_are_not_are_refused(parts: dict[str, Any], says: str) -> None:
    """Objects, structures, and sizes that do not agree."""
    array = {"__ndarray__": True, "data": b"\x00" * 8, "dtype": "<f4", "shape": [2]} | parts
    for made in (array, {key.encode(): value for key, value in array.items()}):
        with pytest.raises(WireError) as caught:
            decode_frame(msgpack.packb({"actions": made}))
        assert says in str(caught.value)


def test_numbers_of_numpy() -> None:
    """They travel as a map, too."""
    for data, dtype, good in ((1.5, "<f8", True), (3, "<i4", True), ("x", "<f8", False), (b"x", "|S1", False)):
        frame = msgpack.packb({b"__npgeneric__": True, b"data": data, b"dtype": dtype})
        if good:
            assert decode_frame(frame) == data
        else:
            with pytest.raises(WireError):
                decode_frame(frame)


def test_a_frame_that_is_too_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is refused before it is read."""
    monkeypatch.setattr(wires, "LARGEST_FRAME", 1000)
    with served(OpenPi(reply=lambda ws: ws.send(b"\x00" * 2000))) as port, client(port) as policy:
        assert fault_of(policy).kind == "wrong answer"


# What a server says about itself ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("metadata", "says"),
    [
        ({"action_dim": 8}, "'action' contradicts the server, which has action_dim 8. Got 7"),
        ({"action_space": "joint_position"}, "'action.arm' contradicts"),
        ({"observation_keys": ["observation/state", "observation/depth"]}, "lacks the key 'observation/depth'"),
        ({"needs_session_id": True}, "'needs_session_id' of the server of openpi is not supported"),
        ({"image_resolution": [180, 320]}, "'images.observation/image' contradicts"),
    ],
)
def test_metadata_of_openpi_are_compared(metadata: dict[str, Any], says: str) -> None:
    """Before the first episode; the evaluation ends."""
    with served(OpenPi(metadata)) as port, client(port) as policy, pytest.raises(MappingError) as caught:
        _ = policy.settings
    assert says in str(caught.value)


def test_metadata_that_agree_or_say_nothing() -> None:
    """Unknown entries are left alone."""
    mapping = load_mapping("libero")
    good = {"action_dim": 7, "action_space": "mine", "observation_keys": ["prompt"], "image_resolution": [224, 224], "x": 1}
    check_openpi(mapping, good)
    check_openpi(mapping, {})
    check_vla_eval(load_mapping("libero_vla_eval"), {})


SPEC = {
    "position": {"dims": 3, "format": "delta_xyz"},
    "rotation": {"dims": 3, "format": "axis_angle"},
    "gripper": {"dims": 1, "format": "binary_close_positive"},
}


@pytest.mark.parametrize(
    ("hello", "says"),
    [
        ({"action_spec": SPEC, "observation_spec": {"state": {"dims": 8}}}, ""),
        ({"action_spec": {"actions": {"dims": 0, "format": "raw"}}}, ""),
        ({"action_spec": "nonsense", "observation_spec": [1]}, ""),
        ({"protocol_version": 2}, "has to have version 1"),
        ({"action_spec": {"actions": {"dims": 8}}}, "the sum of 'dims' 8"),
        ({"action_spec": SPEC | {"position": {"dims": 3, "format": "absolute_xyz"}}}, "'action.arm'"),
        ({"action_spec": SPEC | {"rotation": {"dims": 3, "format": "euler_xyz"}}}, "'action.rotation'"),
        ({"action_spec": SPEC | {"gripper": {"dims": 1, "format": "binary_close_negative"}}}, "open at 1 and closed at -1"),
        ({"observation_spec": {"state": {"dims": 7}}}, "'states.states'"),
    ],
)
def test_the_hello_of_vla_eval_is_compared(hello: dict[str, Any], says: str) -> None:
    """Sizes and formats that have a fixed meaning."""
    mapping = load_mapping("libero_vla_eval")
    if not says:
        check_vla_eval(mapping, hello)
        return
    with pytest.raises(MappingError) as caught:
        check_vla_eval(mapping, hello)
    assert says in str(caught.value)


# References -------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("reference", "kind", "says"),
    [
        ("openpi://localhost:8000", PolicyReferenceError, "needs a mapping.*droid.*libero.*peract"),
        ("openpi://localhost?mapping=libero", PolicyReferenceError, "no valid address.*openpi://127.0.0.1:8000"),
        ("openpi://localhost:port?mapping=libero", PolicyReferenceError, "no valid address"),
        ("openpi:localhost:1?mapping=libero", PolicyReferenceError, "no valid address"),
        ("openpi://localhost:1?mapping=", PolicyReferenceError, "no value for the argument 'mapping'"),
        ("openpi://localhost:1?mapping", PolicyReferenceError, "no value for the argument 'mapping'"),
        ("openpi://localhost:1?mapping=libero&replan=", PolicyReferenceError, "no value for the argument 'replan'"),
        ("openpi://localhost:1?mapping=libero&replan=0", PolicyReferenceError, "wrong `replan`: '0'"),
        ("openpi://localhost:1?mapping=libero&replan=five", PolicyReferenceError, "wrong `replan`: 'five'"),
        ("openpi://localhost:1?mapping=libero&token=", PolicyReferenceError, "no value for the argument 'token'"),
        ("openpi://localhost:1?mapping=libero&replann=1", PolicyReferenceError, "Did you mean 'replan'"),
        ("openpi://localhost:1?mapping=libero&mapping=droid", PolicyReferenceError, "each key once"),
        ("vla-eval://localhost:1?mapping=libreo", UnknownName, "Did you mean 'libero'"),
        ("vla-eval://localhost:1?mapping=missing.toml", MappingError, "cannot be read"),
    ],
)
def test_a_reference_that_is_wrong(reference: str, kind: type[Exception], says: str) -> None:
    """It is named before anything connects, with what is possible."""
    with pytest.raises(kind, match=says):
        find_policy(reference)


def test_a_mapping_file_with_a_camera_that_does_not_exist(tmp_path: Path) -> None:
    """The file, the key and the near name."""
    file = tmp_path / "own.toml"
    file.write_text('[images.i]\ncamera = "wrst"\n[action]\narm = "delta_pose"\n', encoding="utf-8")
    with pytest.raises(MappingError, match="own.toml: 'images.i.camera'.*Did you mean 'wrist'"):
        find_policy(f"openpi://localhost:1?mapping={file}")


def test_without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    """The extra is named."""

    def missing(name: str) -> Any:
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(MissingExtra) as caught:
        find_policy("openpi://localhost:1?mapping=libero")
    assert caught.value.extra == "wires" and caught.value.library == "websockets"


# Episodes ---------------------------------------------------------------------------------------------------------------------

REACHING = """
replan = 2
[states]
state = ["tip_position", "tip_quaternion_xyzw", "task_low_dim_state"]
[action]
arm = "delta_pose"
frame = "{frame}"
scale = 0.05
"""


class Reacher:
    """A server of openpi whose policy moves the tip to the ball, by at most 5 cm along each axis; it may die in an episode."""

    def __init__(self, frame: str, dies_at: int = 0) -> None:
        self.frame, self.dies_at, self.requests = frame, dies_at, 0

    def __call__(self, ws: Any) -> None:
        ws.send(encode_openpi({}))
        for frame in ws:
            self.requests += 1
            if self.requests == self.dies_at:
                return
            state = decode_frame(frame)["state"]
            way = state[7:10] - state[:3]
            turned = Rotation.from_quat(state[3:7]).inv().apply(way) if self.frame == "tip" else way
            ws.send(encode_openpi({"actions": [[*np.clip(turned / 0.05, -1.0, 1.0).tolist(), 0.0, 0.0, 0.0, 1.0]]}))


@pytest.mark.simulation
@pytest.mark.parametrize("frame", ["world", "tip"])
def test_a_served_policy_reaches_the_ball(frame: str, tmp_path: Path) -> None:
    """Deltas in both frames; a server that dies costs one episode, and the next one connects again."""
    file = tmp_path / "reaching.toml"
    file.write_text(REACHING.format(frame=frame), encoding="utf-8")
    with served(Reacher(frame, dies_at=3)) as port:
        address = f"openpi://127.0.0.1:{port}?mapping={file}"
        config = EvaluationConfig(policy=address, tasks=("reach_target",), episodes=4, max_steps=40)
        results = evaluate(config, tmp_path / "results.json", engine=SerialEngine())
    assert [episode.fault for episode in results.episodes] == ["unreachable", "", "", ""]
    assert [episode.success for episode in results.episodes] == [False, True, True, True]
