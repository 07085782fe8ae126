"""Converts errors of opening or running a task to problems of one of its two files, with the line."""

from __future__ import annotations

import re
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rlbench_pin.builder.document.problems import scene_problem
from rlbench_pin.errors import AssetInvalid, AssetNotFound, RlbenchPinError, SceneFileError, TaskError, UnknownName
from rlbench_pin.viewer.recording import FileKind, Problem

MAX_MESSAGE = 2000
"""Maximum length of a message [characters]."""
_DUMPED = re.compile(r'File "([^"]+)", line (\d+)')


@dataclass(frozen=True)
class Pair:
    """The copies of the two files in the private folder, and the folder of the real ones."""

    python: Path
    """The Python file in the private folder."""
    folder: Path
    """The folder of the real files."""

    @property
    def scene(self) -> Path:
        """The scene file in the private folder."""
        return self.python.with_suffix(".toml")

    def real(self, text: str) -> str:
        """Return a text with the private folder replaced by the real one."""
        return text.replace(str(self.python.parent), str(self.folder))


def problem_of(error: BaseException, pair: Pair) -> Problem:
    """Return an error as a problem, at the last line of the Python file in its traceback, else at a line of the scene."""
    message, line = pair.real(_message(error))[:MAX_MESSAGE], _python_line(error, pair.python)
    if line is not None:
        return Problem("task", line, message)
    for cause in chain(error):
        if isinstance(cause, SceneFileError | AssetNotFound | AssetInvalid | UnknownName):
            return Problem("scene", _scene_line(_read(pair.scene), cause), message)
    file: FileKind = "task" if isinstance(error, TaskError) else "scene"
    return Problem(file, None, message)


def dumped_line(dump: str, python: Path) -> int | None:
    """Return the innermost line of the Python file in a stack dump of `faulthandler`."""
    lines = [int(line) for file, line in _DUMPED.findall(dump) if file == str(python)]
    return lines[0] if lines else None


def chain(error: BaseException) -> Iterator[BaseException]:
    """Yield an error, its cause, the cause of the cause, and so on."""
    seen: BaseException | None = error
    while seen is not None:
        yield seen
        seen = seen.__cause__


def _message(error: BaseException) -> str:
    """Return the text of an error of this package, of any other with its type; for a module that cannot be loaded, the cause."""
    cause = error.__cause__
    if isinstance(error, TaskError) and cause is not None and not isinstance(cause, RlbenchPinError):
        error = cause
    if isinstance(error, RlbenchPinError):
        return str(error)
    if isinstance(error, MemoryError):
        return "MemoryError: it takes more memory than the task builder allows. Make less of it."
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg}"
    if isinstance(error, SystemExit):
        return f"SystemExit: the task ends the program ({error.code!r}). Raise an error that says what is wrong instead."
    return "".join(traceback.format_exception_only(error)).strip()


def _python_line(error: BaseException, python: Path) -> int | None:
    """Return the last line of the Python file in the traceback of the innermost error."""
    for cause in reversed(list(chain(error))):
        lines = [frame.lineno for frame in traceback.extract_tb(cause.__traceback__) if frame.filename == str(python)]
        if lines:
            return lines[-1]
        if isinstance(cause, SyntaxError) and cause.filename == str(python):
            return cause.lineno
    return None


def _scene_line(text: str, error: SceneFileError | AssetNotFound | AssetInvalid | UnknownName) -> int | None:
    """Return the line of a scene that an error concerns, from 1; None for the whole file."""
    lines = text.splitlines()
    if isinstance(error, UnknownName):
        return _first(lines, 0, f"""["']{re.escape(str(error.name))}["']""")
    line = scene_problem(text, error).line
    if line is not None and lines[line - 1 : line] and lines[line - 1].lstrip().startswith("[["):
        return _first(lines, line, r"^\s*name\s*=") or line
    return line


def _first(lines: list[str], begin: int, pattern: str) -> int | None:
    """Return the first line with a pattern, from 1, in the rest of a file or, after a heading, of its entry."""
    for number, line in enumerate(lines[begin:], start=begin + 1):
        if begin and line.lstrip().startswith("["):
            return None
        if re.search(pattern, line):
            return number
    return None


def _read(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, ValueError):
        return ""
