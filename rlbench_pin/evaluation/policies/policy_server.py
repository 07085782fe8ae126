"""A server for a policy. This file needs only numpy and msgpack: copy it into the environment of the policy, and serve it there.

    from policy_server import serve
    serve(MyPolicy, "unix:/tmp/policy.sock")

A message is its length, in four bytes with the highest first, then a msgpack map. Arrays have extension type 1, a list of numpy's
name of their type, their shape and their bytes in C order. The evaluation sends requests, and the policy answers each:

    {"call": "hello", "version": 1}                                {"ok": {"version", "action_mode", "observation", "max_steps",
                                                                           "joint_names"}}
    {"call": "reset", "instruction": text, "context": map}         {"ok": None}
    {"call": "act", "observation": map}                            {"ok": array of shape (n,)}

The answer to a failed request is `{"error": text, "kind": "crashed" | "wrong answer" | "wrong question"}`.
An observation contains the fields that are on, by name, and `misc`. A context contains the fields of `PolicyContext`.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import socket
import stat
import struct
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from types import SimpleNamespace, TracebackType
from typing import Any

import msgpack
import numpy as np

VERSION = 1
"""Version of the protocol."""
LARGEST_MESSAGE = 256 * 2**20
"""Maximum size of a message [bytes]; five cameras of 512 x 512 px with all their products take 30 MB."""
MAX_CONNECTIONS = 32
"""Maximum number of simultaneous connections; each has its own policy."""
_ARRAY = 1
_KINDS = "biuf"
"""Kinds of arrays that can be sent: truth values, whole numbers with and without sign, and floating-point numbers."""


class WireError(ValueError):
    """Bytes that are not a message, or a message that cannot be sent."""


class NoPolicy(ValueError):
    """The object is not a policy."""


# Messages ---------------------------------------------------------------------------------------------------------------------


def pack(message: Mapping[str, Any]) -> bytes:
    """Return a message as bytes, with its length first, or raise WireError."""
    body: bytes = msgpack.packb(message, default=_as_extension, use_bin_type=True)
    if len(body) > LARGEST_MESSAGE:
        raise WireError(f"A message of {len(body)} bytes is too long; the maximum is {LARGEST_MESSAGE}. Use smaller images.")
    return struct.pack(">I", len(body)) + body


def unpack(body: bytes) -> dict[str, Any]:
    """Return the message in bytes that follow a length, or raise WireError; tuples become lists."""
    try:
        message = msgpack.unpackb(body, ext_hook=_from_extension, raw=False, strict_map_key=False)
    except Exception as error:  # what msgpack raises depends on what is wrong
        raise WireError(f"These bytes are not a message: {type(error).__name__}: {error}") from error
    if not isinstance(message, dict):
        raise WireError(f"A message must be a map, not {type(message).__name__}.")
    return message


def _as_extension(value: object) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if not isinstance(value, np.ndarray) or value.dtype.kind not in _KINDS:
        raise WireError(f"A {type(value).__name__} cannot be sent. Use arrays of numbers, numbers, text, lists and maps.")
    parts = [value.dtype.newbyteorder("<").str, list(value.shape), np.ascontiguousarray(value, value.dtype.newbyteorder("<"))]
    return msgpack.ExtType(_ARRAY, msgpack.packb([*parts[:2], parts[2].tobytes()]))


def _from_extension(code: int, data: bytes) -> np.ndarray:
    if code != _ARRAY:
        raise WireError(f"there is no extension type {code}")
    name, shape, content = msgpack.unpackb(data)
    dtype = np.dtype(name)
    if dtype.kind not in _KINDS or dtype.hasobject or not all(isinstance(n, int) and n >= 0 for n in shape):
        raise WireError(f"an array of {dtype} and shape {shape} is not valid")
    return np.frombuffer(content, dtype).reshape(shape).copy()


class Channel:
    """Messages over a connected socket; the channel closes the socket."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection

    def send(self, message: Mapping[str, Any], timeout: float | None = None) -> None:
        """Send a message. Raise OSError if the connection has ended, or if it took longer than the timeout [s]."""
        self._socket.settimeout(timeout)
        self._socket.sendall(pack(message))

    def receive(self, timeout: float | None = None) -> dict[str, Any]:
        """Wait for a whole message, and return it.

        Raises:
            TimeoutError: The message was not complete after `timeout` [s].
            EOFError: The other side has closed the connection.
            OSError: The connection has ended for another reason.
            WireError: The received bytes are not a message.
        """
        end = None if timeout is None else time.monotonic() + timeout
        (length,) = struct.unpack(">I", self._exactly(4, end))
        if length > LARGEST_MESSAGE:
            raise WireError(f"A message of {length} bytes was announced; the maximum is {LARGEST_MESSAGE}. Use smaller images.")
        return unpack(self._exactly(length, end))

    def _exactly(self, count: int, end: float | None) -> bytes:
        read = bytearray()
        while len(read) < count:
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0.0:
                raise TimeoutError("timed out")
            self._socket.settimeout(left)
            part = self._socket.recv(min(count - len(read), 2**18))
            if not part:
                raise EOFError("the connection was closed")
            read += part
        return bytes(read)

    def close(self) -> None:
        """Close the connection; several calls are allowed."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


# Policies ---------------------------------------------------------------------------------------------------------------------


class Answers:
    """Answers the requests of one evaluation with one policy, which is made at the first request.

    Args:
        make: Makes the policy.
        describe: Returns the settings of the policy as plain data.
        observation: Makes the argument of `act` from a map of fields.
        context: Makes the second argument of `reset` from a map of fields.
    """

    def __init__(
        self,
        make: Callable[[], Any],
        describe: Callable[[Any], Mapping[str, Any]] | None = None,
        observation: Callable[[dict[str, Any]], Any] = lambda fields: SimpleNamespace(**fields),
        context: Callable[[dict[str, Any]], Any] = lambda fields: SimpleNamespace(**fields),
    ) -> None:
        self._make, self._describe, self._policy = make, describe or plain_settings, None
        self._observation, self._context = observation, context

    def to(self, question: Mapping[str, Any]) -> dict[str, Any]:
        """Return the answer to a request."""
        calls = {"hello": self._hello, "reset": self._reset, "act": self._act}
        call = question.get("call")
        if not isinstance(call, str) or call not in calls:
            return {"error": f"There is no call {str(call)[:60]!r}. Use {', '.join(calls)}.", "kind": "wrong question"}
        try:
            return calls[call](question)
        except NoPolicy as error:
            return {"error": str(error), "kind": "wrong question"}
        except Exception as error:  # whatever the policy raises
            traceback.print_exception(type(error), error, _own_frames(error))
            return {"error": describe_error(error), "kind": "crashed"}

    def _hello(self, question: Mapping[str, Any]) -> dict[str, Any]:
        if question.get("version") != VERSION:
            problem = f"This policy server has version {VERSION} of the protocol, not {str(question.get('version'))[:20]}."
            return {"error": f"{problem} Use the policy_server.py of the same rlbench_pin.", "kind": "wrong question"}
        return {"ok": {"version": VERSION, **self._describe(self._known())}}

    def _reset(self, question: Mapping[str, Any]) -> dict[str, Any]:
        instruction, context = question.get("instruction"), question.get("context")
        if not isinstance(instruction, str) or not isinstance(context, dict):
            return {"error": "`reset` needs an instruction, a text, and a context, a map.", "kind": "wrong question"}
        self._known().reset(instruction, self._context(context))
        return {"ok": None}

    def _act(self, question: Mapping[str, Any]) -> dict[str, Any]:
        fields = question.get("observation")
        if not isinstance(fields, dict) or not all(isinstance(name, str) for name in fields):
            return {"error": "`act` needs an observation, a map with names as keys.", "kind": "wrong question"}
        action = self._known().act(self._observation(fields))
        try:
            array = np.asarray(action)
        except Exception as error:  # objects of other libraries
            return {"error": f"`act` returned a {type(action).__name__}, not an array: {error}", "kind": "wrong answer"}
        if array.dtype.kind not in _KINDS:  # cannot be sent
            return {"error": f"`act` returned a {type(action).__name__}, not an array of numbers.", "kind": "wrong answer"}
        return {"ok": array}

    def _known(self) -> Any:
        if self._policy is None:
            self._policy = self._make()
        return self._policy


def describe_error(error: BaseException) -> str:
    """Return one line with class, message, file and line of an error, such as `ValueError: no (file.py, line 3)`."""
    text, frames = " ".join(f"{type(error).__name__}: {error}".split()), traceback.extract_tb(_own_frames(error))
    if isinstance(error, SyntaxError) or not frames:  # its message says where
        return text
    return f"{text} ({os.path.basename(frames[-1].filename)}, line {frames[-1].lineno})"


def _own_frames(error: BaseException) -> TracebackType | None:
    """Return the traceback of an error without the frames that called the policy."""
    rest = error.__traceback__
    while rest is not None and rest.tb_frame.f_code.co_filename.startswith((os.path.dirname(__file__), "<frozen")):
        rest = rest.tb_next
    return rest


def plain_settings(policy: Any) -> dict[str, Any]:
    """Return the settings of a policy whose attributes are plain data, or raise NoPolicy."""
    mode, seen = policy.action_mode, policy.obs_config
    if not isinstance(mode, Mapping) or not isinstance(seen, Mapping):
        raise NoPolicy("Without rlbench_pin, `action_mode` and `obs_config` of a policy must be maps of plain data.")
    optional = {name: getattr(policy, name, None) for name in ("max_steps", "joint_names")}
    return {"action_mode": dict(mode), "observation": dict(seen), **optional}


# Serving ----------------------------------------------------------------------------------------------------------------------


def converse(channel: Channel, answers: Answers) -> None:
    """Answer requests until the other side closes the connection, or sends bytes that are not a message."""
    with contextlib.closing(channel), contextlib.suppress(EOFError, OSError):
        while True:
            try:
                question = channel.receive()
            except WireError as error:
                channel.send({"error": str(error), "kind": "wrong question"}, timeout=10.0)
                break
            try:
                channel.send(answers.to(question))
            except WireError as error:  # an answer that is too long
                channel.send({"error": str(error), "kind": "wrong answer"})


def split_tcp(address: str) -> tuple[str, int]:
    """Return host and port of `tcp://HOST:PORT`, or raise ValueError; an IPv6 address has brackets."""
    host, _, port = address.removeprefix("tcp://").rpartition(":")
    if not address.startswith("tcp://") or not host or not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise ValueError(f"'{address}' is not an address. Use unix:PATH or tcp://HOST:PORT, such as tcp://127.0.0.1:5555.")
    return host.strip("[]"), int(port)


def listen(address: str, anywhere: bool = False) -> socket.socket:
    """Return a socket that listens at `unix:PATH`, which only this user can open, or at `tcp://HOST:PORT`.

    Args:
        address: The address.
        anywhere: Whether other machines may connect. The connection has neither encryption nor authentication.

    Raises:
        ValueError: The address has neither form, or other machines can reach it and `anywhere` is False.
        OSError: The address cannot be opened, such as a port in use.
    """
    if address.startswith("unix:"):
        return _listen_unix(address.removeprefix("unix:"))
    host, port = split_tcp(address)
    if not anywhere and host not in ("localhost", "::1") and not re.fullmatch(r"127(\.\d{1,3}){3}", host):
        raise ValueError(f"'{address}' can be reached by other machines. Use 127.0.0.1 and an SSH tunnel, or pass anywhere=True.")
    return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)


def _listen_unix(path: str) -> socket.socket:
    listener = socket.socket(socket.AF_UNIX)
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX) as probe:
        if stat.S_ISSOCK(os.stat(path).st_mode) and probe.connect_ex(path) == errno.ECONNREFUSED:
            os.unlink(path)  # its server has ended
    before = os.umask(0o177)
    try:
        listener.bind(path)
    finally:
        os.umask(before)
    listener.listen()
    return listener


def serve(make: Callable[[], Any], address: str, *, anywhere: bool = False) -> None:
    """Serve at an address until Ctrl-C, see `listen`. Each connection has its own thread, and its own policy from `make`.

    A policy has `reset(instruction, context)`, `act(observation)`, and `action_mode` and `obs_config` as plain data.
    """
    serve_answers(lambda: Answers(make), listen(address, anywhere))


def serve_answers(answers: Callable[[], Answers], listener: socket.socket) -> None:
    """Serve on a listening socket until Ctrl-C; see `serve`."""
    places = threading.Semaphore(MAX_CONNECTIONS)

    def one(connection: socket.socket) -> None:
        try:
            converse(Channel(connection), answers())
        finally:
            places.release()

    try:
        while True:
            places.acquire()
            threading.Thread(target=one, args=(listener.accept()[0],), daemon=True).start()
    finally:
        name = listener.getsockname()
        listener.close()
        if isinstance(name, str):
            with contextlib.suppress(OSError):
                os.unlink(name)
