"""What forms can edit of the Python of a task; everything else in it keeps its bytes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, cast, get_args

from rlbench_pin.builder.document.behaviour.class_words import (
    read_count,
    read_docstring,
    read_flag,
    written_count,
    written_docstring,
    written_flag,
)
from rlbench_pin.builder.document.behaviour.conditions import FAILURE, SUCCESS, Conditions, read_conditions, written_conditions
from rlbench_pin.builder.document.behaviour.forms import ConditionForm, SpawnForm, Written
from rlbench_pin.builder.document.behaviour.graspable import read_graspable, written_graspable
from rlbench_pin.builder.document.behaviour.imports import with_imports
from rlbench_pin.builder.document.behaviour.placements import read_placements, written_placements
from rlbench_pin.builder.document.behaviour.sentences import Sentences, read_sentences, written_sentences
from rlbench_pin.builder.document.behaviour.source import PythonSyntaxError, Source
from rlbench_pin.builder.document.behaviour.task_class import TaskClass
from rlbench_pin.builder.document.behaviour.tidy import tidied
from rlbench_pin.builder.document.errors import EditRefused
from rlbench_pin.values import as_choice, as_flag, as_names, as_record, as_several, as_text, as_whole

Field = Literal[
    "title",
    "description",
    "instructions",
    "variation_count",
    "solved_by_chance",
    "graspable",
    "success",
    "failure",
    "placements",
]
CHANCE = "solved_by_chance"


@dataclass(frozen=True)
class Behaviour:
    """What forms show of the Python; a field is None where it is not written in a form that can be edited."""

    title: str | None = None
    """Docstring of the file."""
    description: str | None = None
    """Docstring of the class: what varies, and what counts as success."""
    instructions: Sentences | None = None
    """The sentences: one group for all variations, or one for each."""
    variation_count: int | None = None
    """How many variations there are."""
    solved_by_chance: bool | None = None
    """Whether a flailing arm may reach the goal now and then."""
    graspable: tuple[str, ...] | None = None
    """Names of the bodies that the hand may hold, `<body>/<link>` for one link alone."""
    success: Conditions | None = None
    """What has to hold at the same instant."""
    failure: Conditions | None = None
    """What ends an episode without success, all of it at the same instant."""
    placements: tuple[SpawnForm, ...] | None = None
    """What is placed at random in regions."""
    python: str = field(default="", repr=False, compare=False)
    """The text that this was read from."""

    @classmethod
    def of(cls, text: str) -> Behaviour:
        """Read a Python file; all fields are None where it cannot be read, or holds no task."""
        try:
            source = Source(text)
        except PythonSyntaxError:
            return cls(python=text)
        task = TaskClass.of(source)
        if task is None:
            return cls(title=read_docstring(source.tree), python=text)
        return cls(
            read_docstring(source.tree),
            read_docstring(task.node),
            read_sentences(task),
            read_count(task),
            read_flag(task, CHANCE),
            read_graspable(task),
            read_conditions(task, SUCCESS),
            read_conditions(task, FAILURE),
            read_placements(task),
            text,
        )

    def written(self, name: str, value: Any) -> str:
        """Return the Python in which a field says something else; the same text when it says that already.

        Args:
            name: The field.
            value: What it is to say.

        Raises:
            EditRefused: The Python is not of a form that can be edited so.
            InvalidValue: The value is not of the kind of the field.
        """
        as_choice(name, "field", get_args(Field))
        wanted = _checked(cast(Field, name), value)
        if getattr(self, name) is None:
            raise EditRefused(f"change {name}", "the Python does not say it in a form that can be edited.", "Edit the text.")
        if getattr(self, name) == wanted:
            return self.python
        source = Source(self.python)
        task = TaskClass.of(source)
        text = written_docstring(source, source.tree, wanted) if task is None else _written(task, cast(Field, name), wanted)
        if text is None:
            raise EditRefused(f"change {name}", "the Python cannot say it in a form that can be edited.", "Edit the text.")
        try:
            return with_imports(source, tidied(source, text))
        except PythonSyntaxError as error:
            raise EditRefused(f"change {name}", f"it would not be Python any more: {error}.", "Edit the text.") from error


def _written(task: TaskClass, name: Field, value: Any) -> str | None:
    if name in ("title", "description"):
        return written_docstring(task.source, task.source.tree if name == "title" else task.node, value)
    if name == "instructions":
        return _sentences(task, value)
    if name == "variation_count":
        return written_count(task, value)
    if name == "solved_by_chance":
        return written_flag(task, CHANCE, value)
    if name == "graspable":
        return written_graspable(task, value)
    if name == "placements":
        return written_placements(task, value)
    return written_conditions(task, SUCCESS if name == "success" else FAILURE, value)


def _sentences(task: TaskClass, groups: Sequence[Sequence[str]]) -> str | None:
    """Write sentences; those for each variation say how many there are."""
    text = written_sentences(task, groups)
    changed = TaskClass.of(Source(text)) if text is not None else None
    if changed is None or len(groups) == 1 or read_count(changed) in (None, len(groups)):
        return text
    return written_count(changed, len(groups))


def _checked(name: Field, value: Any) -> Any:
    """Return a value as a field has it."""
    if name in ("title", "description"):
        return as_text(value, name).strip()
    if name == "variation_count":
        return as_whole(value, name, least=1)
    if name == "solved_by_chance":
        return as_flag(value, name)
    if name == "graspable":
        return tuple(as_names(value, name))
    if name == "instructions":
        groups = as_several(value, name)
        return tuple(tuple(as_text(sentence, "sentence") for sentence in as_several(group, name)) for group in groups)
    if name == "placements":
        return tuple(as_record(item, SpawnForm, f"entry {k} of {name}") for k, item in enumerate(as_several(value, name)))
    return tuple(_condition(item, k, name) for k, item in enumerate(as_several(value, name)))


def _condition(item: object, number: int, name: str) -> ConditionForm | Written:
    return item if isinstance(item, Written) else as_record(item, ConditionForm, f"entry {number} of {name}")
