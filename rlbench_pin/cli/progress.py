"""Progress bars on stderr, and a handler of Ctrl-C that keeps finished work."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from tqdm import tqdm

from rlbench_pin.checking import CheckProgress
from rlbench_pin.cli.bars import progress_bar
from rlbench_pin.cli.interrupts import interrupt, say
from rlbench_pin.evaluation.run import EvaluationProgress
from rlbench_pin.recording.record import RecordReport


class _Bar:
    """A bar on stderr that the first report begins; `what` is its title."""

    def __init__(self, what: str) -> None:
        self._bar: tqdm | None = None
        self._what = what

    def close(self) -> None:
        """Close the bar; its last line stays."""
        if self._bar is not None:
            self._bar.close()


class RecordBar(_Bar):
    """Episodes done, their rate, and failed attempts by cause."""

    def __call__(self, report: RecordReport) -> None:
        """Show the progress."""
        if self._bar is None:
            self._bar = progress_bar(total=report.wanted, initial=report.found, unit="episode", desc=self._what)
        self._bar.update(report.found + report.recorded - self._bar.n)
        notes = [f"{count} {cause}" for cause, count in sorted(report.causes.items(), key=lambda item: -item[1])]
        notes += [f"{len(report.failed)} given up"] if report.failed else []
        notes += [f"{len(report.deaths)} workers died"] if report.deaths else []
        self._bar.set_postfix_str(", ".join(notes))


class CheckBar(_Bar):
    """Trials done, their rate, and the last finished task and part."""

    def __call__(self, progress: CheckProgress) -> None:
        """Show the progress of the check."""
        if self._bar is None:
            self._bar = progress_bar(total=progress.total, initial=progress.found, unit="trial", desc=self._what, smoothing=0.05)
        if progress.latest is not None:
            self._bar.set_postfix_str(f"{progress.latest.task} {progress.latest.part}", refresh=False)
        self._bar.update(progress.found + progress.done - self._bar.n)


class EvaluationBar(_Bar):
    """Episodes done, their rate, and how many of them succeeded so far."""

    def __call__(self, progress: EvaluationProgress) -> None:
        """Show the progress."""
        if self._bar is None:
            total, found = progress.wanted, progress.found
            self._bar = progress_bar(total=total, initial=found, unit="episode", desc=self._what)
        played = progress.found + progress.done
        self._bar.update(played - self._bar.n)
        notes = [f"success {100.0 * progress.successes / played:.0f} %"] if played else []
        notes += [progress.latest.item.name] if progress.latest is not None else []
        notes += [f"{progress.faults} faults"] if progress.faults else []
        notes += [f"{progress.deaths} workers died"] if progress.deaths else []
        self._bar.set_postfix_str(", ".join(notes))


@contextmanager
def stopping_gently() -> Iterator[threading.Event]:
    """Yield an event that the first Ctrl-C sets; the second Ctrl-C interrupts at once."""
    stop = threading.Event()

    def on_interrupt(number: int, frame: FrameType | None) -> None:
        if stop.is_set():
            interrupt(number, frame)
            return
        stop.set()
        say("\nFinishing the running episodes. Press Ctrl-C again to stop at once.")

    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, before)
