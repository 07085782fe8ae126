"""A policy behind a socket: served in one place, evaluated in another, whatever is sent there."""

from __future__ import annotations

import ast
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgpack
import numpy as np
import pytest

from rlbench_pin.evaluation.policies import PolicyContext, PolicyFault, PolicySettingsError, open_policy, policy_server
from rlbench_pin.evaluation.policies.policy_server import Channel, WireError, listen, pack, serve, split_tcp, unpack
from rlbench_pin.observation import Observation
from tests.evaluation.policies.test_faults import OBEDIENT

CONTEXT = PolicyContext("panda", 7, (-1.0,) * 8, (1.0,) * 8, 0.05, 100, seed=1)
SEEN = Observation(joint_positions=np.arange(7.0))


class Plain:
    """A policy as one is written without rlbench_pin."""

    def __init__(self) -> None:
        self.action_mode: Any = {"mode": "MoveArmThenGripper", "arm": "JointVelocity", "gripper": "Discrete"}
        self.obs_config = {"joint_positions": True}
        self.episodes = 0

    def reset(self, instruction: str, context: SimpleNamespace) -> None:
        """Count."""
        self.episodes += 1
        self.joints = context.joints
        if instruction == "exit":
            sys.exit(3)

    def act(self, observation: SimpleNamespace) -> Any:
        """Return which episode it is, for each joint, and the first position."""
        if self.episodes == 3:
            raise RuntimeError("three is too many")
        return [float(self.episodes)] * self.joints + [float(observation.joint_positions[1])]


