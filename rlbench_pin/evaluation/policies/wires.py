"""Clients of policies that are served by openpi or vla-eval: msgpack over WebSocket, with a mapping of keys and actions.

Data from a server are untrusted: the size of frames is limited, arrays are checked before they are made, and no data are
unpickled.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import re
import socket
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count
from types import ModuleType
from typing import Any, Literal, NoReturn
from urllib.parse import parse_qsl

import msgpack
import numpy as np

from rlbench_pin.errors import MissingExtra, nearest_name
from rlbench_pin.evaluation.policies.mapping import (
    LONGEST_CHUNK,
    ROTATIONS,
    MappingError,
    PolicyMapping,
    load_mapping,
    mapping_names,
)
from rlbench_pin.evaluation.policies.policy import LONGEST_DETAIL, FaultKind, PolicyContext, PolicyFault, PolicyReferenceError
from rlbench_pin.evaluation.policies.policy_server import WireError, split_tcp
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.policies.wire import decode_observation, validate_action, visible_fields
from rlbench_pin.observation import Observation

SCHEMES = ("openpi", "vla-eval")
"""Schemes of addresses."""
LARGEST_FRAME = 64 * 2**20
"""Maximum size of a frame of a server [bytes]."""
MOST_CONTAINERS = 100_000
"""Maximum number of maps and lists in a frame."""
CONNECT_LIMIT = 10.0
"""Time limit for a connection [s]."""
CLOSE_LIMIT = 2.0
"""Time limit for the end of a connection [s]."""
VLA_EVAL_VERSION = 1
"""Version of vla-eval's protocol."""
_DTYPE = re.compile(r"[<>|=]?([biu][1248]|f[248])|\|?b1")
_MOST_DIMENSIONS = 8
_BROKEN = (1002, 1007, 1009)
"""Close codes that this side sends after an invalid or too long frame."""


@dataclass(frozen=True)
class WireAddress:
    """Address of a server, and the mapping of its policy."""

    scheme: Literal["openpi", "vla-eval"]
    """Protocol of the server."""
    host: str
    """Host name, or IP address."""
    port: int
    """TCP port."""
    mapping: PolicyMapping
    """Keys and layout of actions, with `replan` of the reference."""
    token: str = ""
    """Key that is sent in the header `Authorization`; empty sends none."""

    def __str__(self) -> str:
        """Return the address without its arguments, so that the token is not shown."""
        return f"{self.scheme}://{f'[{self.host}]' if ':' in self.host else self.host}:{self.port}"


def parse_address(reference: str) -> WireAddress:
    """Return the address in `openpi://HOST:PORT?mapping=NAME&replan=N&token=TOKEN`, or in the same form with `vla-eval`.

    Args:
        reference: The reference. `mapping` is a preset or a TOML file. `replan` replaces that of the mapping. `token=env:NAME`
            reads the token from an environment variable, so that results files do not contain it.

    Raises:
        PolicyReferenceError: An invalid address, an unknown or missing argument, or a wrong value.
        UnknownName: No preset has this name; proposes the nearest name.
        MappingError: The mapping file is missing, or is not a mapping.
        MissingExtra: The library `websockets` is not installed.
    """
    scheme, _, rest = reference.partition("://")
    place, _, query = rest.partition("?")
    try:
        host, port = split_tcp(f"tcp://{place}")
    except ValueError:
        hint = f"Write `{scheme.rstrip(':')}://HOST:PORT?mapping=NAME`, such as `openpi://127.0.0.1:8000?mapping=libero`."
        raise PolicyReferenceError(reference, "has no valid address", hint) from None
    arguments = _arguments(reference, query)
    if "mapping" not in arguments:
        hint = f"Write `?mapping=NAME` with one of {', '.join(mapping_names())}, or `?mapping=FILE.toml`."
        raise PolicyReferenceError(reference, "needs a mapping of keys and actions", hint)
    mapping = load_mapping(arguments["mapping"])
    if "replan" in arguments:
        text = arguments["replan"]
        if not text.isascii() or not text.isdigit() or not 1 <= int(text[:9]) <= LONGEST_CHUNK:
            hint = f"Use the number of actions to play before the next request, 1 to {LONGEST_CHUNK}."
            raise PolicyReferenceError(reference, f"has a wrong `replan`: '{text}'", hint)
        mapping = replace(mapping, replan=int(text))
    _library()
    return WireAddress(scheme, host, port, mapping, _token(reference, arguments.get("token", "")))  # type: ignore[arg-type]


