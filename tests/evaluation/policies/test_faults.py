"""A policy that hangs, crashes or answers nonsense costs its episode, is named, and is there again at the next one."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.evaluation.policies import (
    PolicyClient,
    PolicyContext,
    PolicyFault,
    PolicyReferenceError,
    PolicySettingsError,
    open_policy,
)
from rlbench_pin.evaluation.policies.client import RemotePolicy
from rlbench_pin.evaluation.policies.policy_process import answers_for
from rlbench_pin.evaluation.policies.policy_server import Channel, converse
from rlbench_pin.observation import Observation
from tests.evaluation.policies.policies_for_tests import Obedient, foreign

FILE = Path(__file__).with_name("policies_for_tests.py")
OBEDIENT = f"{FILE}:Obedient"
CONTEXT = PolicyContext("panda", 7, (-1.0,) * 8, (1.0,) * 8, 0.05, 100, seed=1)
SEEN = Observation(joint_positions=np.arange(7.0))


class InThread:
    """A link to a policy in a thread, which costs no process."""

    lost = "crashed"

    def __init__(self, target: str) -> None:
        self.reference, self.opened = target, 0

    def open(self, timeout: float) -> Channel:
        """Start the thread."""
        self.opened += 1
        ours, theirs = socket.socketpair()
        threading.Thread(target=converse, args=(Channel(theirs), answers_for(self.reference)), daemon=True).start()
        return Channel(ours)

    def close(self, patience: float = 0.0) -> str:
        """The thread ends with its connection."""
        return ""

    def printed(self) -> str:
        """It prints to where this process does."""
        return ""


WRONG = {
    "nan": "NaN or infinity at index 1",
    "infinity": "NaN or infinity at index 1",
    "two dimensions": r"shape \(2, 4\)",
    "nothing": "NoneType",
    "nothing at all": r"shape \(0,\)",
    "text": "str",
    "ragged": "list",
    "objects": "list",
    "complex": "not an array of numbers",
}


@pytest.mark.parametrize("instruction", WRONG)
def test_wrong_answers_are_named(instruction: str) -> None:
    """In another process, or in this one: the same kind of fault; afterwards the policy begins anew."""
    link = InThread(OBEDIENT)
    for client in (RemotePolicy(link, 5.0, 5.0), open_policy(Obedient())):
        client.reset(instruction, CONTEXT)
        with pytest.raises(
            PolicyFault, match=WRONG[instruction] if isinstance(client, RemotePolicy) else "act. returned"
        ) as caught:
            client.act(SEEN)
        assert caught.value.kind == "wrong answer"
        client.reset("echo", CONTEXT)
        assert client.act(SEEN).tolist() == list(range(7)) and client.act(SEEN).dtype == np.float64
        client.close()
    assert link.opened == 2


@pytest.mark.parametrize("instruction", ["raise", "crash at once"])
def test_what_a_policy_raises_is_a_crash(instruction: str) -> None:
    """The last line of the traceback says what."""
    for client in (RemotePolicy(InThread(OBEDIENT), 5.0, 5.0), open_policy(Obedient())):
        with pytest.raises(PolicyFault, match="KeyError: 'no such thing'|ValueError: not today") as caught:
            client.reset(instruction, CONTEXT)
            client.act(SEEN)
        assert caught.value.kind == "crashed"
        client.reset("move", CONTEXT)
        client.close()


def test_an_action_after_a_fault_needs_a_reset() -> None:
    """Nothing is started behind the caller's back in the middle of an episode."""
    client = RemotePolicy(InThread(OBEDIENT), 5.0, 5.0)
    client.reset("nan", CONTEXT)
    for _ in range(2):
        with pytest.raises(PolicyFault):
            client.act(SEEN)


@pytest.mark.parametrize(
    ("factory", "kind", "says"),
    [
        ("no_policy", PolicyReferenceError, "returns a dict, which is not a policy: it has no reset"),
        ("broken", PolicyFault, "RuntimeError: the weights are missing"),
        ("foreign", PolicyReferenceError, "has to be one of this package"),
        ("Obedient?speed=3", PolicyReferenceError, "does not accept these arguments"),
        ("Missing", PolicyReferenceError, "has no 'Missing'"),
    ],
)
def test_policies_that_cannot_be_made(factory: str, kind: type[RlbenchPinError], says: str) -> None:
    """Each is an error of ours, raised before an episode."""
    with pytest.raises(kind, match=says):
        _ = RemotePolicy(InThread(f"{FILE}:{factory}"), 5.0, 5.0).settings
    with pytest.raises(PolicySettingsError):
        open_policy(foreign())


