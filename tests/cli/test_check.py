"""The validator as a whole: what it writes, how it goes on where it was stopped, how it ends."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from rlbench_pin.checking import run
from rlbench_pin.checking.plan import Item
from rlbench_pin.checking.records import DemoTrial, FailedAttempt, ReachTrial, Trial
from rlbench_pin.checking.run import TrialJournal
from rlbench_pin.checking.trials import work
from rlbench_pin.cli.main import main
from rlbench_pin.errors import ResetError, RlbenchPinError
from rlbench_pin.processes import GivenUp

Capture = pytest.CaptureFixture[str]
QUICK = ("--episodes", "6", "--contract-seeds", "1", "--placements", "10")


def _without_times(report: dict[str, Any]) -> dict[str, Any]:
    for task in report["tasks"].values():
        for key in ("median_planning_s", "times_real_time", "speed"):
            del task[key]
        for segment in task["segments"]:
            del segment["planning_median_ms"], segment["planning_p95_ms"]
    return report


def test_a_report_folder_holds_page_data_and_images(tmp_path: Path, capsys: Capture) -> None:
    """Every part of the contract is in the JSON, and each image that the page names is there."""
    assert main(["check", "reach_target", *QUICK, "--out", str(tmp_path)]) == 0
    assert str(tmp_path / "report.md") in capsys.readouterr().out
    report = json.loads((tmp_path / "report.json").read_text())["tasks"]["reach_target"]
    assert report["passed"]
    assert [report[rate]["of"] for rate in ("first_try", "noop", "random", "repeat", "tidy", "accepted")] == [6, 1, 1, 1, 6, 10]
    assert len(report["instructions"]) == 20
    assert set(report["per_variation"]) == {"0", "1", "2", "3", "4", "5"}
    assert [(segment["waypoint"], segment["count"]) for segment in report["segments"]] == [(0, 6)]
    assert report["speed"]["physics_share"] + report["speed"]["planning_share"] < 1.0
    page = (tmp_path / "report.md").read_text()
    for picture in ("images/reach_target.jpg", "images/reach_target_reach.png"):
        assert f"]({picture})" in page
        with Image.open(tmp_path / picture) as image:
            assert image.width > 400


def test_a_report_is_added_to(tmp_path: Path, capsys: Capture) -> None:
    """Tasks that did not change stay as they are, those that changed or were checked with other numbers are checked again."""
    file = tmp_path / "table.json"
    check = ["--episodes", "1", "--no-contract", "--key-frames", "0", "--update", str(file)]
    assert main(["check", "push_button", *check]) == 0
    capsys.readouterr()
    table = json.loads(file.read_text())
    table["tasks"]["push_button"]["median_frames"] = -1
    table["tasks"]["close_door"] = table["tasks"]["push_button"] | {"mark": "of an earlier version"}
    file.write_text(json.dumps(table))
    assert main(["check", "reach_target", "push_button", *check]) == 0
    assert "2 tasks, 1 of them unchanged" in capsys.readouterr().out
    tasks = json.loads(file.read_text())["tasks"]
    assert list(tasks) == ["push_button", "reach_target"]
    assert tasks["push_button"]["median_frames"] == -1
    assert main(["check", "push_button", *check, "--seed", "3"]) == 0
    tasks = json.loads(file.read_text())["tasks"]
    assert list(tasks) == ["push_button"]
    assert tasks["push_button"]["median_frames"] > 0


@pytest.mark.parametrize("text", ["[]", "{", '{"format": 3}', '{"tasks": 1}'])
def test_what_is_no_report_is_not_added_to(tmp_path: Path, capsys: Capture, text: str) -> None:
    """It is refused before the work begins, and stays as it is."""
    file = tmp_path / "table.json"
    file.write_text(text)
    assert main(["check", "push_button", "--update", str(file)]) == 1
    assert "it is not a report of `rlbench-pin check`. Name another file" in capsys.readouterr().err
    assert file.read_text() == text


def test_a_stopped_check_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was finished is not done again, half a line is, and the report is that of a check that was not stopped."""
    arguments = ["check", "reach_target", "--episodes", "12", "--no-contract", "--key-frames", "0", "--no-images"]
    done: list[Item] = []

    def stop_after_two(item: Item) -> list[Trial]:
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(item)
        return work(item)

    monkeypatch.setattr(run, "work", stop_after_two)
    assert main([*arguments, "--out", str(tmp_path / "a")]) == 130
    journal = tmp_path / "a" / "trials.jsonl"
    assert len(journal.read_text().splitlines()) == 2
    with journal.open("a") as file:
        file.write('{"key": "half a li')

    later: list[Item] = []
    monkeypatch.setattr(run, "work", lambda item: later.append(item) or work(item))
    assert main([*arguments, "--out", str(tmp_path / "a")]) == 0
    assert [item.seeds for item in (*done, *later)] == [(0, 1, 2, 3, 4), (5, 6, 7, 8, 9), (10, 11)]
    assert main([*arguments, "--out", str(tmp_path / "b")]) == 0
    resumed, whole = (_without_times(json.loads((tmp_path / name / "report.json").read_text())) for name in "ab")
    assert resumed == whole