def _arguments(reference: str, query: str) -> dict[str, str]:
    known = ("mapping", "replan", "token")
    pairs = parse_qsl(query, keep_blank_values=True)
    found = dict(pairs)
    if query and len(found) != query.count("&") + 1:
        raise PolicyReferenceError(reference, "has arguments in another form than `key=value&...`, each key once")
    for key, value in pairs:
        if key not in known:
            near = nearest_name(key, known)
            hint = f"Did you mean '{near}'?" if near else f"Known: {', '.join(known)}."
            raise PolicyReferenceError(reference, f"has an unknown argument '{key}'", hint)
        if not value:
            raise PolicyReferenceError(
                reference, f"has no value for the argument '{key}'", f"Write `{key}=VALUE`, or leave it out."
            )
    return found


def _token(reference: str, text: str) -> str:
    if not text.startswith("env:"):
        return text
    token = os.environ.get(text.removeprefix("env:"), "")
    if not token:
        problem = f"needs the environment variable '{text.removeprefix('env:')}', which is not set"
        raise PolicyReferenceError(reference, problem, "Set it to the token.")
    return token


def _library() -> tuple[ModuleType, ModuleType]:
    """Return two modules of `websockets`: the client, and the errors."""
    try:
        return importlib.import_module("websockets.sync.client"), importlib.import_module("websockets.exceptions")
    except ModuleNotFoundError as error:
        raise MissingExtra("A policy served by openpi or vla-eval", "websockets", "wires") from error


# Frames -----------------------------------------------------------------------------------------------------------------------


def encode_openpi(message: object) -> bytes:
    """Return a message of openpi as msgpack; arrays are maps with `__ndarray__`, `data`, `dtype` and `shape`, keys as bytes."""
    encoded: bytes = msgpack.packb(message, default=lambda value: {k.encode(): v for k, v in _array_map(value).items()})
    return encoded


def encode_vla_eval(message: object) -> bytes:
    """Return a message of vla-eval as msgpack; arrays as in openpi, with keys as text."""
    encoded: bytes = msgpack.packb(message, default=_array_map)
    return encoded


def _array_map(value: object) -> dict[str, Any]:
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        return {"__ndarray__": True, "data": value.tobytes(), "dtype": value.dtype.str, "shape": list(value.shape)}
    raise WireError(f"A {type(value).__name__} cannot be sent. Use arrays of numbers, numbers, text, lists and maps.")


def decode_frame(frame: bytes) -> Any:
    """Return the message in a frame of openpi or vla-eval.

    Raises:
        WireError: The frame is not msgpack, or has too many maps and lists, which need far more memory than their bytes. Or it
            contains an array of objects, or an array whose size does not match its shape.
    """
    containers = count()

    def counted(found: Any) -> Any:
        if next(containers) >= MOST_CONTAINERS:
            raise WireError(f"A frame has more than {MOST_CONTAINERS} maps and lists.")
        return _from_map(found) if isinstance(found, dict) else found

    try:
        return msgpack.unpackb(frame, object_hook=counted, list_hook=counted, raw=False, strict_map_key=False)
    except WireError:
        raise
    except Exception as error:  # what msgpack raises depends on what is wrong
        raise WireError(f"A frame of {len(frame)} bytes is not msgpack: {type(error).__name__}: {error}") from error


def _from_map(found: dict[Any, Any]) -> Any:
    """Return the array or number in a map with the marker of one, otherwise the map."""
    if not found.keys() & {"__ndarray__", b"__ndarray__", "__npgeneric__", b"__npgeneric__"}:
        return found
    parts = {key.decode(errors="replace") if isinstance(key, bytes) else key: value for key, value in found.items()}
    name, data = parts.get("dtype"), parts.get("data")
    if isinstance(name, bytes):
        name = name.decode(errors="replace")
    if not isinstance(name, str) or not _DTYPE.fullmatch(name):
        raise WireError(f"An array of the type {str(name)[:40]!r} is refused. Use numbers or truth values.")
    dtype = np.dtype(name)
    if "__npgeneric__" in parts:
        if not isinstance(data, bool | int | float):
            raise WireError(f"A number of the type {name} has the value of a {type(data).__name__}.")
        return data
    shape = parts.get("shape")
    if not isinstance(shape, list) or len(shape) > _MOST_DIMENSIONS or not all(type(n) is int and n >= 0 for n in shape):
        raise WireError("An array has no valid shape.")
    if not isinstance(data, bytes) or len(data) != math.prod(shape) * dtype.itemsize:
        had = len(data) if isinstance(data, bytes) else 0
        raise WireError(f"An array of {name} and shape {tuple(shape)} has the wrong size, {had} bytes.")
    return np.frombuffer(data, dtype).reshape(shape)


