"""The program of a worker process: `python -m rlbench_pin.builder.worker.host SOCKET PIPE DUMP MEMORY`.

It answers one request at a time with `{"ok": ...}` or `{"error": text, "kind": ...}`; before the answer it sends
`{"note": name, "value": ...}`. SIGUSR2 stops the operation. At a crash, or at SIGUSR1, the Python stack is written to DUMP.
"""

from __future__ import annotations

import contextlib
import faulthandler
import os
import signal
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rlbench_pin.builder.worker.encoding import decode, encode
from rlbench_pin.builder.worker.problems import Pair
from rlbench_pin.builder.worker.process import NothingOpen
from rlbench_pin.builder.worker.validation import validate
from rlbench_pin.builder.worker.world import TaskWorld
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.evaluation.policies.policy_server import Channel, WireError
from rlbench_pin.processes.child import connect_to_owner, limit_memory
from rlbench_pin.viewer.recording import Frame

Question = Mapping[str, Any]


class Stopped(BaseException):
    """The operation was stopped."""


class Host:
    """Answers the requests of the owner at the other end of a channel."""

    def __init__(self, channel: Channel) -> None:
        self._channel, self._world, self._stop = channel, TaskWorld(), False
        self._calls: dict[str, Callable[[Question], Any]] = {
            "open": lambda q: self._world.open(_pair(q), q["run_task"], q["robot"]),
            "place": lambda q: self._world.place(),
            "reset": lambda q: self._world.reset(q["seed"], q["variation"], self._alive),
            "reach": lambda q: self._world.reach(),
            "follow": lambda q: self._world.follow(q["pose"], q["configuration"]),
            "paths": lambda q: self._world.paths(self._note("path")),
            "demonstrate": lambda q: self._world.demonstrate(q["seed"], q["variation"], self._note("frame"), self._alive),
            "simulate": lambda q: self._world.simulate(q["seconds"], self._note("frame")),
            "images": self._images,
            "reach_map": lambda q: self._world.reach_map(q["layouts"], self._note("spot")),
            "validate": self._validate,
        }

    def stop(self) -> None:
        """End the operation at its next note."""
        self._stop = True

    def serve(self) -> None:
        """Answer until the owner closes the connection."""
        self._channel.send({"ready": os.getpid()})
        with contextlib.suppress(EOFError, OSError, WireError):
            while True:
                question, self._stop = self._channel.receive(), False
                signal.alarm(0)  # a pending alarm would end the process
                self._channel.send(self._answer(question))

    def _answer(self, question: Question) -> dict[str, Any]:
        try:
            return {"ok": encode(self._calls[question["call"]](question))}
        except Stopped:
            return {"error": "stopped", "kind": "stopped"}
        except NothingOpen as error:
            return {"error": str(error), "kind": "nothing open"}
        except MemoryError:
            return {"error": "It takes more memory than the task builder allows.", "kind": "out of memory"}
        except (WireError, OSError):
            raise  # the owner has ended
        except BaseException as error:  # tasks may define exceptions of any kind
            if not isinstance(error, RlbenchPinError):
                traceback.print_exc()
            return {"error": encode("".join(traceback.format_exception_only(error)).strip()), "kind": "failed"}

    def _note(self, name: str) -> Callable[[Any], None]:
        """Return a function that sends a note, or ends the operation."""

        def note(value: Any) -> None:
            if self._stop:
                raise Stopped
            self._channel.send({"note": name, "value": encode(value)})

        return note

    def _alive(self) -> None:
        self._note("alive")(True)

    def _images(self, question: Question) -> dict[str, Any]:
        frame = None if question["frame"] is None else decode(Frame, question["frame"])
        return self._world.images(question["size"], frame)

    def _validate(self, question: Question) -> Any:
        python, progress = Path(question["python"]), self._note("progress")
        return validate(python, question["episodes"], self._note("line"), lambda *done: progress(done))


def _pair(question: Question) -> Pair:
    return Pair(Path(question["python"]), Path(question["folder"]))


def main() -> None:
    """Answer until the owner closes the socket, or ends."""
    connection, (dump, memory) = connect_to_owner()
    with open(dump, "w", encoding="utf-8") as file:
        faulthandler.enable(file, all_threads=False)
        faulthandler.register(signal.SIGUSR1, file, all_threads=False)
        limit_memory(int(memory))
        host = Host(Channel(connection))
        signal.signal(signal.SIGUSR2, lambda number, stack: host.stop())
        host.serve()


if __name__ == "__main__":
    main()
