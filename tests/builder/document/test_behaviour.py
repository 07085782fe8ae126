"""What forms read of the Python of a task, and what they write: as a person would, hand-written parts byte by byte."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import pytest

from rlbench_pin.builder.document import (
    Behaviour,
    ConditionForm,
    EditRefused,
    Named,
    SpawnedForm,
    SpawnForm,
    TaskDocument,
    Written,
    condition_kinds,
)
from rlbench_pin.errors import InvalidValue, UnknownName
from rlbench_pin.tasks import conditions
from tests.builder.document.conftest import Opener

CUBE, ON_SQUARE = Named("body", "cube"), Named("sensor", "on_square")
ON, LET_GO = ConditionForm("Detected", {"element": CUBE, "sensor": ON_SQUARE}), ConditionForm("NothingGrasped")
EXPECTED = '''\
"""Put a cube on a square."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import NO_ROTATION, Detected, NothingGrasped, SpawnBoundary, Task


class PutCubeOnSquare(Task):
    """The cube has to lie on the square, let go.

    Both lie anywhere on a patch.
    """

    def init_task(self) -> None:
        """Look up the elements of the scene, and define success."""
        self.cube = self.world.body("cube")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["cube"])
        self.register_success_conditions([Detected(self.cube, self.world.sensor("on_square")), NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Set up the episode, and return the instructions."""
        self.patch.clear()
        self.patch.sample(self.world.body("square"), rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION)
        self.patch.sample(self.cube, rng, min_distance=0.12)
        return ["Put the cube on the square.", "Lay the block down on the square."]
'''.replace("self.patch", "self.boundary")


@pytest.fixture
def built(tmp_path: Path) -> TaskDocument:
    """Return a task whose behaviour was made by forms alone."""
    document = TaskDocument.new(tmp_path, "put_cube_on_square")
    square, still = Named("body", "square"), (0.0, 0.0, 0.0)
    document.set_behaviour("title", "Put a cube on a square.")
    document.set_behaviour("description", "The cube has to lie on the square, let go.\n\nBoth lie anywhere on a patch.")
    document.set_behaviour("success", [ON, LET_GO])
    document.set_behaviour("graspable", ["cube"])
    things = (SpawnedForm(square, still, still), SpawnedForm(CUBE, min_distance=0.12))
    document.set_behaviour("placements", [SpawnForm(("patch",), things)])
    document.set_behaviour("instructions", [["Put the cube on the square.", "Lay the block down on the square."]])
    return document


def test_forms_write_what_a_person_would(built: TaskDocument) -> None:
    """A whole class, with its imports; what is used twice is looked up once."""
    assert built.python_text == EXPECTED


def test_each_edit_can_be_undone_and_taken_back_by_another(built: TaskDocument) -> None:
    """Forms set back leave an empty task, without idle imports and attributes."""
    empty = TaskDocument.new(built.folder, "put_cube_on_square").python_text
    behaviour = Behaviour.of(empty)
    for field in ("placements", "graspable", "success", "description", "title", "instructions"):
        built.set_behaviour(field, getattr(behaviour, field))
    assert built.python_text == empty
    assert built.step == 12
    while built.undo():
        pass
    assert built.python_text == empty


def test_what_is_written_is_formatted(built: TaskDocument) -> None:
    """The formatter and the linter of this repository find nothing to change, with long lists and deep conditions, too."""
    held = ConditionForm("Grasped", {"body": CUBE})
    several = ConditionForm("DetectedSeveral", {"elements": (CUBE, Named("body", "square")), "sensor": ON_SQUARE, "count": 2})
    deep = ConditionForm("InOrder", {"members": (held, ConditionForm("AnyOf", {"members": (several, ON, LET_GO)}), held)})
    built.set_behaviour("success", [deep, LET_GO, ConditionForm("TipInside", {"sensor": ON_SQUARE})])
    built.set_behaviour("failure", [ConditionForm("JointMoved", {"joint": Named("joint", "square/hinge"), "distance": 0.25})])
    built.set_behaviour("instructions", [["Say \"so\" or 'so'. " * 4, "ä" * 60, 'She says "no".'], ["a"], ["b \\ c", "d"]])
    built.set_behaviour("solved_by_chance", True)
    built.save()
    ruff = (sys.executable, "-m", "ruff")
    file = str(built.folder / "put_cube_on_square.py")
    root = str(Path(__file__).parents[3] / "pyproject.toml")
    formatted = subprocess.run([*ruff, "format", "--diff", "--config", root, file], capture_output=True, text=True, check=False)
    assert formatted.stdout == "" and formatted.returncode == 0, formatted.stderr
    own = 'lint.isort.known-first-party=["rlbench_pin"]'
    found = subprocess.run([*ruff, "check", "--config", root, "--config", own, file], capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout
    assert built.behaviour.variation_count == 3 and built.behaviour.success is not None and built.behaviour.success[0] == deep


def test_conditions_are_read_through_names(opened: Opener) -> None:
    """Attributes, local names, numbers that are computed of numbers; what cannot be shown is as it is written."""
    assert opened("pick_and_lift").behaviour.success == (
        ConditionForm("Grasped", {"body": Named("body", "block")}),
        ConditionForm("Detected", {"element": Named("body", "block"), "sensor": Named("sensor", "goal")}),
    )
    (moved,) = opened("open_grill").behaviour.success or ()
    assert isinstance(moved, ConditionForm) and moved.arguments["joint"] == Named("joint", "grill/lid")
    assert moved.arguments["distance"] == pytest.approx(0.8726646)
    (press,) = opened("push_button").behaviour.success or ()
    assert press == ConditionForm(
        "InOrder", {"members": (ConditionForm("JointMoved", {"joint": Named("joint", "button/cap_joint"), "distance": 0.003}),)}
    )
    tower = opened("stack_blocks").behaviour.success
    assert tower is not None and tower[1:] == (Written("*levels"), LET_GO)


@pytest.mark.parametrize(
    ("task", "old", "new"),
    [
        ("open_grill", "np.deg2rad(50.0)", "np.deg2rad(40.0)"),
        (
            "push_button",
            'JointMoved(self.world.joint("button/cap_joint"), 0.003)',
            'JointMoved(self.world.joint("button/cap_joint"), 0.698132)',
        ),
    ],
)
def test_a_number_changes_where_it_stands(opened: Opener, task: str, old: str, new: str) -> None:
    """Through the name of its condition, and in degrees where it was; nothing else changes."""
    document = opened(task)
    before = document.python_text
    (form,) = document.behaviour.success or ()
    assert isinstance(form, ConditionForm) and old in before
    if task == "open_grill":
        form = ConditionForm(form.kind, {**form.arguments, "distance": 0.6981317})
    else:
        form = ConditionForm(
            "InOrder",
            {"members": (ConditionForm("JointMoved", {"joint": Named("joint", "button/cap_joint"), "distance": 0.698132}),)},
        )
    document.set_behaviour("success", [form])
    assert document.python_text == before.replace(old, new)


def test_hand_written_parts_stay_when_a_condition_goes(opened: Opener) -> None:
    """A name that only this condition used goes with it, and so does the import."""
    document = opened("take_off_weighing_scales")
    before, forms = document.python_text, document.behaviour.success
    assert forms is not None and forms[0] == LET_GO
    document.set_behaviour("success", forms[1:])
    gone = set(before.splitlines()) - set(document.python_text.splitlines())
    assert len(gone) == 2 and all("NothingGrasped" in line for line in gone)
    document.set_behaviour("success", forms)
    assert document.python_text == before


def test_sentences_with_fields_stay_f_strings(opened: Opener) -> None:
    """A new one is one when it has the fields of the others; others are plain texts."""
    document = opened("push_button")
    plain = document.python_text.replace(
        "return self.make_instructions(name=name)", 'return [f"Press the {name} button.", f"Push the button of {name}."]'
    )
    document.set_python_text(plain)
    (sentences,) = document.behaviour.instructions or ()
    assert sentences[0] == "Press the {name} button."
    document.set_behaviour("instructions", [[*sentences[:2], "Press {name}.", "Press {other}."]])
    text = document.python_text
    assert f'f"{sentences[1]}"' in text and 'f"Press {name}."' in text and ' "Press {other}."' in text.replace("\n", " ")
    with pytest.raises(EditRefused):
        document.set_behaviour("instructions", [["Press {name}."], ["Push."]])


def test_sentences_of_the_scene_are_edited_there(opened: Opener) -> None:
    """The Python stays; words in braces stay; the other kinds stay; one list serves all variations."""
    document = opened("push_button")
    before, python = document.scene_text, document.python_text
    (sentences,) = document.behaviour.instructions or ()
    assert document.spec is not None and sentences == document.spec.instructions.training and "{name}" in sentences[0]
    document.set_behaviour("instructions", [["Press the {name} one.", *sentences[1:]]])
    changed = before.replace(f'"{sentences[0]}"', '"Press the {name} one."')
    assert document.scene_text == changed and document.python_text == python and document.problems == ()
    document.set_behaviour("instructions", [[*sentences, "Push {name}."]])
    assert document.spec.instructions.training == (*sentences, "Push {name}.")
    with pytest.raises(EditRefused, match="one list"):
        document.set_behaviour("instructions", [["a"], ["b"]])
    document.undo()
    document.undo()
    assert document.scene_text == before


def test_sentences_for_each_variation_are_a_table(built: TaskDocument) -> None:
    """Their number is that of the variations; a table of one's own is edited in place, a dict too."""
    built.set_behaviour("instructions", [["a", "b"], ["c"]])
    assert 'SENTENCES = (\n    ["a", "b"],\n    ["c"],\n)\n' in built.python_text and "        return 2\n" in built.python_text
    built.set_behaviour("instructions", [["a", "b"], ["d"]])
    assert '    ["d"],\n' in built.python_text
    built.set_python_text(built.python_text.replace('(\n    ["a", "b"],\n    ["d"],\n)', '{0: ["a", "b"], 1: ["d"]}'))
    assert built.behaviour.instructions == (("a", "b"), ("d",))
    built.set_behaviour("instructions", [["a", "e"], ["d"]])
    assert '{0: ["a", "e"], 1: ["d"]}' in built.python_text


def test_variations_are_counted_where_the_number_is_written(opened: Opener) -> None:
    """One is the default and needs no method; what is computed is left to the text."""
    document = opened("open_box")
    before = document.python_text
    assert document.behaviour.variation_count == 1
    document.set_behaviour("variation_count", 4)
    assert document.behaviour.variation_count == 4 and "        return 4\n" in document.python_text
    document.set_behaviour("variation_count", 1)
    assert document.python_text == before
    with pytest.raises(EditRefused, match="Edit the text"):
        opened("push_button").set_behaviour("variation_count", 2)


def test_placements_are_edited_among_other_statements(opened: Opener) -> None:
    """Lines of `sample` come and go; the others keep their bytes. Loops and layouts are left to the text."""
    document = opened("lamp_on")
    before = document.python_text
    assert opened("stack_blocks").behaviour.placements is None
    document.set_behaviour("placements", [SpawnForm(("patch",), (SpawnedForm(Named("body", "lamp"), ignore_collisions=True),))])
    new = [line.strip() for line in document.python_text.splitlines() if line not in before.splitlines()]
    assert 'self.boundary = SpawnBoundary([self.world.region("patch")])' in new
    assert any(line.endswith("rng, ignore_collisions=True)") for line in new)
    document.set_behaviour("placements", [])
    assert document.python_text == before


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("variation_count", 0),
        ("variation_count", "two"),
        ("solved_by_chance", "yes"),
        ("success", [ConditionForm("Felt")]),
        ("success", [ConditionForm("Grasped")]),
        ("failure", [ConditionForm("AllOf", {"members": (ConditionForm("Grasped", {"element": CUBE}),)})]),
        ("instructions", []),
        ("graspable", "cube"),
        ("success", ["Detected"]),
        ("placements", [ON]),
        ("instructions", "Go."),
        ("colour", "red"),
    ],
)
def test_values_of_another_kind_are_refused(built: TaskDocument, field: str, value: object) -> None:
    """With an error that names the field."""
    with pytest.raises((InvalidValue, UnknownName)):
        built.set_behaviour(field, value)
    assert built.python_text == EXPECTED


