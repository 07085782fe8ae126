"""What the bars show: work done, its rate, failures by cause."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from rlbench_pin.checking.plan import Item
from rlbench_pin.checking.run import CheckProgress
from rlbench_pin.cli.progress import CheckBar, RecordBar
from rlbench_pin.processes import WorkerDeath
from rlbench_pin.recording.config import WorkItem
from rlbench_pin.recording.record import ItemResult, RecordReport

Capture = pytest.CaptureFixture[str]
ITEM = WorkItem("reach_target", "reach_target", 0, 0, 1, (0,))


class Clock:
    """Time for the bar, which a test sets."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        """Return the time [s]."""
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """A clock that stands still, and a terminal wide enough for everything."""
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("LINES", "50")
    clock = Clock()
    monkeypatch.setattr("tqdm.std.time", clock)
    monkeypatch.setattr("rlbench_pin.cli.bars.is_terminal", lambda: True)
    return clock


def last_line(capsys: Capture) -> str:
    """Return what the bar shows in the end; nothing goes to stdout, which is for results."""
    out, err = capsys.readouterr()
    assert out == ""
    return str(err.strip("\n\r").rsplit("\r", 1)[-1])


def test_the_bar_counts_episodes_and_their_rate(clock: Clock, capsys: Capture) -> None:
    """Episodes that were found are done, but do not make it look faster than it is."""
    bar, report = RecordBar("record"), RecordReport(wanted=20, found=10)
    bar(report)
    assert re.search(r"record: +50%.* 10/20 ", last_line(capsys))
    for _ in range(4):
        clock.now += 4.0
        report = replace(report, recorded=report.recorded + 1)
        bar(report)
    line = last_line(capsys)
    assert re.search(r"record: +70%.* 14/20 .*00:16<00:24, +4\.00s/episode", line), line
    assert not re.search(r"failed|given up|died", line)


def test_the_bar_names_failures_by_cause(clock: Clock, capsys: Capture) -> None:
    """The most frequent cause comes first; items that were given up and workers that died are counted."""
    bar, report = RecordBar("rerender"), RecordReport(wanted=5, found=0)
    bar(report)
    clock.now += 2.0
    for failures in (("no path: wall",), ("no path: lid", "goal not reached: it fell", "no path: wall")):
        report = report.with_result(ItemResult(ITEM, failures))
        bar(report)
    line = last_line(capsys)
    assert " 0/5 " in line
    assert "3 no path, 1 goal not reached, 2 given up" in line
    bar(replace(report, deaths=(WorkerDeath(ITEM, "SIGKILL"),)))
    assert line_ends(last_line(capsys), "2 given up, 1 workers died")


def line_ends(line: str, words: str) -> bool:
    """Whether the notes of the bar end so."""
    return line.rstrip().removesuffix("]").endswith(words)


def test_the_last_state_stays(clock: Clock, capsys: Capture) -> None:
    """Closing leaves the line and ends it; a bar that was never called has none."""
    RecordBar("record").close()
    assert capsys.readouterr().err == ""
    bar = RecordBar("record")
    bar(RecordReport(wanted=2, found=0))
    clock.now += 1.0
    bar(RecordReport(wanted=2, found=0, recorded=2))
    bar.close()
    err = capsys.readouterr().err
    assert err.endswith("\n")
    assert re.search(r"record: 100%.* 2/2 .*2\.00episode/s", err.rsplit("\r", 1)[-1])


def test_the_bar_of_a_check_counts_trials_and_their_rate(clock: Clock, capsys: Capture) -> None:
    """Trials of an earlier run count as done but not for the rate; the last item is named."""
    bar, item = CheckBar("check"), Item("open_drawer", "noop", (0, 1), 3)
    bar(CheckProgress(20, 10, 0))
    assert re.search(r"check: +50%.* 10/20 ", last_line(capsys))
    for done in (2, 4):
        clock.now += 4.0
        bar(CheckProgress(20, 10, done, item))
    line = last_line(capsys)
    assert re.search(r"check: +70%.* 14/20 .*00:08<00:12, +2\.00s/trial, open_drawer noop", line), line
    bar.close()
    assert capsys.readouterr().err.endswith("\n")


def test_without_a_terminal_there_are_plain_lines(clock: Clock, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """At the start, then one in ten seconds, and one at the end; no control characters, which would fill a log."""
    monkeypatch.setattr("rlbench_pin.cli.bars.is_terminal", lambda: False)
    bar = RecordBar("record")
    for recorded in range(13):
        bar(RecordReport(wanted=12, found=0, recorded=recorded))
        clock.now += 2.0
    bar.close()
    lines = capsys.readouterr().err.splitlines()
    assert [re.search(r"(\d+)/12 ", line)[1] for line in lines] == ["0", "5", "10", "12"]  # type: ignore[index]
    assert all(line.startswith("record: ") and line.isprintable() for line in lines)