# The policy -------------------------------------------------------------------------------------------------------------------


class WirePolicy:
    """A policy behind a WebSocket. It connects again after a fault, or after the server has ended the connection.

    Args:
        address: Address of the server, with the mapping.
        time_limit: Time limit for `reset` and `act` [s].
        start_limit: Time limit for the connection, until the server has sent its metadata [s].
    """

    def __init__(self, address: WireAddress, time_limit: float, start_limit: float) -> None:
        self._address, self._time_limit, self._start_limit = address, time_limit, start_limit
        self._mapping = address.mapping
        self._connection: Any = None
        self._settings: PolicySettings | None = None
        self._chunk: list[np.ndarray] = []
        self._instruction, self._seq, self._in_episode = "", 0, False

    @property
    def mapping(self) -> PolicyMapping:
        """Keys and layout of actions."""
        return self._mapping

    @property
    def settings(self) -> PolicySettings:
        """Settings of the mapping; the first access connects.

        Raises:
            PolicyFault: The server cannot be reached.
            MappingError: The keys or actions of the server differ from those of the mapping.
        """
        if self._settings is None:
            self._connect()
            mapping = self._mapping
            self._settings = PolicySettings.of(mapping.action.action_mode(), mapping.obs_config(), mapping.max_steps)
        return self._settings

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode; connects if there is no connection."""
        _ = self.settings
        if self._connection is not None and self._connection.protocol.close_code is not None:
            self._drop()  # the server has ended it since the last episode
        if self._connection is None:
            try:
                self._connect()
            except MappingError as error:
                self._fail("wrong answer", f"After a new connection, its metadata differ from before: {error}")
        layout = self._mapping.action
        if not layout.is_pose and layout.joints != context.joints:
            self._fail(
                "wrong answer",
                f"The mapping '{self._mapping.source}' is for {layout.joints} joints, the arm has {context.joints}.",
            )
        self._instruction, self._chunk = instruction, []
        if self._address.scheme == "vla-eval":
            if self._in_episode:
                self._exchange("reset", self._time_limit, self._frame("episode_end", {}), answered=False)
            task = {"name": context.task or instruction, "instruction": instruction}
            self._exchange("reset", self._time_limit, self._frame("episode_start", {"task": task}), answered=False)
        self._in_episode = True

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action of the chunk, or the first action of a new chunk, float64 (n,)."""
        values = self.next_values(observation)
        try:
            return validate_action(self._mapping.action.decode(values))
        except ValueError as error:
            self._fail("wrong answer", f"An action cannot be used: {error}.")

    def next_values(self, observation: Observation) -> np.ndarray:
        """Return the numbers of the next action as the server sends them, float64, with the size of the mapping's action."""
        if self._connection is None:
            raise PolicyFault("unreachable", "It has ended.", "`reset` connects again.")
        if not self._chunk:
            seen = self._mapping.encode(decode_observation(visible_fields(observation)), self._instruction)
            self._chunk = self._played(self._ask(seen))
        return self._chunk.pop(0)

    def close(self) -> None:
        """End the connection; `reset` connects again."""
        self._drop()

    # Messages

    def _ask(self, seen: dict[str, Any]) -> Any:
        """Return the reply to an observation."""
        if self._address.scheme == "openpi":
            return self._exchange("act", self._time_limit, encode_openpi(seen))
        return self._payload(self._exchange("act", self._time_limit, self._frame("observation", seen)), "action")

    def _frame(self, kind: str, payload: dict[str, Any]) -> bytes:
        self._seq += 1
        return encode_vla_eval({"type": kind, "payload": payload, "seq": self._seq, "timestamp": time.time()})

    def _payload(self, message: Any, kind: str) -> Any:
        """Return the payload of a message of vla-eval, after its type and number are checked."""
        found = message.get("type") if isinstance(message, Mapping) else None
        payload = message.get("payload") if isinstance(message, Mapping) else None
        if found == "error":
            said = payload.get("error") if isinstance(payload, Mapping) else payload
            self._fail("crashed", f"The server says: {str(said)[:LONGEST_DETAIL]}")
        if found != kind or not isinstance(payload, Mapping):
            self._fail("wrong answer", f"A message of the type '{kind}' was expected, not {str(found)[:40]!r}.")
        if message.get("seq") != self._seq:
            self._fail("wrong answer", f"The reply has number {str(message.get('seq'))[:40]}, the request {self._seq}.")
        return payload

    def _played(self, answer: Any) -> list[np.ndarray]:
        """Return the actions of a reply that are played before the next request."""
        try:
            return list(self._mapping.chunk(answer, self._mapping.replan))
        except ValueError as error:
            self._fail("wrong answer", str(error))

    # Connection

    def _connect(self) -> None:
        """Connect, and check the metadata of the server."""
        client, errors = _library()
        address, end = self._address, time.monotonic() + self._start_limit
        self._in_episode, self._seq = False, 0
        headers = {"Authorization": f"Api-Key {address.token}"} if address.token else None
        try:
            connected = socket.create_connection((address.host, address.port), min(CONNECT_LIMIT, self._start_limit))
            connected.settimeout(None)
            host = f"[{address.host}]" if ":" in address.host else address.host
            self._connection = client.connect(
                f"ws://{host}:{address.port}", sock=connected, compression=None, max_size=LARGEST_FRAME, close_timeout=1.0,
                open_timeout=self._start_limit, additional_headers=headers, ping_interval=None, max_queue=1,
            )  # fmt: skip
        except TimeoutError as error:
            raise PolicyFault("timed out", f"{address} does not answer.", _START) from error
        except (OSError, ValueError, EOFError, errors.WebSocketException) as error:
            status = getattr(getattr(error, "response", None), "status_code", None)
            hint = "Pass its key with `token=`." if status in (401, 403) else _START
            said = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
            raise PolicyFault("unreachable", f"There is no connection to {address}: {said[:200].rstrip('.')}.", hint) from error
        left = max(0.1, end - time.monotonic())
        if address.scheme == "openpi":
            said = self._exchange("hello", left)
        else:
            hello = {"harness_version": "rlbench_pin", "protocol_version": VLA_EVAL_VERSION}
            said = self._payload(self._exchange("hello", left, self._frame("hello", hello)), "hello")
        if not isinstance(said, Mapping):
            self._fail(
                "wrong answer", f"The server sends a {type(said).__name__} at the start of a connection, not a map of metadata."
            )
        try:
            (check_openpi if address.scheme == "openpi" else check_vla_eval)(self._mapping, said)
        except BaseException:
            self._drop()
            raise

    def _exchange(self, call: str, limit: float, frame: bytes | None = None, *, answered: bool = True) -> Any:
        """Send a frame and return the answer, or end the connection and raise PolicyFault."""
        _, errors = _library()
        with _cut_off(self._connection, limit) as cut:
            try:
                if frame is not None:
                    self._connection.send(frame)
                answer = self._connection.recv() if answered else b"\xc0"
            except (errors.WebSocketException, OSError, EOFError) as error:
                if cut.is_set():
                    self._fail("timed out", f"`{call}` took longer than {limit:g} s.")
                self._ended(call, error)
            except BaseException:  # Ctrl-C: the answer would be mistaken for that to the next request
                self._drop()
                raise
        if isinstance(answer, str):
            lines = answer.strip().splitlines() or ["an empty text"]
            self._fail("crashed", f"The server says: {lines[-1][:LONGEST_DETAIL]}", answer[-LONGEST_DETAIL:])
        try:
            return decode_frame(answer)
        except WireError as error:
            self._fail("wrong answer", str(error))

    def _ended(self, call: str, error: Exception) -> NoReturn:
        """Raise the fault of a connection that has ended."""
        sent, received = getattr(error, "sent", None), getattr(error, "rcvd", None)
        if sent is not None and received is None and sent.code in _BROKEN:
            self._fail(
                "wrong answer", f"A frame is broken or larger than {LARGEST_FRAME} bytes: {sent.reason[:200] or sent.code}."
            )
        said = f" The server gave code {received.code} {received.reason[:200]!r}." if received is not None else ""
        self._fail("unreachable", f"The connection ended during `{call}`.{said}")

    def _fail(self, kind: FaultKind, detail: str, printed: str = "") -> NoReturn:
        self._drop()
        raise PolicyFault(kind, detail, printed=printed)

    def _drop(self) -> None:
        connection, self._connection = self._connection, None
        self._chunk, self._in_episode = [], False
        if connection is not None:
            with contextlib.suppress(Exception), _cut_off(connection, CLOSE_LIMIT):  # the connection is not used again
                connection.close()


