"""Tasks of the library open and save byte-identically; undo and redo give the texts of before and after."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.document.scene_text import layout_of
from rlbench_pin.builder.document.texts import Change, History
from rlbench_pin.scene import read_scene
from rlbench_pin.tasks import LIBRARY, Task, task_class
from tests.builder.document.conftest import EDITABLE, Opener
from tests.builder.document.random_edits import EDITS, edit_at_random

FORMS = (
    "title",
    "description",
    "instructions",
    "variation_count",
    "solved_by_chance",
    "graspable",
    "success",
    "failure",
    "placements",
)


@pytest.mark.parametrize("task", EDITABLE)
def test_a_task_opens_and_saves_byte_equal(opened: Opener, task: str) -> None:
    """Without problems, with the scene that simulation reads; both files are written, and are what they were."""
    document = opened(task)
    spec = read_scene(document.folder / f"{task}.toml")
    assert document.spec == spec and document.problems == () and not document.unsaved
    document.save()
    for end in (".toml", ".py"):
        assert (document.folder / f"{task}{end}").read_bytes() == (LIBRARY / f"{task}{end}").read_bytes()


@pytest.mark.parametrize("task", EDITABLE)
def test_every_form_set_to_what_it_is_changes_nothing(task: str) -> None:
    """Keys of all elements, of the placement, and all of the behaviour that forms can show: not one step is made."""
    document = TaskDocument.open(LIBRARY / f"{task}.py")
    spec = document.spec
    assert spec is not None
    for thing in (*spec.posed(), *spec.joint):
        for key in type(thing).model_fields.keys() - {"name"}:
            document.set(thing.name, key, getattr(thing, key))
    for key in type(spec.placement).model_fields:
        document.set_placement(key, getattr(spec.placement, key))
    for form in FORMS:
        value = getattr(document.behaviour, form)
        if value is not None:
            document.set_behaviour(form, value)
    assert document.step == 0 and not document.unsaved


def test_forms_can_edit_most_of_the_library() -> None:
    """Title, description, chance and failure of tasks that extend no other; the rest where the Python is plain."""
    assert set(FORMS) == {field.name for field in fields(TaskDocument.open(LIBRARY / "open_box.py").behaviour)} - {"python"}
    plain = [task for task in EDITABLE if task_class(task).__base__ is Task]
    behaviours = [TaskDocument.open(LIBRARY / f"{task}.py").behaviour for task in plain]
    shares = {form: sum(getattr(b, form) is not None for b in behaviours) / len(behaviours) for form in FORMS}
    assert min(shares[form] for form in ("title", "description", "solved_by_chance", "failure")) == 1.0
    assert min(shares[form] for form in ("instructions", "success")) > 0.9
    assert min(shares.values()) > 0.5


@pytest.mark.parametrize("task", EDITABLE)
def test_the_layout_covers_the_text(task: str) -> None:
    """Sections and keys stand where their text is, in order, and what is between them is blank or a comment."""
    text = (LIBRARY / f"{task}.toml").read_text()
    at = 0
    for section in layout_of(text):
        assert all(not line or line.startswith("#") for line in text[at : section.start].splitlines())
        assert text[section.heading :].startswith("[") or not section.path
        for item in section.items:
            assert text[item.start :].startswith(item.key)
            assert text[item.value[0] - 2 : item.value[0]] == "= "
            assert not text[slice(*item.value)].endswith((" ", "\n"))
        at = section.end
    assert text[at:].strip() == ""


# Undo and redo ----------------------------------------------------------------------------------------------------------------


TASKS = ("setup_checkers", "stack_blocks", "open_drawer", "pick_and_lift", "put_groceries_in_cupboard", "close_box")


@pytest.mark.simulation
@pytest.mark.parametrize("task", TASKS)
def test_a_hundred_random_edits_are_undone_and_made_again(opened: Opener, task: str) -> None:
    """Undone one by one they give the texts of before, byte by byte; made again, those of after, and of each instant."""
    document = opened(task)
    rng = np.random.default_rng([ord(letter) for letter in task])
    texts = [_texts(document)]
    kinds: set[str] = set()
    for _ in range(100):
        kinds |= edit_at_random(document, 1, rng)
        texts.append(_texts(document))
        assert document.spec is not None and not [p for p in document.problems if p.file == "scene"]
    assert len(kinds) > len(EDITS) // 2
    while document.undoable:
        document.undo()
        assert _texts(document) in texts
    assert _texts(document) == texts[0] and not document.unsaved
    document.save()
    assert TaskDocument.open(document.folder / f"{task}.py").text == document.text
    while document.redoable:
        document.redo()
    assert _texts(document) == texts[-1]


def _texts(document: TaskDocument) -> tuple[str, str]:
    return document.scene_text, document.python_text


def test_a_drag_is_one_step(opened: Opener) -> None:
    """Edits of one key that follow each other are undone together; another edit, or an undo, begins a new step."""
    document = opened("open_drawer")
    before = document.scene_text
    for x in (0.1, 0.2, 0.3):
        document.set("waypoint0", "pose", [x, 0.0, 0.0], merge="drag")
    assert document.step == 3 and document.undoable == "change pose of waypoint0"
    document.undo()
    assert document.scene_text == before and not document.undoable and document.redoable
    document.set("waypoint0", "pose", [0.4, 0.0, 0.0], merge="drag")
    document.set("waypoint0", "gripper", "close")
    document.set("waypoint0", "pose", [0.5, 0.0, 0.0], merge="drag")
    assert [document.undo() for _ in range(4)] == [
        "change pose of waypoint0",
        "change gripper of waypoint0",
        "change pose of waypoint0",
        "",
    ]


def test_a_drag_back_to_its_beginning_leaves_no_step() -> None:
    """What is as it was before needs no undo."""
    history = History(("a", "b"))
    history.add("drag", ("c", "b"), "key")
    history.add("drag", ("a", "b"), "key")
    assert not history.undoable and history.texts == ("a", "b") and history.count == 2


def test_a_new_edit_forgets_what_was_undone() -> None:
    """There is nothing to make again after it."""
    history = History(("a", ""))
    history.add("one", ("b", ""))
    history.undo()
    assert history.redoable == "one"
    history.add("two", ("c", ""))
    assert not history.redoable and history.redo() == "" and history.undo() == "two"


def test_an_edit_that_changes_nothing_is_none() -> None:
    """It is no step."""
    history = History(("a", ""))
    history.add("one", ("a", ""))
    assert history.count == 0 and not history.undoable


@pytest.mark.parametrize(("old", "new"), [("", "a"), ("aaa", "aa"), ("abcb", "abcbcb"), ("x", "y"), ("same", "same"), ("ab", "")])
def test_a_change_is_the_shortest_stretch_and_goes_both_ways(old: str, new: str) -> None:
    """Also where texts repeat themselves."""
    change = Change.between(old, new)
    assert change.applied(old) == new and change.reverted(new) == old
    assert len(change.old) + len(change.new) <= abs(len(old) - len(new)) + 2 * min(len(old), len(new))
    assert not change.old or not change.new or change.old[0] != change.new[0]
