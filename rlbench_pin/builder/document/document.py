"""A task that is being edited: its two files as text, each edit a step that can be undone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rlbench_pin.builder.contracts import Problem, TaskText
from rlbench_pin.builder.document import operations
from rlbench_pin.builder.document.behaviour import Behaviour
from rlbench_pin.builder.document.errors import TaskFilesError
from rlbench_pin.builder.document.history import History, Texts
from rlbench_pin.builder.document.new_task import texts_of_new_task
from rlbench_pin.builder.document.operations import Edited
from rlbench_pin.builder.document.reading import Reading, decoded, encoded_pair, typed
from rlbench_pin.builder.document.scene_text.scene_text import SceneText
from rlbench_pin.builder.document.storage import Contents, Pair, changed_files, read_pair, recover, write_pair
from rlbench_pin.scene import SceneSpec
from rlbench_pin.tasks.registry import name_fault
from rlbench_pin.values import as_path, as_text


class TaskDocument:
    """The two files of a task, edited as text. Made by `open` and `new`; not to be used by two threads at once.

    Args:
        pair: Where the files lie.
        texts: What they say.
        saved: What they say on disk; None for a file that is not there yet.
        unfinished: Texts of a save that did not come to an end, which become the first edit.
    """

    def __init__(self, pair: Pair, texts: Texts, saved: Contents, unfinished: Texts | None = None) -> None:
        self._pair, self._history, self._saved = pair, History(texts), saved
        self._reading = Reading(pair, texts)
        self._left: tuple[str, ...] = ()
        if unfinished is not None:
            self.take("unfinished save", unfinished)

    @classmethod
    def open(cls, path: Path | str) -> TaskDocument:
        """Open a task, and finish a save of it that was killed.

        Where a file was changed by somebody else after such a save, the files stay as they are, and what was being saved
        is the first edit, which can be undone.

        Args:
            path: Either file of the pair.

        Raises:
            TaskFilesError: A file is missing, too large, or no text.
            StorageError: A file cannot be read or written.
        """
        path = as_path(path, "path").resolve()
        if path.suffix not in (".toml", ".py"):
            raise TaskFilesError(path, "it is no file of a task.", "Name a `<task>.py` or `<task>.toml`.")
        pair = Pair(path.parent, path.stem)
        unfinished = recover(pair)
        saved = read_pair(pair)
        return cls(pair, decoded(pair, saved), saved, None if unfinished is None else decoded(pair, unfinished))

    @classmethod
    def new(cls, folder: Path | str, name: str) -> TaskDocument:
        """Begin an empty task; nothing is written before `save`.

        Args:
            folder: Where its files will lie.
            name: Small letters, digits and underscores, a letter first.

        Raises:
            TaskFilesError: The name is none, or a file of that name is there, perhaps from a save that was killed.
        """
        pair = Pair(as_path(folder, "folder").resolve(), as_text(name, "name"))
        if fault := name_fault(name):
            raise TaskFilesError(name, fault)
        recover(pair)
        for file in pair.files:
            if file.is_symlink() or file.exists():
                raise TaskFilesError(file, "it is there already.", "Open it, or choose another name.")
        return cls(pair, texts_of_new_task(name), (None, None))

    # What it is -------------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the task."""
        return self._pair.name

    @property
    def folder(self) -> Path:
        """Where the files lie."""
        return self._pair.folder

    @property
    def texts(self) -> Texts:
        """What `<task>.toml` and `<task>.py` say."""
        return self._history.texts

    @property
    def scene_text(self) -> str:
        """What `<task>.toml` says."""
        return self._history.texts[0]

    @property
    def python_text(self) -> str:
        """What `<task>.py` says."""
        return self._history.texts[1]

    @property
    def text(self) -> TaskText:
        """Both texts, with name and folder."""
        return TaskText(self.name, self.folder, self.scene_text, self.python_text)

    @property
    def spec(self) -> SceneSpec | None:
        """The scene, as the last valid text says it; None when there was none."""
        return self._reading.spec

    @property
    def problems(self) -> tuple[Problem, ...]:
        """What is wrong with the two texts."""
        return self._reading.problems

    @property
    def behaviour(self) -> Behaviour:
        """What forms can edit of the Python."""
        return self._reading.behaviour

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
        """Name of the edit that `redo` makes again; empty when there is none."""
        return self._history.redoable

    @property
    def left(self) -> tuple[str, ...]:
        """Lines of Python that the last edit could not rename."""
        return self._left

    @property
    def saved(self) -> Contents:
        """What both files were when they were read or saved last; None for one that is not there."""
        return self._saved

    @property
    def unsaved(self) -> bool:
        """Whether the texts differ from what was read or saved last."""
        return encoded_pair(self._history.texts, self._saved) != self._saved

    # Edits --------------------------------------------------------------------------------------------------------------

    def add(self, table: str, values: Mapping[str, Any]) -> str:
        """Add a thing, and return its name; without `name` in `values` it is given a free one.

        Args:
            table: `body`, `joint`, `frame`, `region`, `sensor` or `waypoint` (behind the last).
            values: Keys of the record.
        """
        return self._edit(f"add {table}", lambda scene, python: operations.added(scene, python, table, values)).name

    def set(self, name: str, key: str, value: Any, merge: str = "") -> None:
        """Change one key of a thing; None is its default. A pose is given in the frame of the parent.

        Args:
            name: The thing, `<body>/<joint>` for a joint.
            key: Key of its record.
            value: What it is to be; numbers are rounded.
            merge: Edits of the same key that follow one another are one step, as while something is dragged.
        """
        self.set_several(name, {key: value}, merge)

    def set_several(self, name: str, values: Mapping[str, Any], merge: str = "") -> None:
        """Change several keys of a thing in one step, such as `path` and `arc`, which go together."""
        words = f"{', '.join(values)} of {name}"
        self._edit(f"change {words}", lambda scene, python: operations.changed(scene, python, name, values), merge)

    def set_placement(self, key: str, value: Any, merge: str = "") -> None:
        """Change one key of `[placement]`; None is its default. A pose is given in the world, as in `spec`."""
        edit = operations.placement_changed
        self._edit(f"change {key}", lambda scene, python: edit(scene, python, {key: value}), merge)

    def duplicate(self, name: str) -> str:
        """Add a thing like another, with the joints of a body, at the same place; return its name."""
        return self._edit(f"duplicate {name}", lambda scene, python: operations.duplicated(scene, python, name)).name

    def delete(self, name: str, with_dependants: bool = False) -> None:
        """Take a thing away; waypoints behind one that goes are renumbered.

        Raises:
            HasDependants: Something hangs on it, or the Python names it.
        """
        edit = operations.deleted
        self._edit(f"delete {name}", lambda scene, python: edit(scene, python, name, with_dependants=with_dependants))

    def insert_waypoint(self, index: int, values: Mapping[str, Any]) -> str:
        """Add a waypoint before the one of that number; those behind are renumbered wherever they are named."""
        edit = operations.waypoint_inserted
        return self._edit("insert waypoint", lambda scene, python: edit(scene, python, index, values)).name

    def move_waypoint(self, name: str, index: int) -> str:
        """Visit a waypoint as the one of that number, and return its name then; all are renumbered wherever they are named."""
        return self._edit(f"reorder {name}", lambda scene, python: operations.waypoint_moved(scene, python, name, index)).name

    def attach(self, name: str, parent: str, pose: Any, merge: str = "") -> None:
        """Hang a thing on another, at a pose in its frame that is written without rounding what counts."""
        self._edit(f"parent of {name}", lambda scene, python: operations.attached(scene, python, name, parent, pose), merge)

    def rename(self, old: str, new: str) -> tuple[str, ...]:
        """Call a thing otherwise wherever it is named; return the lines of Python that name it in a way that was left."""
        return self._edit(f"rename {old}", lambda scene, python: operations.renamed(scene, python, old, new)).left

    def set_scene_text(self, text: str, merge: str = "") -> None:
        """Put another text in the place of the scene, also one that is not valid."""
        self.take("edit the scene as text", (typed(text, "scene text", self._saved[0]), self.python_text), merge)

    def set_python_text(self, text: str, merge: str = "") -> None:
        """Put another text in the place of the Python, also one that is not valid."""
        self.take("edit the Python as text", (self.scene_text, typed(text, "Python text", self._saved[1])), merge)

    def set_behaviour(self, field: str, value: Any, merge: str = "") -> None:
        """Change what a form shows of the Python, such as `instructions`; hand-written parts stay as they are.

        Raises:
            EditRefused: The Python is not of a form that can be edited so.
        """
        text = self.behaviour.written(field, value)
        self.take(f"change {field.replace('_', ' ')}", (self.scene_text, text), merge)

    def undo(self) -> str:
        """Take the last edit back, and return its name; empty when there is none."""
        return self._went(self._history.undo())

    def redo(self) -> str:
        """Make the edit again that was taken back last, and return its name; empty when there is none."""
        return self._went(self._history.redo())

    # Files --------------------------------------------------------------------------------------------------------------

    def save(self, over: bool = False) -> None:
        """Write both files; they appear together or not at all.

        Args:
            over: Also when somebody else has changed them since they were read.

        Raises:
            ChangedOnDisk: Somebody has.
            StorageError: They cannot be written.
        """
        contents = encoded_pair(self._history.texts, self._saved)
        write_pair(self._pair, contents, known=None if over else self._saved)
        self._saved = contents

    def changed_on_disk(self) -> tuple[Path, ...]:
        """Return the files that somebody else has changed since they were read or saved; empty when there are none."""
        return changed_files(self._pair, self._saved)

    def reload(self) -> None:
        """Take over what the files say now, as an edit that can be undone.

        Raises:
            TaskFilesError: A file is missing, too large, or no text.
        """
        contents = read_pair(self._pair)
        self.take("reload", decoded(self._pair, contents))
        self._saved = contents

    def _edit(self, name: str, edit: Callable[[SceneText, str], Edited], merge: str = "") -> Edited:
        """Make an edit by form, which may not break a valid scene."""
        edited = edit(self._reading.scene, self.python_text)
        reading = Reading(self._pair, edited.texts, self._reading)
        if reading.error is not None and self._reading.error is None:
            raise reading.error
        self._history.add(name, edited.texts, merge)
        self._reading, self._left = reading, edited.left
        return edited

    def take(self, name: str, texts: Texts, merge: str = "") -> None:
        """Put other texts in the place of both, as one edit of that name."""
        self._history.add(name, texts, merge)
        self._went(name)

    def _went(self, name: str) -> str:
        self._reading, self._left = Reading(self._pair, self._history.texts, self._reading), ()
        return name
