"""What was edited and not saved survives: it is offered at the next opening, and gone when it is saved."""

from __future__ import annotations

import json
import os
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.builder.document import DraftKeeper, TaskDocument
from rlbench_pin.tasks.registry import LIBRARY

NAME = "pick_and_lift"


def _nothing() -> None:
    """Nobody listens."""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A copy of a task."""
    for ending in (".toml", ".py"):
        shutil.copy(LIBRARY / f"{NAME}{ending}", tmp_path)
    return tmp_path / f"{NAME}.toml"


def _edit(document: TaskDocument, keeper: DraftKeeper, word: str = "one") -> None:
    document.set_python_text(f"{document.python_text}# {word}\n")
    keeper.keep()


def _keeper(document: TaskDocument) -> DraftKeeper:
    return DraftKeeper(document, _nothing, wait=0.05)


def _lose(scene: Path, word: str = "one") -> TaskDocument:
    """Edit a task, and go without saving."""
    document = TaskDocument.open(scene)
    keeper = _keeper(document)
    _edit(document, keeper, word)
    keeper.close()
    return document


def test_opening_leaves_no_file(scene: Path) -> None:
    """Nor does an edit that was undone."""
    before = sorted(scene.parent.iterdir())
    document = TaskDocument.open(scene)
    keeper = _keeper(document)
    keeper.close()
    assert sorted(scene.parent.iterdir()) == before
    keeper = _keeper(document)
    _edit(document, keeper)
    time.sleep(0.3)
    assert keeper.file.is_file()
    document.undo()
    keeper.keep()
    assert sorted(scene.parent.iterdir()) == before


def test_a_draft_is_offered_and_taken_up(scene: Path) -> None:
    """As one edit, which can be undone; the file stays until that is saved."""
    lost = _lose(scene)
    document = TaskDocument.open(scene)
    keeper = _keeper(document)
    before = document.texts
    assert [draft.texts for draft in keeper.offered] == [lost.texts]
    assert keeper.is_of_now(keeper.offered[0])
    keeper.take()
    assert document.texts == lost.texts
    assert document.undo() == "take up the draft"
    assert document.texts == before
    document.redo()
    keeper.keep()
    keeper.close()
    assert keeper.file.is_file()
    keeper = _keeper(document)
    document.save()
    keeper.keep()
    assert not keeper.file.exists()


def test_a_draft_is_dropped(scene: Path) -> None:
    """For good."""
    _lose(scene)
    keeper = _keeper(TaskDocument.open(scene))
    keeper.drop()
    assert keeper.offered == []
    assert not keeper.file.exists()


def test_an_undecided_draft_outlives_others(scene: Path) -> None:
    """Edits beside it, a save, and a second loss; each is offered, the latest first."""
    first = _lose(scene, "first")
    document = TaskDocument.open(scene)
    keeper = _keeper(document)
    _edit(document, keeper, "saved")
    document.save()
    keeper.keep()
    _edit(document, keeper, "second")
    keeper.close()
    again = _keeper(TaskDocument.open(scene))
    assert [draft.texts for draft in again.offered] == [document.texts, first.texts]
    assert [again.is_of_now(draft) for draft in again.offered] == [True, False]
    again.take()
    again.drop()
    again.close()


def test_a_draft_that_was_saved_elsewhere_is_not_offered(scene: Path) -> None:
    """Its texts are those of the files."""
    lost = _lose(scene)
    scene.with_suffix(".py").write_text(lost.python_text)
    keeper = _keeper(TaskDocument.open(scene))
    assert keeper.offered == []
    assert not keeper.file.exists()


def test_a_new_task_is_kept_once_something_is_in_it(tmp_path: Path) -> None:
    """Also when its folder is not there yet."""
    folder = tmp_path / "mine"
    keeper = _keeper(TaskDocument.new(folder, "thing"))
    keeper.close()
    assert not folder.exists()
    document = TaskDocument.new(folder, "thing")
    keeper = _keeper(document)
    _edit(document, keeper)
    keeper.close()
    assert [draft.texts for draft in _keeper(TaskDocument.new(folder, "thing")).offered] == [document.texts]


@pytest.mark.parametrize(
    "kind", ["random", "json", "other task", "numbers", "surrogate", "deep", "folder", "link", "pipe", "huge"]
)
def test_what_is_no_draft_is_set_aside(scene: Path, kind: str) -> None:
    """With a message; the task opens, and new drafts are written."""
    file = scene.parent / f".{NAME}.draft"
    good = {"format": 1, "task": NAME, "drafts": [{"files": ["a", "b"], "saved": ["", ""], "written": ""}]}
    match kind:
        case "random":
            file.write_bytes(np.random.default_rng(1).bytes(5000))
        case "json":
            file.write_text('{"format": 1}')
        case "other task":
            file.write_text(json.dumps({**good, "task": "other"}))
        case "numbers":
            file.write_text(json.dumps({**good, "drafts": [{"files": [1, 2], "saved": ["", ""], "written": ""}]}))
        case "surrogate":
            file.write_text(json.dumps({**good, "drafts": [{"files": ["\ud800", ""], "saved": ["", ""], "written": ""}]}))
        case "deep":
            file.write_text("[" * 100_000)
        case "folder":
            file.mkdir()
        case "link":
            file.symlink_to("/etc/passwd")
        case "pipe":
            os.mkfifo(file)
        case _:
            with file.open("wb") as stream:
                stream.truncate(2**30)
    document = TaskDocument.open(scene)
    keeper = _keeper(document)
    assert "set aside" in keeper.news
    assert keeper.offered == []
    assert not os.path.lexists(file)
    assert os.path.lexists(f"{file}.broken")
    _edit(document, keeper)
    keeper.close()
    assert file.is_file()
    assert Path("/etc/passwd").read_text().startswith("root")


@pytest.mark.parametrize("seed", range(60))
def test_damaged_drafts_are_set_aside_or_offered(scene: Path, seed: int) -> None:
    """Bytes that were changed or cut at random never keep a task from opening."""
    _lose(scene)
    file, rng = scene.parent / f".{NAME}.draft", np.random.default_rng(seed)
    content = np.frombuffer(file.read_bytes(), np.uint8).copy()
    content[rng.integers(0, len(content), 3)] = rng.integers(0, 256, 3)
    file.write_bytes(content.tobytes()[: int(rng.integers(1, len(content) + 1))])
    keeper = _keeper(TaskDocument.open(scene))
    assert bool(keeper.offered) != bool(keeper.news)


def test_a_draft_that_cannot_be_written_is_told(scene: Path) -> None:
    """At once, to whoever shows the page; editing goes on."""
    heard: list[str] = []
    document = TaskDocument.open(scene)
    keeper = DraftKeeper(document, lambda: heard.append(keeper.news), wait=0.05)
    for folder in (keeper.file, keeper.file.with_name(f"{keeper.file.name}.broken")):
        folder.mkdir()
        (folder / "x").touch()
    _edit(document, keeper)
    time.sleep(0.3)
    assert "No draft is kept" in heard[-1]
    assert "lost" in heard[-1]
    keeper.close()
    assert "one" in document.python_text


def test_two_builders_of_one_task_keep_a_draft_each(scene: Path) -> None:
    """Neither takes away what the other would lose, by editing on, by saving, or by undoing everything."""
    first, second = TaskDocument.open(scene), TaskDocument.open(scene)
    keepers = _keeper(first), _keeper(second)
    for word in ("one", "two", "three"):
        _edit(first, keepers[0], f"first {word}")
        time.sleep(0.2)
        _edit(second, keepers[1], f"second {word}")
        time.sleep(0.2)
    assert "Another task builder" in keepers[1].news
    assert {draft.texts for draft in _keeper(TaskDocument.open(scene)).offered} == {first.texts, second.texts}
    first.save()
    keepers[0].keep()
    assert [draft.texts for draft in _keeper(TaskDocument.open(scene)).offered] == [second.texts]
    while second.undoable:
        second.undo()
    keepers[1].keep()
    keepers[1].close()
    assert keepers[1].news == ""
