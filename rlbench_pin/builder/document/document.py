"""The edited task: its two files as text; each edit is a step of the undo history."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from string import Template
from typing import Any

from rlbench_pin.builder.contracts import TaskText
from rlbench_pin.builder.document import operations
from rlbench_pin.builder.document.behaviour import Behaviour, takes_sentences_of_scene
from rlbench_pin.builder.document.errors import EditRefused, TaskFilesError
from rlbench_pin.builder.document.operations import Edited
from rlbench_pin.builder.document.problems import python_problems, scene_problem
from rlbench_pin.builder.document.scene_text import SceneText
from rlbench_pin.builder.document.storage import (
    Contents,
    Pair,
    changed_files,
    decode_pair,
    encode_pair,
    read_pair,
    recover,
    typed_text,
    write_pair,
)
from rlbench_pin.builder.document.texts import History, Texts
from rlbench_pin.errors import RlbenchPinError, SceneFileError
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.reader import scene_from_raw
from rlbench_pin.tasks import camel_case
from rlbench_pin.tasks.registry import name_fault
from rlbench_pin.values import as_path, as_text
from rlbench_pin.viewer.recording import Problem

_NEW_SCENE = """\
format = 2                                  # lengths [m], angles [rad], heights from the table top

[placement]
footprint = [0.3, 0.3]                      # x and y size of the area on the table that the task needs
"""
_NEW_PYTHON = Template('''\
"""$title."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Task


