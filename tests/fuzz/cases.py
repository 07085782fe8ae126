"""A case is one call with one line that repeats it; a tally counts cases and reports all that break the law, by door and kind."""

from __future__ import annotations

import faulthandler
import math
import resource
import signal
import sys
import traceback
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, is_dataclass

import numpy as np

from rlbench_pin.errors import RlbenchPinError

LIMIT = 20.0
"""Longest time that a case may take [s]."""
MAX_MEMORY = 1_000_000
"""By so much a case may raise the most memory that the process has used [kB]."""
MIN_TEXT = 12
"""An error says at least so many letters."""


class Hang(BaseException):
    """A case took too long; no `except Exception` keeps it."""


@dataclass(frozen=True)
class Case:
    """One call that has to give a valid result, or an error of ours that has a text."""

    door: str
    """What is called."""
    words: str
    """With what, so that a reader can do it again."""
    call: Callable[[], object] = field(repr=False)
    must_refuse: bool = False
    """Whether a result is wrong, whatever it is."""
    must_take: bool = False
    """Whether an error is wrong, whatever it says."""
    check: Callable[[], str] | None = field(default=None, repr=False)
    """Afterwards, whatever came of it: says what is wrong now, or nothing."""
    check_result: Callable[[object], str] | None = field(default=None, repr=False)
    """Says what is wrong with a result, or nothing."""
    finite: bool = True
    """Whether all numbers of a result are finite."""


@dataclass
class Tally:
    """Counts what became of cases."""

    taken: int = 0
    refused: int = 0
    faults: dict[tuple[str, str], list[str]] = field(default_factory=lambda: defaultdict(list))
    texts: dict[str, str] = field(default_factory=dict)
    """Text of errors -> a case that got it; a sample to read."""
    doors: Counter[str] = field(default_factory=Counter)

    @property
    def cases(self) -> int:
        """How many cases were tried."""
        return self.doors.total()

    def run(self, case: Case) -> None:
        """Try one case and note what came of it."""
        self.doors[case.door] += 1
        most = _most_memory()
        try:
            with _limited(case):
                result = case.call()
        except Hang:
            self._note(case, "hangs")
        except RlbenchPinError as error:
            self.refused += 1
            self._check_text(case, error)
        except Exception as error:  # what nobody should see
            self._note(case, f"{type(error).__name__} at {_place(error)}", f"{case.words}: {_one_line(error)}")
        else:
            self.taken += 1
            self._check_result(case, result)
        if _most_memory() > most + MAX_MEMORY:
            self._note(case, f"takes {(_most_memory() - most) // 1000} MB")
        self._look_after(case)

    def _look_after(self, case: Case) -> None:
        """See whether all is as it should be after a case."""
        try:
            problem = "" if case.check is None else case.check()
        except Exception as error:  # whatever is broken now
            problem = f"afterwards {type(error).__name__} at {_place(error)}: {_one_line(error)}"
        if problem:
            self._note(case, problem)

    def _check_text(self, case: Case, error: RlbenchPinError) -> None:
        text = str(error)
        self.texts.setdefault(text, f"{case.door}({case.words})")
        if len(text) < MIN_TEXT:
            self._note(case, f"an error without a text: {text!r}")
        if case.must_take:
            self._note(case, f"refused: {_one_line(error)}")

    def _check_result(self, case: Case, result: object) -> None:
        if case.must_refuse:
            self._note(case, "taken without a word")
        elif case.finite and not all_finite(result):
            self._note(case, "returns NaN or infinity")
        elif case.check_result is not None and (problem := case.check_result(result)):
            self._note(case, problem)

    def _note(self, case: Case, what: str, words: str = "") -> None:
        self.faults[(case.door, what)].append(words or case.words)

    def report(self) -> str:
        """Say all that is wrong, a line for each kind at each door, with the first cases."""
        lines = []
        for (door, what), words in sorted(self.faults.items()):
            lines.append(f"{door}: {what}  [{len(words)} cases, such as {'; '.join(words[:3])}]"[:600])
        return "\n".join(lines)


@contextmanager
def _limited(case: Case) -> Iterator[None]:
    """Raise Hang in code of Python that takes too long; end the process, with the case, where C code does not come back."""

    def end(*_: object) -> None:
        raise Hang

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, LIMIT)
    faulthandler.dump_traceback_later(6 * LIMIT, exit=True, file=sys.__stderr__)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        faulthandler.cancel_dump_traceback_later()
        signal.signal(signal.SIGALRM, before)


def _most_memory() -> int:
    """Return the most memory that this process has used so far [kB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _place(error: BaseException) -> str:
    """Return the last line of ours that an error came through."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "rlbench_pin/" in f.filename and "tests/" not in f.filename]
    last = frames[-1] if frames else traceback.extract_tb(error.__traceback__)[-1]
    return f"{last.filename.rpartition('rlbench_pin/')[2]}:{last.lineno}"


def _one_line(error: BaseException) -> str:
    try:
        return ascii(" ".join(str(error).split()))[:100]
    except Exception:
        return "an error that cannot be shown"


def all_finite(value: object, depth: int = 4) -> bool:
    """Whether all numbers in a result are finite; looks into arrays, containers and records."""
    if isinstance(value, float | np.floating):
        return math.isfinite(value)
    if isinstance(value, np.ndarray):
        return value.dtype.kind != "f" or bool(np.isfinite(value).all())
    if depth and isinstance(value, list | tuple):
        return all(all_finite(item, depth - 1) for item in value)
    if depth and isinstance(value, Mapping):
        return all(all_finite(item, depth - 1) for item in value.values())
    if depth and is_dataclass(value) and not isinstance(value, type):
        return all(all_finite(getattr(value, f.name, None), depth - 1) for f in fields(value))
    return True
