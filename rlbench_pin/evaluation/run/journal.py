"""Finished episodes on disk, a JSON line for each behind one that says of what, so that a killed evaluation goes on."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any, TextIO

from rlbench_pin.datasets.storage import storing
from rlbench_pin.errors import InvalidValue, RlbenchPinError, shown
from rlbench_pin.evaluation.results.records import EpisodeRecord
from rlbench_pin.evaluation.run.config import EpisodeItem
from rlbench_pin.evaluation.run.episode import EpisodeOutcome

_FORMAT = 1
_DIGITS = 6
"""Times are kept to the microsecond."""


class EvaluationConflict(RlbenchPinError):
    """Where an evaluation is to be written, there is another one."""


class Journal:
    """What was played before, and what is added now.

    Args:
        path: File to read and to append to.
        head: What the evaluation is, as plain data; what was played for another one cannot be used.
    """

    def __init__(self, path: Path, head: Mapping[str, Any]) -> None:
        self.path = path
        self._head: dict[str, Any] = json.loads(json.dumps({"format": _FORMAT, **head}))

    @contextmanager
    def opened(self, resume: bool) -> Iterator[OpenJournal]:
        """Hold the file for the duration of a block.

        Args:
            resume: Use what it holds; otherwise it must not be there yet.

        Raises:
            EvaluationConflict: It is there and must not be, or is of another evaluation, or another process holds it.
            StorageError: It cannot be read or written to.
        """
        with storing(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            file = self.path.open("a+", encoding="utf-8")
        with file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise EvaluationConflict(
                    f"Another evaluation writes to '{self.path}'. Wait for it, or choose another file for the results."
                ) from error
            lines = self._lines(file)
            if lines and not resume:
                raise EvaluationConflict(
                    f"'{self.path}' holds {len(lines) - 1} episodes of an evaluation that did not end. Go on with `--resume`, "
                    "delete the file, or choose another one for the results."
                )
            self._check(lines)
            journal = OpenJournal(self.path, file, lines[1:])
            if not lines:
                journal.write(self._head)
            yield journal

    def _lines(self, file: TextIO) -> list[dict[str, Any]]:
        """Return what the whole lines say; what was being written when its writer was killed is cut off."""
        with storing(self.path):
            file.seek(0)
            data = file.buffer.read()  # type: ignore[attr-defined]
            if (whole := data.rfind(b"\n") + 1) < len(data):
                file.truncate(whole)
        found = []
        for number, line in enumerate(data[:whole].splitlines()):
            try:
                entry = json.loads(line)
            except ValueError:
                entry = None
            if isinstance(entry, dict):
                found.append(entry)
            elif number == 0:
                raise EvaluationConflict(f"'{self.path}' is no journal of an evaluation. Delete it, or choose another file.")
        return found

    def _check(self, lines: Sequence[Mapping[str, Any]]) -> None:
        """Raise EvaluationConflict unless the first line is this head."""
        for name in [] if not lines else sorted({*self._head, *lines[0]}):
            then, now = lines[0].get(name), self._head.get(name)
            if then != now:
                then, now = _differing(then, now)
                raise EvaluationConflict(
                    f"'{self.path}' was begun with {name} = {shown(then)}, this is {name} = {shown(now)}. Go on with the same, "
                    "or choose another file for the results."
                )


def _differing(then: Any, now: Any) -> tuple[Any, Any]:
    """Return what differs of two values: of two mappings the entries that are not alike, so that a message names them."""
    if not (isinstance(then, dict) and isinstance(now, dict)):
        return then, now
    names = [name for name in sorted({*then, *now}) if then.get(name) != now.get(name)]
    return {name: then.get(name) for name in names}, {name: now.get(name) for name in names}


class OpenJournal:
    """The journal of an evaluation under way.

    Args:
        path: Where it lies.
        file: The open file.
        lines: What it held of episodes.
    """

    def __init__(self, path: Path, file: TextIO, lines: Sequence[Mapping[str, Any]]) -> None:
        self.path, self._file = path, file
        self._lines = {_key(line): line for line in lines if _key(line) is not None}

    def found(self, items: Sequence[EpisodeItem]) -> list[EpisodeOutcome]:
        """Return what was played before of some episodes."""
        outcomes = (self._outcome(item) for item in items)
        return [outcome for outcome in outcomes if outcome is not None]

    def _outcome(self, item: EpisodeItem) -> EpisodeOutcome | None:
        line = self._lines.get((item.name, item.variation, item.seed))
        if line is None:
            return None
        try:
            return EpisodeOutcome(item, EpisodeRecord(**line["record"]), tuple(float(t) for t in line["times"]))
        except (InvalidValue, RlbenchPinError, KeyError, TypeError, ValueError):  # damaged: it is played again
            return None

    def add(self, outcome: EpisodeOutcome) -> None:
        """Append an episode.

        Raises:
            StorageError: The disk cannot be written to. What was added before is whole.
        """
        self.write({"record": asdict(outcome.record), "times": [round(t, _DIGITS) for t in outcome.action_times]})

    def write(self, content: Mapping[str, Any]) -> None:
        """Append a line, and see that it is on the disk."""
        with storing(self.path):
            self._file.write(json.dumps(content) + "\n")
            self._file.flush()
            os.fsync(self._file.fileno())


def _key(line: Mapping[str, Any]) -> tuple[str, int, int] | None:
    record = line.get("record")
    if not isinstance(record, dict):
        return None
    key = tuple(record.get(name) for name in ("task", "variation", "seed"))
    return key if isinstance(key[0], str) and all(type(part) is int for part in key[1:]) else None  # type: ignore[return-value]