def test_trials_survive_the_journal(tmp_path: Path) -> None:
    """Whatever a trial holds comes back equal; another task file makes old trials void."""
    items = [Item("open_drawer", part, (0,), 3) for part in ("words", "demos", "repeat", "noop", "random", "reach", "key_frames")]  # type: ignore[arg-type]
    done = {item: work(item) for item in items}
    journal = TrialJournal(tmp_path / "trials.jsonl", ["open_drawer"])
    for item, trials in done.items():
        journal.add(item, trials)
    again = TrialJournal(tmp_path / "trials.jsonl", ["open_drawer"])
    assert {item: again.trials_of(item) for item in items} == done
    assert again.trials_of(Item("open_drawer", "demos", (1,), 3)) is None


def test_trials_outlive_changes_that_play_no_part(tmp_path: Path) -> None:
    """Comments, docstrings and deviations change no trial; what a scene and its class say does."""
    scene, code = tmp_path / "scene.toml", tmp_path / "scene.py"
    scene.write_text('format = 2  # first\n[placement]\nyaw = [0.0, 1.0]\n[[deviation]]\nname = "yaw"\n', encoding="utf-8")
    code.write_text('"""Class."""\n\n\ndef f():\n    """Text."""\n    return 1  # one\n', encoding="utf-8")
    before = run._content(scene), run._content(code)
    scene.write_text("format = 2\n[placement]\nyaw = [0.0, 1.0]  # rad\n", encoding="utf-8")
    code.write_text("def f():\n    return 1\n", encoding="utf-8")
    assert (run._content(scene), run._content(code)) == before
    scene.write_text("format = 2\n[placement]\nyaw = [0.0, 1.1]\n", encoding="utf-8")
    code.write_text("def f():\n    return 2\n", encoding="utf-8")
    assert run._content(scene) != before[0]
    assert run._content(code) != before[1]


def test_trials_outlive_another_look(tmp_path: Path) -> None:
    """Visuals of a solid model change no trial; its collision shapes do, and so do the visuals of a marker, which has none."""
    urdf = tmp_path / "thing.urdf"
    look = '<visual><geometry><sphere radius="{}"/></geometry></visual>'
    solid = '<collision><geometry><box size="1 1 {}"/></geometry></collision>'

    def content(*shapes: str) -> bytes:
        urdf.write_text(f'<robot name="thing"><link name="thing">{"".join(shapes)}</link></robot>', encoding="utf-8")
        return run._content(urdf)

    assert content(look.format(1), solid.format(1)) == content(solid.format(1), look.format(2), look.format(3))
    assert content(solid.format(1)) != content(solid.format(2))
    assert content(look.format(1)) != content(look.format(2))


def test_failures_survive_the_journal(tmp_path: Path) -> None:
    """So do failed attempts and draws without a place; a line that an earlier version wrote is done again."""
    path = tmp_path / "trials.jsonl"
    head: dict[str, Any] = {"task": "open_drawer", "seed": 0, "variation": 0}
    failed: list[Trial] = [DemoTrial(**head, failed=(FailedAttempt("no path: x", 2), FailedAttempt("reset: y", None)))]
    placeless: list[Trial] = [ReachTrial(**head, no_place="reset: crowded"), ReachTrial(**head, error="KeyError: 'cup'")]
    demos, reach = Item("open_drawer", "demos", (0,), 3), Item("open_drawer", "reach", (0, 1), 3)
    TrialJournal(path, ["open_drawer"]).add(demos, failed)
    TrialJournal(path, ["open_drawer"]).add(reach, placeless)
    again = TrialJournal(path, ["open_drawer"])
    assert (again.trials_of(demos), again.trials_of(reach)) == (failed, placeless)
    (first, second) = map(json.loads, path.read_text().splitlines())
    first["trials"] = [{**head, "part": "demos", "success": False, "tries": 10}]
    path.write_text(f"{json.dumps(first)}\n{json.dumps(second)}\n")
    again = TrialJournal(path, ["open_drawer"])
    assert (again.trials_of(demos), again.trials_of(reach)) == (None, placeless)