def test_instances_and_arguments() -> None:
    """What a reference names may be the policy itself, or be called with arguments, which are JSON or text."""
    for target, scale in ((f"{FILE}:INSTANCE", 0.25), (f"{OBEDIENT}?scale=2&name=%22a%20b%22", 2.0)):
        client = RemotePolicy(InThread(target), 5.0, 5.0)
        assert client.settings.max_steps == 7 and client.settings.observation == {"joint_positions": True, "joint_poses": True}
        client.reset("move", CONTEXT)
        assert client.act(SEEN).tolist() == [scale] * 8
        client.close()


def test_observations_arrive_whole_but_for_what_tells_the_task() -> None:
    """Images of five large cameras; of `misc` what sensors know, and neither the variation nor other instructions."""
    pictures = {f"{name}_rgb": np.zeros((512, 512, 3), np.uint8) for name in ("front", "wrist", "overhead")}
    clouds = {"front_point_cloud": np.zeros((512, 512, 3), np.float32), "front_depth": np.zeros((512, 512), np.float32)}
    large = Observation(**pictures, **clouds, front_mask=np.zeros((512, 512), np.int32))
    misc = {"variation_index": 3, "descriptions": ["a"], "front_camera_near": 0.1, "mask_names": {1: "cup"}, "secret": 1}
    for client in (RemotePolicy(InThread(OBEDIENT), 20.0, 5.0), open_policy(Obedient())):
        client.reset("count", CONTEXT)
        assert client.act(large)[0] == 512 * 512 * (3 * 3 + 3 + 1 + 1) + 1
        client.reset("entries", CONTEXT)
        assert client.act(Observation(misc=misc)).tolist() == [2.0, 0.0, 0.0]
        client.close()


@pytest.fixture(scope="module")
def hosted() -> Iterator[PolicyClient]:
    """A policy in a process of its own."""
    client = open_policy(f"{OBEDIENT}?name=Ann", time_limit=1.0)
    yield client
    client.close()


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("instruction", "kind", "says"),
    [
        ("sleep", "timed out", "`act` took longer than 1 s"),
        ("exit", "crashed", "exit code 3"),
        ("abort", "crashed", "SIGSEGV"),
        ("nan", "wrong answer", "NaN"),
    ],
)
def test_processes_that_hang_or_die(hosted: PolicyClient, instruction: str, kind: str, says: str) -> None:
    """The fault says how, with what was printed last; the next episode has a new process, and nothing of the old one is left."""
    hosted.reset("pid", CONTEXT)
    pid = hosted.act(SEEN)[0]
    assert os.getsid(int(pid)) == pid  # so that Ctrl-C is left to the owner
    hosted.reset(instruction, CONTEXT)
    began = time.monotonic()
    with pytest.raises(PolicyFault, match=says) as caught:
        hosted.act(SEEN)
    assert time.monotonic() - began < 5.0
    assert caught.value.kind == kind and f"Ann is asked to {instruction} with a panda" in caught.value.printed
    assert not Path(f"/proc/{int(pid)}").exists()
    hosted.reset("pid", CONTEXT)
    assert hosted.act(SEEN)[0] != pid


@pytest.mark.simulation
def test_a_policy_may_print(hosted: PolicyClient) -> None:
    """Two megabytes do not stop it, and the last lines are kept."""
    hosted.reset("print", CONTEXT)
    assert hosted.act(SEEN).tolist() == [0.5] * 8
    hosted.reset("raise", CONTEXT)
    with pytest.raises(PolicyFault) as caught:
        hosted.act(SEEN)
    assert "no such thing" in caught.value.printed and len(caught.value.printed) < 10_000


OWNER = """
import sys, time
from rlbench_pin.evaluation.policies import open_policy
from tests.evaluation.policies.test_faults import CONTEXT, SEEN
client = open_policy(sys.argv[1], time_limit=100.0)
client.reset("pid", CONTEXT)
sys.stdout.write(f"{int(client.act(SEEN)[0])}\\n")
sys.stdout.flush()
client.reset("sleep", CONTEXT)
client.act(SEEN)
"""


@pytest.mark.simulation
def test_the_process_ends_with_its_owner() -> None:
    """The owner is killed while the policy is asleep: the policy ends too, at once."""
    root = Path(__file__).resolve().parents[3]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    command = [sys.executable, "-c", textwrap.dedent(OWNER), OBEDIENT]
    owner = subprocess.Popen(command, stdout=subprocess.PIPE, cwd=root, env=environment)
    assert owner.stdout is not None
    pid = int(owner.stdout.readline())
    time.sleep(0.2)
    assert Path(f"/proc/{pid}").exists()
    owner.send_signal(signal.SIGKILL)
    owner.communicate()
    end = time.monotonic() + 5.0
    while _runs(pid) and time.monotonic() < end:
        time.sleep(0.02)
    assert not _runs(pid)


def _runs(pid: int) -> bool:
    """Whether a process is there, and more than a name that nobody has waited for."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