class $cls(Task):
    """$title."""

    def init_task(self) -> None:
        """Look up the elements of the scene, and define success."""
        self.register_success_conditions([])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Set up the episode, and return the instructions."""
        return ["$title."]
''')


class _Reading:
    """The content of a pair of texts; parts that are as in the texts `before` are not read again.

    Attributes:
        error: Why the scene is invalid, None when it is valid.
        spec: The scene of the last valid text, None when there was none.
        parsed: The scene with the places of its parts, None when it is not valid TOML.
    """

    def __init__(self, pair: Pair, texts: Texts, before: _Reading | None = None) -> None:
        self.texts, self._name = texts, pair.name
        self.error: RlbenchPinError | None = None
        self.spec: SceneSpec | None = None if before is None else before.spec
        self.parsed: SceneText | None = None
        if before is not None and before.texts[0] == texts[0]:
            self.error, self.parsed = before.error, before.parsed
            return
        try:
            self.parsed = SceneText(texts[0], pair.files[0])
            self.spec = scene_from_raw(self.parsed.raw, pair.files[0])
        except RlbenchPinError as error:
            self.error = error

    @property
    def scene(self) -> SceneText:
        """The scene with the places of its parts, or raise EditRefused when it is not valid TOML."""
        if self.parsed is None:
            problem = self.error.problem if isinstance(self.error, SceneFileError) else str(self.error)
            raise EditRefused("edit the scene", problem, "Correct the text first.")
        return self.parsed

    @cached_property
    def problems(self) -> tuple[Problem, ...]:
        scene = () if self.error is None else (scene_problem(self.texts[0], self.error),)
        return (*scene, *python_problems(self.texts[1], self._name, self.spec if self.error is None else None))

    @cached_property
    def behaviour(self) -> Behaviour:
        (found, _), training = _read_python(self.texts[1]), self.training
        return found if training is None else replace(found, instructions=(training,))

    @cached_property
    def training(self) -> tuple[str, ...] | None:
        """The training sentences of the scene, where the Python returns them; None where it has its own."""
        table = self.parsed.raw.get("instructions") if self.parsed is not None else None
        sentences = table.get("training") if isinstance(table, dict) else None
        if not isinstance(sentences, list) or not all(isinstance(sentence, str) for sentence in sentences):
            return None
        return tuple(sentences) if _read_python(self.texts[1])[1] else None


@lru_cache(maxsize=4)
def _read_python(text: str) -> tuple[Behaviour, bool]:
    """Return the behaviour in a Python file, and whether it returns the sentences of the scene.

    While an element is dragged, the scene changes many times and the Python does not.
    """
    return Behaviour.of(text), takes_sentences_of_scene(text)


class TaskDocument:
    """The two files of a task, edited as text. Create it with `open` or `new`; use it in one thread at a time.

    Args:
        pair: The paths of the files.
        texts: Their texts.
        saved: Their contents on disk; None for a file that does not exist yet.
        unfinished: Texts of an interrupted save, which become the first edit.
    """

    def __init__(self, pair: Pair, texts: Texts, saved: Contents, unfinished: Texts | None = None) -> None:
        self._pair, self._history, self._saved = pair, History(texts), saved
        self._reading = _Reading(pair, texts)
        self._left: tuple[str, ...] = ()
        self._own_python = {texts[1]} if saved == (None, None) else set[str]()
        if unfinished is not None:
            self.take("unfinished save", unfinished)

    @classmethod
    def open(cls, path: Path | str) -> TaskDocument:
        """Open a task, and finish a save of it that was killed.

        If another program has changed a file after that save, the files do not change. Then the texts of the save
        become the first edit, which can be undone.

        Args:
            path: Either file of the pair.

        Raises:
            TaskFilesError: A file is missing, too large, or not text.
            StorageError: A file cannot be read or written.
        """
        path = as_path(path, "path").resolve()
        if path.suffix not in (".toml", ".py"):
            raise TaskFilesError(path, "it is not a file of a task.", "Name a `<task>.py` or `<task>.toml`.")
        pair = Pair(path.parent, path.stem)
        unfinished = recover(pair)
        saved = read_pair(pair)
        return cls(pair, decode_pair(pair, saved), saved, None if unfinished is None else decode_pair(pair, unfinished))

    @classmethod
    def new(cls, folder: Path | str, name: str) -> TaskDocument:
        """Begin an empty task; nothing is written before `save`.

        Args:
            folder: Folder of its files.
            name: Small letters, digits and underscores, a letter first.

        Raises:
            TaskFilesError: The name is invalid, or a file of that name exists, also one of an interrupted save.
        """
        pair = Pair(as_path(folder, "folder").resolve(), as_text(name, "name"))
        if fault := name_fault(name):
            raise TaskFilesError(name, fault)
        recover(pair)
        for file in pair.files:
            if file.is_symlink() or file.exists():
                raise TaskFilesError(file, "it already exists.", "Open it, or choose another name.")
        title = name.replace("_", " ").capitalize()
        return cls(pair, (_NEW_SCENE, _NEW_PYTHON.substitute(cls=camel_case(name), title=title)), (None, None))

    # Properties ---------------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the task."""
        return self._pair.name

    @property
    def folder(self) -> Path:
        """Folder of the files."""
        return self._pair.folder

    @property
    def texts(self) -> Texts:
        """Texts of `<task>.toml` and `<task>.py`."""
        return self._history.texts

    @property
    def scene_text(self) -> str:
        """Text of `<task>.toml`."""
        return self._history.texts[0]

    @property
    def python_text(self) -> str:
        """Text of `<task>.py`."""
        return self._history.texts[1]

    @property
    def text(self) -> TaskText:
        """Both texts, with name and folder."""
        return TaskText(self.name, self.folder, *self.texts)

    @property
    def spec(self) -> SceneSpec | None:
        """The scene of the last valid text; None when there was none."""
        return self._reading.spec

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Problems of the two texts, those of the scene first."""
        return self._reading.problems

    @property
    def behaviour(self) -> Behaviour:
        """The parts of the Python that forms can edit."""
        return self._reading.behaviour

    @property
    def wrote_python(self) -> bool:
        """Whether this document wrote all of the Python itself: that of a new task, changed by forms alone."""
        return self.python_text in self._own_python

    @property
    def step(self) -> int:
        """A number that grows with every edit, undo and redo."""
        return self._history.count

    @property
    def undoable(self) -> str:
        """Name of the edit that `undo` takes back; empty when there is none."""
        return self._history.undoable

    @property
    def redoable(self) -> str:
        """Name of the edit that `redo` repeats; empty when there is none."""
        return self._history.redoable

    @property
    def left(self) -> tuple[str, ...]:
        """Lines of Python that the last renaming did not change."""
        return self._left

    @property
    def saved(self) -> Contents:
        """Contents of both files when they were read or saved last; None for one that did not exist."""
        return self._saved

    @property
    def unsaved(self) -> bool:
        """Whether the texts differ from what was read or saved last."""
        return encode_pair(self.texts, self._saved) != self._saved

    # Edits --------------------------------------------------------------------------------------------------------------

    def add(self, table: str, values: Mapping[str, Any]) -> str:
        """Add an element, and return its name; without `name` in `values` it gets a free one.

        Args:
            table: `body`, `joint`, `frame`, `region`, `sensor` or `waypoint` (added as the last).
            values: Keys of the record.
        """
        return self._edit(f"add {table}", operations.added, table, values).name

    def set(self, name: str, key: str, value: Any, merge: str = "") -> None:
        """Change one key of an element. A pose is given in the frame of the parent.

        Args:
            name: The element, `<body>/<joint>` for a joint.
            key: Key of its record.
            value: The new value, None for the default; numbers are rounded.
            merge: Consecutive edits with the same `merge` are one step, for example while something is dragged.
        """
        self.set_several(name, {key: value}, merge)

    def set_several(self, name: str, values: Mapping[str, Any], merge: str = "") -> None:
        """Change several keys of an element in one step, such as `path` and `arc`, which go together."""
        self._edit(f"change {', '.join(values)} of {name}", operations.changed, name, values, merge=merge)

    def set_placement(self, key: str, value: Any) -> None:
        """Change one key of `[placement]`; None is its default. A pose is given in the world, as in `spec`."""
        self._edit(f"change {key}", operations.placement_changed, key, value)

    def duplicate(self, name: str) -> str:
        """Add a copy of an element at the same place, with the joints of a body; return its name."""
        return self._edit(f"duplicate {name}", operations.duplicated, name).name

    def delete(self, name: str, with_dependants: bool = False) -> None:
        """Delete an element; later waypoints are renumbered.

        Raises:
            HasDependants: Another element is attached to it, or the Python names it.
        """
        self._edit(f"delete {name}", operations.deleted, name, with_dependants)

    def insert_waypoint(self, index: int, values: Mapping[str, Any]) -> str:
        """Add a waypoint before the one of that number; later ones are renumbered wherever they are named."""
        return self._edit("insert waypoint", operations.waypoint_inserted, index, values).name

    def move_waypoint(self, name: str, index: int) -> str:
        """Give a waypoint another number, and return its new name; all are renumbered wherever they are named."""
        return self._edit(f"reorder {name}", operations.waypoint_moved, name, index).name

    def attach(self, name: str, parent: str, pose: Any, merge: str = "") -> None:
        """Give an element another parent, and a pose in its frame that is exact to 1e-9."""
        self._edit(f"parent of {name}", operations.attached, name, parent, pose, merge=merge)

    def rename(self, old: str, new: str) -> tuple[str, ...]:
        """Rename an element in both files; return the lines of Python that name it in a way that cannot be renamed."""
        return self._edit(f"rename {old}", operations.renamed_everywhere, old, new).left

    def set_scene_text(self, text: str) -> None:
        """Replace the text of the scene, also by one that is not valid."""
        self.take("edit the scene as text", (typed_text(text, "scene text", self._saved[0]), self.python_text))

    def set_python_text(self, text: str) -> None:
        """Replace the text of the Python, also by one that is not valid."""
        self.take("edit the Python as text", (self.scene_text, typed_text(text, "Python text", self._saved[1])))

    def set_behaviour(self, field: str, value: Any) -> None:
        """Change one field of the behaviour, such as `instructions`; hand-written parts of the Python do not change.

        Raises:
            EditRefused: No form can edit this part of the Python.
        """
        if field == "instructions" and self._reading.training is not None:
            self._edit("change instructions", operations.sentences_changed, value)
            return
        is_own, text = self.wrote_python, self.behaviour.written(field, value)
        self.take(f"change {field.replace('_', ' ')}", (self.scene_text, text))
        if is_own:
            self._own_python.add(text)

    def take(self, name: str, texts: Texts) -> None:
        """Replace both texts, as one edit of that name."""
        self._history.add(name, texts)
        self._read()

    def undo(self) -> str:
        """Undo the last edit, and return its name; empty if there is none."""
        name = self._history.undo()
        self._read()
        return name

    def redo(self) -> str:
        """Redo the edit that was undone last, and return its name; empty if there is none."""
        name = self._history.redo()
        self._read()
        return name

    def _edit(self, label: str, operation: Callable[..., Edited], *arguments: Any, merge: str = "") -> Edited:
        """Make an edit by form, which must not break a valid scene."""
        edited = operation(self._reading.scene, self.python_text, *arguments)
        reading = _Reading(self._pair, edited.texts, self._reading)
        if reading.error is not None and self._reading.error is None:
            raise reading.error
        if self.wrote_python:
            self._own_python.add(edited.texts[1])
        self._history.add(label, edited.texts, merge)
        self._reading, self._left = reading, edited.left
        return edited

    def _read(self) -> None:
        self._reading, self._left = _Reading(self._pair, self.texts, self._reading), ()

    # Files --------------------------------------------------------------------------------------------------------------

    def save(self, over: bool = False) -> None:
        """Write both files; they appear together or not at all.

        Args:
            over: Overwrite changes that another program has made since the files were read.

        Raises:
            ChangedOnDisk: Another program has changed the files.
            StorageError: They cannot be written.
        """
        contents = encode_pair(self.texts, self._saved)
        write_pair(self._pair, contents, known=None if over else self._saved)
        self._saved = contents

    def changed_on_disk(self) -> tuple[Path, ...]:
        """Return the files that another program has changed since they were read or saved; empty if there are none."""
        return changed_files(self._pair, self._saved)

    def reload(self) -> None:
        """Replace both texts by those of the files, as an edit that can be undone.

        Raises:
            TaskFilesError: A file is missing, too large, or not text.
        """
        contents = read_pair(self._pair)
        self.take("reload", decode_pair(self._pair, contents))
        self._saved = contents