def test_a_changed_task_file_is_judged_anew(tmp_path: Path) -> None:
    """Trials in a journal count only for the same text of the task."""
    main(["new", "touch_it", "--out", str(tmp_path)])
    file = tmp_path / "touch_it.py"
    item, trial = Item(str(file), "demos", (0,), 3), DemoTrial(task="touch_it", seed=0, variation=0)
    TrialJournal(tmp_path / "trials.jsonl", [str(file)]).add(item, [trial])
    assert TrialJournal(tmp_path / "trials.jsonl", [str(file)]).trials_of(item) == [trial]
    file.write_text(file.read_text() + "CHANGED = True\n")
    assert TrialJournal(tmp_path / "trials.jsonl", [str(file)]).trials_of(item) is None


BROKEN = """
    def init_episode(self, variation, rng):
        return {}["cup"]
"""


def test_a_task_that_raises_fails_with_what_it_raised(tmp_path: Path, capsys: Capture) -> None:
    """The check goes on, and says the error and where."""
    main(["new", "touch_it", "--out", str(tmp_path)])
    file = tmp_path / "touch_it.py"
    text = file.read_text()
    file.write_text(text[: text.index("    def init_episode")].rstrip() + "\n" + BROKEN)
    assert main(["check", "--task-file", str(file), "--episodes", "2", "--contract-seeds", "1", "--placements", "2"]) == 1
    out = capsys.readouterr().out
    assert "raises an error" in out
    assert "KeyError: 'cup'" in out


def test_a_dead_worker_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error says what to do."""

    class Dying:
        def __init__(self, workers: int) -> None:
            pass

        def map(self, worker: object, items: Sequence[Item], stop: object, max_deaths: int) -> Iterator[GivenUp[Item]]:
            yield GivenUp(items[0], "worker died: 3 times, the last with SIGKILL")

    monkeypatch.setattr(run, "ProcessEngine", Dying)
    items = [Item("reach_target", "demos", (seed,), 1) for seed in (0, 1)]
    with pytest.raises(RlbenchPinError, match="'demos' of the check of 'reach_target'.* died.*continues from here"):
        run.run_trials(items, 2, TrialJournal(None, ["reach_target"]))


def test_a_reset_that_fails_counts_against_the_task(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """It is a failed demonstration, with its cause."""

    def refuse(*args: object, **options: object) -> None:
        raise ResetError("reach_target", ["WaypointError: too far"])

    monkeypatch.setattr("rlbench_pin.environment.task_environment.start_episode", refuse)
    assert main(["check", "reach_target", "--episodes", "2", "--no-contract"]) == 1
    assert "2 x reset: " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("reach_target", "--episodes", "0"), "--episodes is 0"),
        (("reach_target", "--workers", "0"), "--workers is 0"),
        (("--task-file", "nowhere/task.py"), "no task file"),
    ],
)
def test_misuse_is_explained(arguments: tuple[str, ...], says: str, capsys: Capture) -> None:
    """Exit code 2, before anything is done."""
    assert main(["check", *arguments]) == 2
    assert says in capsys.readouterr().err


@pytest.mark.slow
def test_the_number_of_workers_changes_nothing_but_speed(tmp_path: Path, capsys: Capture) -> None:
    """The same report from one process and from two."""
    reports = []
    for workers in ("1", "2"):
        file = tmp_path / f"{workers}.json"
        assert main(["check", "reach_target", *QUICK, "--workers", workers, "--json", str(file)]) == 0
        reports.append(_without_times(json.loads(file.read_text())))
    assert "reach_target" in capsys.readouterr().out
    assert reports[0] == reports[1]


@pytest.mark.slow
def test_a_killed_check_leaves_no_worker_and_goes_on(tmp_path: Path) -> None:
    """Killed without warning, its workers end by themselves, and the next one keeps what was done."""
    arguments = [
        "check",
        "reach_target",
        "--episodes",
        "40",
        "--no-contract",
        "--key-frames",
        "0",
        "--no-images",
        "--out",
        str(tmp_path),
    ]
    command = [sys.executable, "-m", "rlbench_pin.cli.main", *arguments, "--workers", "2"]
    journal = tmp_path / "trials.jsonl"
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
        assert _soon(lambda: journal.is_file() and len(journal.read_text().splitlines()) >= 2)
        children = Path(f"/proc/{running.pid}/task/{running.pid}/children").read_text().split()
        running.kill()
    assert len(children) >= 2
    assert _soon(lambda: not any(Path(f"/proc/{child}").exists() for child in children), 60)
    before = journal.read_text().splitlines()
    assert main(arguments) == 0
    assert journal.read_text().splitlines()[: len(before) - 1] == before[:-1]
    keys = [json.loads(json.loads(line)["key"]) for line in journal.read_text().splitlines()]
    if len({key["mark"] for key in keys}) > 1:
        pytest.skip("the package was edited meanwhile, so that old trials are void")
    assert sorted(seed for key in keys for seed in key["seeds"]) == list(range(40))


def _soon(holds: Callable[[], bool], seconds: float = 240.0) -> bool:
    """Wait until something holds."""
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.1)
    return holds()