@contextlib.contextmanager
def _cut_off(connection: Any, limit: float) -> Iterator[threading.Event]:
    """Shut a connection down if the block takes longer than a limit [s], because sending has no time limit."""
    cut = threading.Event()

    def stop() -> None:
        cut.set()
        with contextlib.suppress(OSError):
            connection.socket.shutdown(socket.SHUT_RDWR)

    timer = threading.Timer(limit, stop)
    timer.daemon = True
    timer.start()
    try:
        yield cut
    finally:
        timer.cancel()


_START = "Start the server of the policy, and check host and port."


# Checks at connect ------------------------------------------------------------------------------------------------------------

_ACTION_SPACES = {
    "joint_position": ("joint_positions",),
    "joint_velocity": ("joint_velocities",),
    "cartesian_position": ("absolute_pose",),
}
_POSITIONS = {"delta_xyz": "delta_pose", "absolute_xyz": "absolute_pose"}
_ROTATIONS = {
    "axis_angle": "axis_angle",
    "euler_xyz": "euler_rpy",
    "quaternion_xyzw": "quaternion_xyzw",
    "rot6d_interleaved": "six_interleaved",
}
_GRIPPERS = {
    "binary_close_positive": (-1.0, 1.0),
    "binary_close_negative": (1.0, -1.0),
    "binary_close_01": (0.0, 1.0),
}
_JOINTS = {"joint_velocities": "joint_velocity", "joint_deltas": "joint_delta_pos"}
_STATE_FORMATS = {
    ("tip_position", "tip_axis_angle", "fingers_mirrored"): "eef_pos3_axisangle3_gripper2",
    ("tip_position", "tip_euler_rpy", "fingers_mirrored"): "eef_pos3_euler3_gripper2",
    ("tip_position", "tip_quaternion_xyzw", "gripper_open"): "eef_pos3_quat4_gripper1",
    ("joint_positions",): "joint_positions",
}