@pytest.fixture(params=["unix", "tcp"])
def address(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """An address at which `Plain` is served."""
    where = f"unix:{tmp_path}/policy.sock" if request.param == "unix" else "tcp://127.0.0.1:0"
    listener = listen(where)
    if request.param == "tcp":
        where = f"tcp://127.0.0.1:{listener.getsockname()[1]}"
    make = policy_server.Answers
    threading.Thread(target=policy_server.serve_answers, args=(lambda: make(Plain), listener), daemon=True).start()
    yield where
    listener.close()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")  # `sys.exit` in a thread
def test_a_policy_without_rlbench_pin(address: str) -> None:
    """It gives its settings as plain data; each evaluation has a policy of its own; a fault begins it anew."""
    first, second = (open_policy(address, time_limit=5.0) for _ in range(2))
    assert first.settings.action_mode["arm_settings"] == {"absolute_mode": True}
    for client in (first, second):
        client.reset("go", CONTEXT)
        assert client.act(SEEN).tolist() == [1.0] * 8
    for _ in range(2):
        first.reset("go", CONTEXT)
    with pytest.raises(PolicyFault, match="three is too many") as caught:
        first.act(SEEN)
    assert caught.value.kind == "crashed"
    first.reset("go", CONTEXT)
    assert first.act(SEEN)[0] == 1.0
    second.reset("go", CONTEXT)
    assert second.act(SEEN)[0] == 2.0
    with pytest.raises(PolicyFault, match="The connection ended during `reset`") as caught:
        second.reset("exit", CONTEXT)
    assert caught.value.kind == "unreachable"
    second.reset("go", CONTEXT)
    assert second.act(SEEN)[0] == 1.0
    second.close()


def raw(address: str) -> socket.socket:
    """Connect without our client."""
    if address.startswith("unix:"):
        connection = socket.socket(socket.AF_UNIX)
        connection.connect(address.removeprefix("unix:"))
        return connection
    return socket.create_connection(split_tcp(address))


def framed(body: bytes) -> bytes:
    """Return bytes with their length first."""
    return struct.pack(">I", len(body)) + body


def extension(*parts: Any, code: int = 1) -> bytes:
    """Return a question with an array of our making."""
    array = msgpack.ExtType(code, msgpack.packb(list(parts)))
    return framed(msgpack.packb({"call": "act", "observation": {"joint_positions": array}}))


HOSTILE = {
    "nonsense": framed(b"GET / HTTP/1.1\r\n\r\n"),
    "a length without a message": struct.pack(">I", 100),
    "four gigabytes": struct.pack(">I", 2**32 - 1) + b"x" * 100,
    "nothing": framed(b""),
    "no map": framed(msgpack.packb([1, 2, 3])),
    "deep": framed(b"\x91" * 100_000),
    "objects": extension("|O", [1], b"\0" * 8),
    "too few bytes": extension("<f8", [1000, 1000], b"\0" * 8),
    "a negative shape": extension("<f8", [-1], b"\0" * 8),
    "no type": extension("rm -rf", [1], b"\0" * 8),
    "another extension": extension("<f8", [1], b"\0" * 8, code=7),
    "a pickle": framed(b"\x80\x04cos\nsystem\n(S'true'\ntR."),
    "no call": pack({"observation": {}}),
    "a call that there is not": pack({"call": "__init__"}),
    "no observation": pack({"call": "act", "observation": 3}),
    "numbers as names": pack({"call": "act", "observation": {1: 2}}),
    "no context": pack({"call": "reset", "instruction": 3, "context": []}),
    "another version": pack({"call": "hello", "version": 99}),
    "an observation before the first reset": pack({"call": "act", "observation": {}}),
}


def test_hostile_messages(address: str) -> None:
    """Each is answered with an error or an end; other evaluations go on."""
    client = open_policy(address, time_limit=5.0)
    client.reset("go", CONTEXT)
    for name, message in HOSTILE.items():
        with raw(address) as connection:
            connection.settimeout(5.0)
            try:
                connection.sendall(message)
                connection.shutdown(socket.SHUT_WR)
                answer = Channel(connection).receive(5.0)
            except (EOFError, OSError) as error:
                assert not isinstance(error, TimeoutError), name
                answer = {"error": "ended"}
        assert "error" in answer and "ok" not in answer, name
        assert client.act(SEEN).tolist() == [1.0] * 8
    client.close()


@pytest.mark.parametrize(
    "answer",
    [b"", struct.pack(">I", 2**31), framed(b"\xc1"), framed(msgpack.packb(7)), pack({}), pack({"ok": 3}), pack({"ok": None}),
     pack({"ok": {"version": 1, "action_mode": None, "observation": None}}), pack({"ok": {"version": 2}}),
     pack({"error": 7, "kind": []})],
)  # fmt: skip
def test_hostile_servers(tmp_path: Path, answer: bytes) -> None:
    """What answers nonsense, or nothing, is a fault or a settings error, not more."""
    listener = listen(f"unix:{tmp_path}/s")

    def answer_one() -> None:
        connection = listener.accept()[0]
        connection.recv(2**16)
        connection.sendall(answer)
        connection.close()

    threading.Thread(target=answer_one, daemon=True).start()
    with pytest.raises((PolicyFault, PolicySettingsError)):
        _ = open_policy(f"unix:{tmp_path}/s", start_limit=5.0).settings
    listener.close()


@pytest.mark.parametrize("address", ["tcp://a..b:80", f"tcp://{'x' * 5000}:80", f"unix:{'x' * 5000}", "unix:\udcff"])
def test_addresses_that_nothing_can_have(address: str) -> None:
    """They are unreachable, as others are."""
    with pytest.raises(PolicyFault) as caught:
        _ = open_policy(address).settings
    assert caught.value.kind == "unreachable"


def test_a_server_that_says_nothing(tmp_path: Path) -> None:
    """It has the time that it may take to start."""
    listener = listen(f"unix:{tmp_path}/s")
    with pytest.raises(PolicyFault, match="longer than") as caught:
        _ = open_policy(f"unix:{tmp_path}/s", start_limit=0.2).settings
    assert caught.value.kind == "timed out"
    listener.close()


@pytest.mark.simulation
def test_a_connection_that_ends_is_made_again(tmp_path: Path) -> None:
    """Where the server is gone the fault says how to start it; where it is back the next episode is played."""
    command = [sys.executable, "-c", f"import {__name__} as t; t.serve(t.Plain, 'unix:{tmp_path}/s')"]
    root = str(Path(__file__).resolve().parents[3])
    client = open_policy(f"unix:{tmp_path}/s", time_limit=5.0)
    with pytest.raises(PolicyFault, match="rlbench-pin serve POLICY --address unix:") as caught:
        client.reset("go", CONTEXT)
    assert caught.value.kind == "unreachable"
    for _ in range(2):
        server = subprocess.Popen(command, cwd=root, env={**os.environ, "PYTHONPATH": root})
        try:
            _wait_for(client)
            assert client.act(SEEN)[0] == 1.0
        finally:
            server.kill()  # its socket stays behind, and the next one listens there all the same
            server.wait()
        with pytest.raises(PolicyFault) as caught:
            client.act(SEEN)
        assert caught.value.kind == "unreachable"


def _wait_for(client: Any) -> None:
    end = time.monotonic() + 60.0
    while True:
        try:
            return client.reset("go", CONTEXT)
        except PolicyFault:
            assert time.monotonic() < end
            time.sleep(0.05)


def test_addresses() -> None:
    """Other machines are kept out unless asked for, and what is not an address is refused."""
    for address in ("tcp://0.0.0.0:5555", "tcp://192.168.0.1:80", "tcp://127.evil.example:80"):
        with pytest.raises(ValueError, match="other machines"):
            listen(address)
    for address in ("tcp://127.0.0.1", "tcp://:80", "tcp://a:b", "tcp://a:99999", "udp://a:1", "", "tcp://a:-1"):
        with pytest.raises(ValueError, match="is not an address"):
            split_tcp(address)
    assert split_tcp("tcp://[::1]:80") == ("::1", 80)
    listen("tcp://0.0.0.0:0", anywhere=True).close()


def test_a_socket_is_the_users_own(tmp_path: Path) -> None:
    """Nobody else can open it, one that is in use is left alone, and so is a file."""
    listener = listen(f"unix:{tmp_path}/s")
    assert (tmp_path / "s").stat().st_mode & 0o077 == 0
    with pytest.raises(OSError):
        listen(f"unix:{tmp_path}/s")
    listener.close()
    listen(f"unix:{tmp_path}/s").close()
    (tmp_path / "file").write_text("precious")
    with pytest.raises(OSError):
        listen(f"unix:{tmp_path}/file")
    assert (tmp_path / "file").read_text() == "precious"


@pytest.mark.parametrize(
    "array",
    [np.zeros((0, 3)), np.array(2.5), np.array([True, False]), np.arange(6, dtype=">i4").reshape(2, 3).T,
     np.ones((4, 5), np.float16), np.array([2**63], np.uint64)],
)  # fmt: skip
def test_arrays_arrive_as_they_are(array: np.ndarray) -> None:
    """Shape, type and numbers, and they can be written to."""
    again = unpack(pack({"a": array})[4:])["a"]
    assert again.dtype == array.dtype.newbyteorder("<") and again.shape == array.shape and again.flags.writeable
    np.testing.assert_array_equal(again, array)


@pytest.mark.parametrize("value", [object(), np.array([object()]), np.array(["a"]), 1j, {1, 2}])
def test_what_cannot_travel_is_refused(value: Any) -> None:
    """No pickles, no text in arrays."""
    with pytest.raises(WireError, match="cannot be sent"):
        pack({"a": value})


def test_the_server_needs_numpy_and_msgpack_alone() -> None:
    """So that the file can be copied to where the policy lives."""
    tree = ast.parse(Path(policy_server.__file__).read_text(encoding="utf-8"))
    names = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
    names |= {n.module or "" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
    assert {name.split(".")[0] for name in names} - sys.stdlib_module_names == {"numpy", "msgpack"}


@pytest.mark.simulation
@pytest.mark.parametrize("before", [(), ("/bin/sh", "-c", "trap '' INT; exec \"$@\"", "sh")], ids=["", "SIGINT ignored"])
def test_the_command_serves_until_ctrl_c(tmp_path: Path, before: tuple[str, ...]) -> None:
    """`rlbench-pin serve` with a policy from a file, asked from here; also where a shell lets it ignore SIGINT."""
    root = str(Path(__file__).resolve().parents[3])
    command = [*before, sys.executable, "-m", "rlbench_pin.cli.main", "serve", OBEDIENT, "--address", f"unix:{tmp_path}/s"]
    with subprocess.Popen(command, cwd=tmp_path, env={**os.environ, "PYTHONPATH": root}, stdout=subprocess.PIPE) as server:
        assert server.stdout is not None
        assert b"is served at unix:" in server.stdout.readline()
        client = open_policy(f"unix:{tmp_path}/s", time_limit=10.0)
        client.reset("echo", CONTEXT)
        assert client.act(SEEN).tolist() == list(range(7))
        server.send_signal(signal.SIGINT)
        assert server.wait(20.0) == 130
    assert not (tmp_path / "s").exists()


assert callable(serve)  # what the processes above are started with
