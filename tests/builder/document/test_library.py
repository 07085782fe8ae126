"""All tasks of the library open, and what is not changed keeps its bytes."""

from __future__ import annotations

from dataclasses import fields

import pytest

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.document.scene_text import layout_of
from rlbench_pin.scene import read_scene
from rlbench_pin.tasks import LIBRARY, library_names
from tests.builder.document.conftest import Opener

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


@pytest.mark.parametrize("task", library_names())
def test_a_task_opens_and_saves_byte_equal(opened: Opener, task: str) -> None:
    """Without problems, with the scene that simulation reads; both files are written, and are what they were."""
    document = opened(task)
    spec = read_scene(document.folder / f"{task}.toml")
    assert document.spec == spec and document.problems == () and not document.unsaved
    document.save()
    for end in (".toml", ".py"):
        assert (document.folder / f"{task}{end}").read_bytes() == (LIBRARY / f"{task}{end}").read_bytes()


@pytest.mark.parametrize("task", library_names())
def test_every_form_set_to_what_it_is_changes_nothing(task: str) -> None:
    """Keys of all things, of the placement, and all of the behaviour that forms can show: not one step is made."""
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
    """Title, description, chance and failure everywhere; the rest where the Python is plain."""
    assert set(FORMS) == {field.name for field in fields(TaskDocument.open(LIBRARY / "open_box.py").behaviour)} - {"python"}
    behaviours = [TaskDocument.open(LIBRARY / f"{task}.py").behaviour for task in library_names()]
    shares = {form: sum(getattr(b, form) is not None for b in behaviours) / len(behaviours) for form in FORMS}
    assert min(shares[form] for form in ("title", "description", "solved_by_chance", "failure")) == 1.0
    assert min(shares[form] for form in ("instructions", "success")) > 0.9
    assert min(shares.values()) > 0.5


@pytest.mark.parametrize("task", library_names())
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