def check_openpi(mapping: PolicyMapping, metadata: Mapping[Any, Any]) -> None:
    """Compare a mapping with the metadata of a server of openpi; most servers send none.

    Args:
        mapping: The mapping.
        metadata: Metadata. `action_dim`, `action_space`, `observation_keys` and `image_resolution` (height, width [px]) are
            compared.

    Raises:
        MappingError: The mapping contradicts the metadata.
    """
    if metadata.get("needs_session_id") is True:
        hint = "Use a server without session numbers."
        raise MappingError("'needs_session_id' of the server of openpi", True, "is not supported", hint)
    _check(mapping, "action", "action_dim", metadata.get("action_dim"), mapping.action.size)
    space = metadata.get("action_space")
    if isinstance(space, str) and mapping.action.arm not in _ACTION_SPACES.get(space, (mapping.action.arm,)):
        _differ(mapping, "action.arm", mapping.action.arm, f"'action_space' {space!r}")
    wanted = metadata.get("observation_keys")
    for key in wanted if isinstance(wanted, list) else ():
        _check_key(mapping, key)
    resolution = metadata.get("image_resolution")
    if isinstance(resolution, list) and len(resolution) == 2:
        for key, image in mapping.images.items():
            if list(image.sent_size[::-1]) != resolution:
                _differ(mapping, f"images.{key}", image.sent_size, f"images of height and width {resolution} px")


