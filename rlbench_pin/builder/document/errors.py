"""Errors of the edited task."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from rlbench_pin.errors import RlbenchPinError


class DocumentError(RlbenchPinError):
    """Base of the errors of the edited task; the task has not changed."""


class TaskFilesError(DocumentError):
    """The files of a task cannot be opened."""

    def __init__(self, path: Path | str, problem: str, hint: str = "") -> None:
        self.path, self.problem, self.hint = Path(path), problem, hint
        super().__init__(f"'{path}': {problem}{f' {hint}' if hint else ''}")


class EditRefused(DocumentError):
    """An edit is refused."""

    def __init__(self, edit: str, problem: str, hint: str = "") -> None:
        self.edit, self.problem, self.hint = edit, problem, hint
        super().__init__(f"Cannot {edit}: {problem}{f' {hint}' if hint else ''}")


class HasDependants(EditRefused):
    """An element is not deleted, because others depend on it."""

    def __init__(self, name: str, dependants: Sequence[str], mentions: Sequence[str]) -> None:
        self.name, self.dependants, self.mentions = name, tuple(dependants), tuple(mentions)
        needed = [*dependants, *(f"line {mention}" for mention in mentions)]
        hint = "Delete it with its dependants (also conditions, grasps and random places that name it), or change these first."
        super().__init__(f"delete '{name}'", f"it is needed by {', '.join(needed)}.", hint)


class ChangedOnDisk(DocumentError):
    """Another program has changed files since they were read or saved."""

    def __init__(self, files: Collection[Path]) -> None:
        self.files = tuple(files)
        names = " and ".join(sorted(file.name for file in files))
        super().__init__(f"{names} changed on disk since it was read. Reload, or save over it.")