@pytest.mark.parametrize("text", ["", "x = 1\n", "def (", "class A:\n    pass\n", "class A:\n    def init_task(self): ...\n" * 2])
def test_python_without_a_task_has_nothing_to_edit(text: str) -> None:
    """All fields of the class are None."""
    behaviour = Behaviour.of(text)
    assert behaviour.success is None and behaviour.instructions is None and behaviour.description is None


# Kinds of conditions ----------------------------------------------------------------------------------------------------------


def test_every_condition_has_a_form_but_those_of_code() -> None:
    """All of the vocabulary; a list that the task keeps is not a form's."""
    assert {kind.name for kind in condition_kinds()} == set(conditions.__all__) - {"Condition", "ListEmpty"}


def test_parameters_are_those_of_the_class() -> None:
    """Names, order and defaults, arm and hand left out, each with what its docstring says."""
    for kind in condition_kinds():
        signature = inspect.signature(getattr(conditions, kind.name)).parameters
        shown = {name: p for name, p in signature.items() if name not in ("robot", "gripper")}
        assert [parameter.name for parameter in kind.parameters] == list(shown)
        for parameter in kind.parameters:
            default = shown[parameter.name].default
            assert parameter.required == (default is inspect.Parameter.empty)
            assert parameter.required or parameter.default == default
            assert parameter.text.endswith(".") and ":" not in parameter.text.partition(". ")[2], parameter
        assert kind.text.endswith(".")


def test_kinds_say_what_a_form_asks_for() -> None:
    """A few of them."""
    kinds = {kind.name: {p.name: p.kind for p in kind.parameters} for kind in condition_kinds()}
    assert kinds["Detected"] == {"element": "place", "sensor": "sensor", "negated": "flag"}
    assert kinds["DetectedSeveral"] == {"elements": "places", "sensor": "sensor", "count": "whole"}
    assert kinds["JointMoved"] == {"joint": "joint", "distance": "number"}
    assert kinds["AllOf"] == {"members": "conditions"} and kinds["NothingGrasped"] == {}
    assert kinds["FollowPath"]["points"] == "points" and kinds["FollowPath"]["frame"] == "frame"