def check_vla_eval(mapping: PolicyMapping, hello: Mapping[Any, Any]) -> None:
    """Compare a mapping with the answer of a server of vla-eval to `hello`.

    Args:
        mapping: The mapping.
        hello: The answer, with `protocol_version`, and optionally `action_spec` and `observation_spec`. Formats without a fixed
            meaning, such as `raw`, are not compared.

    Raises:
        MappingError: The mapping contradicts the answer.
    """
    version = hello.get("protocol_version", VLA_EVAL_VERSION)
    if version != VLA_EVAL_VERSION:
        problem = f"has to have version {VLA_EVAL_VERSION} of the protocol"
        raise MappingError("A server of vla-eval", version, problem, "Use another release of vla-eval.")
    action, layout = _specs(hello.get("action_spec")), mapping.action
    sizes = [spec.get("dims") for spec in action.values()]
    if sizes and all(type(size) is int and size > 0 for size in sizes):
        _check(mapping, "action", "the sum of 'dims'", sum(sizes), layout.size)  # type: ignore[arg-type]
    arm = _POSITIONS.get(str(action.get("position", {}).get("format")))
    rotation = _ROTATIONS.get(str(action.get("rotation", {}).get("format")))
    gripper = _GRIPPERS.get(str(action.get("gripper", {}).get("format")))
    _check(mapping, "action.arm", "the format of 'position'", arm, layout.arm)
    _check(mapping, "action.rotation", "the format of 'rotation'", rotation, layout.rotation)
    if gripper is not None and (layout.gripper_open < layout.gripper_closed) != (gripper[0] < gripper[1]):
        said = f"a gripper that is open at {gripper[0]:g} and closed at {gripper[1]:g}"
        _differ(mapping, "action.gripper_open", layout.gripper_open, said)
    state = _specs(hello.get("observation_spec")).get("state", {}).get("dims")
    for key in mapping.states:
        if key in ("state", "states") and type(state) is int and state > 0 and mapping.state_size(key) is not None:
            _check(mapping, f"states.{key}", "'state'", state, mapping.state_size(key))


def vla_eval_specs(mapping: PolicyMapping) -> dict[str, dict[str, dict[str, Any]]]:
    """Return a mapping in the format of vla-eval's `hello`: `action_spec` and `observation_spec`.

    Each is name -> `name`, `dims` and `format`. Conventions without a name in vla-eval have the name in our mappings.

    Args:
        mapping: The mapping.
    """
    layout = mapping.action
    gripper = {pair: word for word, pair in _GRIPPERS.items()}.get((layout.gripper_open, layout.gripper_closed), "raw")
    if layout.is_pose:
        arm = _spec("position", 3, {arm: word for word, arm in _POSITIONS.items()}[layout.arm])
        words = {rotation: word for word, rotation in _ROTATIONS.items()}
        arm |= _spec("rotation", ROTATIONS[layout.rotation], words.get(layout.rotation, layout.rotation))
    else:
        arm = _spec("joints", layout.joints, _JOINTS.get(layout.arm, layout.arm))
    seen = {"language": {"name": "language", "dims": 0, "format": "language"}}
    for key, image in mapping.images.items():
        seen |= _spec(key.removeprefix("images."), 0, "rgb_hwc_uint8" if image.product == "rgb" else image.product, "image")
    for key, parts in mapping.states.items():
        seen |= _spec(
            "state" if key == "states" else key, mapping.state_size(key) or 0, _STATE_FORMATS.get(parts, "+".join(parts)), "state"
        )
    return {"action_spec": arm | _spec("gripper", 1, gripper), "observation_spec": seen}


def _spec(key: str, dims: int, form: str, name: str = "") -> dict[str, dict[str, Any]]:
    return {key: {"name": name or key, "dims": dims, "format": form}}


def _specs(value: object) -> dict[str, Mapping[Any, Any]]:
    entries = value.items() if isinstance(value, Mapping) else ()
    return {str(name): spec for name, spec in entries if isinstance(spec, Mapping)}


def _check(mapping: PolicyMapping, where: str, what: str, said: object, ours: object) -> None:
    if said is not None and said != ours:
        _differ(mapping, where, ours, f"{what} {str(said)[:80]}")


def _check_key(mapping: PolicyMapping, key: object) -> None:
    if key not in mapping.keys:
        problem = f"lacks the key {str(key)[:80]!r}, which the server needs"
        raise MappingError(f"The mapping '{mapping.source}'", mapping.keys, problem, "Add it to the mapping, or use another.")


def _differ(mapping: PolicyMapping, where: str, ours: object, said: str) -> NoReturn:
    raise MappingError(f"{mapping.source}: '{where}'", ours, f"contradicts the server, which has {said}", "Use another mapping.")
