"""A private folder for the pair of files as it stands in the editor, which goes away with its owner, however that ends."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

from rlbench_pin.builder.contracts import TaskText
from rlbench_pin.errors import InvalidValue

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_BESIDE = re.compile(r"""["'](\.\.?/[^"']*)["']""")
"""What a scene names beside itself."""
OWNER = "RLBENCH_PIN_STAGE"
"""Variable in the environment of a process of the stage, and of all that a task starts there: the private folder."""
_SWEEP = """read -r _
for turn in 1 2 3; do
    grep -lsaF -- "$2=$1" /proc/[0-9]*/environ | while IFS=/ read -r _ _ number _; do kill -9 "$number"; done
done
rm -rf -- "$1"
"""
"""What the sweeper does: wait for the end of its input, end what is left of the stage, then remove the folder."""


class PrivateFolder:
    """A temporary folder that a tiny process removes when the owner closes it, ends, or is killed.

    That process also ends what a task has started and hidden from its own end, such as a daemon in a session of its own.

    Attributes:
        path: Where it is.
    """

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="rlbench_pin_stage_")).resolve()
        self._sweeper = subprocess.Popen(
            ["/bin/sh", "-c", _SWEEP, "sh", str(self.path), OWNER],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd="/", start_new_session=True,
        )  # fmt: skip

    def write(self, slot: str, text: TaskText) -> Path:
        """Write the pair into a part of the folder, with links to what lies beside the real files.

        Args:
            slot: Name of the part; what was in it is thrown away.
            text: The pair.

        Returns:
            The Python file, with its scene beside it.

        Raises:
            InvalidValue: The name of the task is none.
        """
        check_name(text.name)
        here = self.path / slot
        shutil.rmtree(here, ignore_errors=True)
        here.mkdir()
        pair = (f"{text.name}.toml", f"{text.name}.py")
        way = _way(text.folder.absolute(), _levels(text.scene))
        for above, below in zip(way, way[1:]):
            _link_entries(above, here, [below.name])
            here = here / (below.name or "root")
            here.mkdir()
        _link_entries(way[-1], here, pair)
        for name, content in zip(pair, (text.scene, text.python), strict=True):
            (here / name).write_text(content, encoding="utf-8")
        return here / pair[1]

    def update(self, python: Path, before: TaskText, text: TaskText) -> Path:
        """Write a pair again whose scene alone has changed, and return its Python file; quick where that names the same files."""
        if _BESIDE.findall(before.scene) != _BESIDE.findall(text.scene) or not python.is_file():
            return self.write(python.relative_to(self.path).parts[0], text)
        python.with_suffix(".toml").write_text(text.scene, encoding="utf-8")
        return python

    def close(self) -> None:
        """Remove the folder; may be called again."""
        if self._sweeper.stdin is not None and not self._sweeper.stdin.closed:
            with contextlib.suppress(OSError), self._sweeper.stdin as told:
                told.write(b"\n")  # the end of its input alone could stay away: a process that was forked may hold it, too
            self._sweeper.wait(timeout=30.0)


def check_name(name: str) -> None:
    """Raise InvalidValue for what is no name of a task; files are called by it."""
    if not _NAME.fullmatch(name):
        raise InvalidValue("The name of a task", name, "has to be small letters, digits and `_`, a letter first")


def _levels(scene: str) -> int:
    """How many folders up the scene names files."""
    return max((found.count("../") for found in _BESIDE.findall(scene)), default=0)


def _way(folder: Path, levels: int) -> list[Path]:
    """Return the folder and so many above it, the highest first."""
    above = list(folder.parents)[:levels]
    return [*reversed(above), folder]


def _link_entries(folder: Path, into: Path, leave_out: Iterable[str]) -> None:
    """Link everything that lies in a folder."""
    left = set(leave_out)
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name not in left:
                os.symlink(entry.path, into / entry.name)
