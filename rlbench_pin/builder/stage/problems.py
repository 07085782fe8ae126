"""Whatever opening or running a task raises -> what is wrong in which file, at which line."""

from __future__ import annotations

import re
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rlbench_pin.builder.contracts import FileKind, Problem
from rlbench_pin.errors import AssetInvalid, AssetNotFound, RlbenchPinError, SceneFileError, TaskError, UnknownName

LONGEST = 2000
"""Letters of a message that are kept."""
_AT_LINE = re.compile(r"at line (\d+)")
_ENTRY = re.compile(r"\[\[(\w+)\]\] '([^']*)'")
_TABLE = re.compile(r"\[(\w+)\]")
_KEY = re.compile(r"key '([\w.]+)'")
_DUMPED = re.compile(r'File "([^"]+)", line (\d+)')


@dataclass(frozen=True)
class Pair:
    """The two files as they were written for the stage, and where the real ones are."""

    python: Path
    """The Python file in the private folder."""
    folder: Path
    """The folder of the real files."""

    @property
    def scene(self) -> Path:
        """The scene file in the private folder."""
        return self.python.with_suffix(".toml")

    def real(self, text: str) -> str:
        """Return a text with the private folder called by the real one."""
        return text.replace(str(self.python.parent), str(self.folder))


def problem_of(error: BaseException, pair: Pair) -> Problem:
    """Return what an error says about the two files; the last line of the Python file on the way to it, where there is one."""
    line = _python_line(error, pair.python)
    if line is not None:
        return Problem("task", line, pair.real(_message(error))[:LONGEST])
    message = pair.real(_message(error))[:LONGEST]
    for cause in chain(error):
        if isinstance(cause, SceneFileError | AssetNotFound | AssetInvalid | UnknownName):
            return Problem("scene", scene_line(_read(pair.scene), cause), message)
    file: FileKind = "task" if isinstance(error, TaskError) else "scene"
    return Problem(file, None, message)


def dumped_line(dump: str, python: Path) -> int | None:
    """Return the line of the Python file at which a process was, by a dump of `faulthandler`, most recent call first."""
    lines = [int(line) for file, line in _DUMPED.findall(dump) if file == str(python)]
    return lines[0] if lines else None


def chain(error: BaseException) -> Iterator[BaseException]:
    """Yield an error and what it was raised from, in turn."""
    seen: BaseException | None = error
    while seen is not None:
        yield seen
        seen = seen.__cause__


def _message(error: BaseException) -> str:
    """Return an error of ours as it is, any other with its type; of a module that cannot be loaded, why."""
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
    """Return the last line of the Python file that the innermost error passed."""
    for cause in reversed(list(chain(error))):
        lines = [frame.lineno for frame in traceback.extract_tb(cause.__traceback__) if frame.filename == str(python)]
        if lines:
            return lines[-1]
        if isinstance(cause, SyntaxError) and cause.filename == str(python):
            return cause.lineno
    return None


# Lines of a scene --------------------------------------------------------------------------------------------------------------


def scene_line(text: str, error: BaseException) -> int | None:
    """Return the line of a scene that an error is about, from 1; None for the whole file."""
    lines = text.splitlines()
    if isinstance(error, AssetNotFound | AssetInvalid):
        return _first(lines, 0, len(lines), re.escape(error.path.name) + """["']""")
    if isinstance(error, UnknownName):
        return _first(lines, 0, len(lines), f"""["']{re.escape(str(error.name))}["']""")
    if not isinstance(error, SceneFileError):
        return None
    if found := _AT_LINE.search(error.problem):
        return int(found[1])
    return _line_of_place(lines, error.where)


def _line_of_place(lines: list[str], where: str) -> int | None:
    """Return the line of what an error calls `[[table]] 'name', key 'key'`, or of its entry."""
    key = _KEY.search(where)
    last = "name" if key is None else key[1].split(".")[0]
    if entry := _ENTRY.search(where):
        begin, end = _entry_lines(lines, entry[1], entry[2])
    elif table := _TABLE.match(where):
        begin, end = _section(lines, rf"\s*\[{table[1]}\]")
    else:
        begin, end = 0, len(lines)
    if begin is None:
        return None
    found = _first(lines, begin, end, rf"^\s*{re.escape(last)}\s*=")
    return found or (begin + 1 if end < len(lines) or begin > 0 else None)


def _entry_lines(lines: list[str], table: str, name: str) -> tuple[int | None, int]:
    """Return where an entry of a table begins and ends, by its name or by `number N`."""
    heads = [i for i, line in enumerate(lines) if re.match(rf"\s*\[\[{re.escape(table)}\]\]", line)]
    for number, begin in enumerate(heads):
        end = _end(lines, begin)
        if name == f"number {number}" or _first(lines, begin, end, rf'^\s*name\s*=\s*["\']{re.escape(name)}["\']'):
            return begin, end
    return None, 0


def _section(lines: list[str], head: str) -> tuple[int | None, int]:
    begin = next((i for i, line in enumerate(lines) if re.match(head, line)), None)
    return (None, 0) if begin is None else (begin, _end(lines, begin))


def _end(lines: list[str], begin: int) -> int:
    return next((i for i in range(begin + 1, len(lines)) if re.match(r"\s*\[", lines[i])), len(lines))


def _first(lines: list[str], begin: int, end: int, pattern: str) -> int | None:
    """Return the first line of some that holds a pattern, from 1."""
    return next((i + 1 for i in range(begin, end) if re.search(pattern, lines[i])), None)


def _read(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, ValueError):
        return ""
