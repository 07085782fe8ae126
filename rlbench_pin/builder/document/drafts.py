"""Drafts: unsaved edits in a hidden file next to the task, `.<task>.draft`; the builder offers them when it opens the task."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from rlbench_pin.builder.document.document import TaskDocument
from rlbench_pin.builder.document.storage import MAX_FILE_SIZE, Pair, alone_in, write_whole
from rlbench_pin.builder.document.texts import Texts

WAIT = 1.0
"""Time from the first edit until a draft is written with all edits since then [s]."""
MAX_DRAFTS = 3
"""Maximum number of drafts of one task: the current one, and earlier ones that were neither applied nor discarded."""
_FORMAT = 1
_MAX_SIZE = 8 * MAX_DRAFTS * MAX_FILE_SIZE


@dataclass(frozen=True)
class Draft:
    """The two texts of a task with unsaved edits.

    Attributes:
        texts: Texts of the scene file and of the Python file.
        saved: Digests of the files at that time; empty for a file that did not exist.
        written: Date and time as text.
    """

    texts: Texts
    saved: tuple[str, str]
    written: str


class DraftKeeper:
    """Keeps drafts of one task, in one thread. Drafts of another builder that has the task open stay in the file.

    Args:
        document: The task.
        on_written: Function that is called, in any thread, after a draft was written or could not be written.
        wait: Time from an edit until a draft is written [s].

    Attributes:
        file: The file of the drafts.
        offered: Earlier drafts that were neither applied nor discarded, the latest first.
        news: Message for the user about the file, such as that it could not be written; usually empty.
    """

    def __init__(self, document: TaskDocument, on_written: Callable[[], None], wait: float = WAIT) -> None:
        self._document, self._on_written, self._wait, self._first = document, on_written, wait, document.texts
        self.file = Pair(document.folder, document.name).draft
        self._lock = threading.Lock()
        self._timer: threading.Timer | None = None
        self.news = ""
        found = self._found()
        self.offered = [draft for draft in found if draft.texts != document.texts]
        self._wanted = self._written = tuple(found)
        self._closed = False
        self.keep()

    def is_of_now(self, draft: Draft) -> bool:
        """Whether the files have not changed since a draft was written."""
        return draft.saved == _digests(self._document.saved)

    def take(self) -> None:
        """Apply the latest draft that is offered, as one edit."""
        draft = self.offered.pop(0)
        self._document.take("take up the draft", draft.texts)
        self.keep()

    def drop(self) -> None:
        """Discard the latest draft that is offered."""
        self.offered.pop(0)
        self.keep()

    def keep(self) -> None:
        """Schedule a draft if the texts have changed since the last one; remove it if all edits are saved."""
        drafts = (*self._of_now(), *self.offered)[:MAX_DRAFTS]
        with self._lock:
            if _without_times(drafts) == _without_times(self._wanted) or self._closed:
                return
            self._wanted = drafts
            if drafts and self._timer is None:
                self._timer = threading.Timer(self._wait, self._write)
                self._timer.daemon = True
                self._timer.start()
        if not drafts:
            self._write()

    def close(self) -> None:
        """Write the last draft and stop."""
        self.keep()
        self._write()
        with self._lock:
            self._closed = True

    def _of_now(self) -> tuple[Draft, ...]:
        """Return a draft of the current texts; none when all edits are saved."""
        document = self._document
        is_new = document.saved == (None, None)
        if not document.unsaved or (is_new and document.texts == self._first):
            return ()
        return (Draft(document.texts, _digests(document.saved), time.strftime("%Y-%m-%d %H:%M:%S")),)

    def _write(self) -> None:
        """Write the wanted drafts; report in `news` if that fails."""
        with self._lock:
            if self._timer is not None:
                self._timer.cancel()
                self._timer = None
            if self._wanted == self._written or self._closed:
                return
            try:
                if self._wanted:
                    self.file.parent.mkdir(parents=True, exist_ok=True)
                if self.file.parent.is_dir():
                    with alone_in(self.file.parent):
                        self._replace()
            except OSError as error:
                self.news = (
                    f"No draft is kept: '{self.file}' cannot be written ({error.strerror}). What is not saved can be lost."
                )
            else:
                self._written = self._wanted
        self._on_written()

    def _replace(self) -> None:
        """Replace the drafts that this builder wrote; those of another builder stay."""
        self.news = ""
        others = [draft for draft in self._found() if draft not in self._written]
        if others:
            self.news = f"Another task builder has '{self._document.name}' open: its draft is kept beside this one."
        drafts = (*self._wanted[:1], *others, *self._wanted[1:])[:MAX_DRAFTS]
        if drafts:
            write_whole(self.file, _content(self._document.name, drafts))
        else:
            self.file.unlink(missing_ok=True)

    def _found(self) -> list[Draft]:
        """Return the drafts in the file; an invalid file is set aside."""
        try:
            if not self.file.is_symlink() and not self.file.exists():
                return []
            return _drafts(self._document.name, _read(self.file))
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            self._set_aside(str(error)[:120])
            return []

    def _set_aside(self, problem: str) -> None:
        aside = self.file.with_name(f"{self.file.name}.broken")
        try:
            self.file.replace(aside)
        except OSError as error:
            self.news = f"There is a draft that cannot be read ({problem}), nor be set aside ({error.strerror}): '{self.file}'."
        else:
            self.news = f"A draft that cannot be read ({problem}) was set aside as '{aside}'."


def _digests(contents: Sequence[bytes | None]) -> tuple[str, str]:
    scene, python = ("" if content is None else sha256(content).hexdigest() for content in contents)
    return scene, python


def _without_times(drafts: Sequence[Draft]) -> list[object]:
    return [(draft.texts, draft.saved) for draft in drafts]


def _content(name: str, drafts: Sequence[Draft]) -> bytes:
    said = [{"files": draft.texts, "saved": draft.saved, "written": draft.written} for draft in drafts]
    return json.dumps({"format": _FORMAT, "task": name, "drafts": said}).encode()


def _read(file: Path) -> bytes:
    if file.is_symlink() or not file.is_file():
        raise ValueError("it is not a file")
    with file.open("rb") as stream:
        content = stream.read(_MAX_SIZE + 1)
    if len(content) > _MAX_SIZE:
        raise ValueError("it is too large")
    return content


def _drafts(name: str, content: bytes) -> list[Draft]:
    """Return the drafts of a file, or raise any error that an invalid one causes."""
    said: Any = json.loads(content)
    if said["format"] != _FORMAT or said["task"] != name or not isinstance(said["drafts"], list):
        raise ValueError(f"it is not a draft of '{name}'")
    drafts = [Draft(_two(d["files"]), _two(d["saved"]), str(d["written"])[:40]) for d in said["drafts"][:MAX_DRAFTS]]
    for text in (text for draft in drafts for text in draft.texts):
        if len(text.encode()) > MAX_FILE_SIZE:
            raise ValueError("a text is too large")
    return drafts


def _two(words: Any) -> tuple[str, str]:
    first, second = words
    if not isinstance(first, str) or not isinstance(second, str) or not isinstance(words, list):
        raise TypeError("two texts are wanted")
    return first, second
