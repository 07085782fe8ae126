"""An order to the workshop: a process of its own, which ends in time, whatever the file does to it."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from typing import IO

from rlbench_pin.builder.server import UploadRefused
from rlbench_pin.builder.view.own.solids import OwnAsset
from rlbench_pin.builder.view.own.workshop import Order
from rlbench_pin.errors import RlbenchPinError

LONGEST = 180.0
"""What a file may take [s]."""
_WORKSHOP = "rlbench_pin.builder.view.own.workshop"


class Making:
    """Has an asset made of a file.

    Args:
        order: What is to be made.
        data: Content of the file.
        on_note: Called with what is being done and since when, every second.
        on_end: Called once, with the asset or why there is none; both are called in a thread of their own.
        longest: What it may take [s].
    """

    def __init__(
        self,
        order: Order,
        data: bytes,
        on_note: Callable[[str], None],
        on_end: Callable[[OwnAsset | RlbenchPinError], None],
        longest: float = LONGEST,
    ) -> None:
        self._order, self._on_note, self._on_end, self._longest = order, on_note, on_end, longest
        self._ended, self._doing, self._over = "", f"Looking at '{order.name}'", threading.Event()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  # closed when the process has ended
        self._process = subprocess.Popen(
            [sys.executable, "-m", _WORKSHOP], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors,
            start_new_session=True,
        )  # fmt: skip
        self._timer = threading.Timer(longest, self._end, [f"it takes longer than {longest:g} s"])
        self._timer.daemon = True
        self._timer.start()
        threading.Thread(target=self._run, args=(data,), name="workshop", daemon=True).start()
        threading.Thread(target=self._count, name="workshop clock", daemon=True).start()

    @property
    def name(self) -> str:
        """Of the file."""
        return self._order.name

    def stop(self) -> None:
        """End it."""
        self._end("it was stopped")

    def _count(self) -> None:
        """Tell every second how long it has taken."""
        seconds = 0
        while not self._over.wait(1.0):
            seconds += 1
            self._on_note(f"{self._doing}: {seconds} s of at most {self._longest:g} s")

    def _end(self, why: str) -> None:
        self._ended = self._ended or why
        self._process.kill()

    def _run(self, data: bytes) -> None:
        try:
            found: OwnAsset | RlbenchPinError = self._converse(data)
        except RlbenchPinError as error:
            found = error
        except (OSError, ValueError, KeyError) as error:
            found = self._broken(error)
        finally:
            self._over.set()
            self._timer.cancel()
            self._process.kill()
            self._process.wait()
            self._errors.close()
        self._on_end(found)

    def _converse(self, data: bytes) -> OwnAsset:
        """Hand the file over, and take what comes."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        with stdin:
            stdin.write(self._order.written())
            stdin.write(data)
        with stdout:
            while "note" in (said := json.loads(stdout.readline())):
                self._doing = str(said["note"])
                self._on_note(self._doing)
            if "error" in said:
                raise RlbenchPinError(str(said["error"]))
            return OwnAsset(str(said["urdf"]), {str(name): _exactly(stdout, int(size)) for name, size in said["files"]})

    def _broken(self, error: Exception) -> UploadRefused:
        """Return why the process ended without an answer."""
        code = self._process.wait()
        if self._ended:
            hint = "Reduce it first: fewer triangles, fewer parts." if "longer" in self._ended else ""
            return UploadRefused(self.name, self._ended, hint)
        self._errors.seek(0)
        last = self._errors.read().decode(errors="replace").strip().rpartition("\n")[2][:200]
        cause = signal.Signals(-code).name if code < 0 else last or f"exit {code}, {error}"
        return UploadRefused(self.name, f"reading it ended the process that did so ({cause})")


def _exactly(stream: IO[bytes], size: int) -> bytes:
    """Return so many bytes."""
    content = stream.read(size)
    if len(content) != size:
        raise ValueError("the answer is too short")
    return content
