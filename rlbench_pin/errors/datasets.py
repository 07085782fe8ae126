"""Stored demonstrations that cannot be read, written or put together."""

from __future__ import annotations

import errno
from pathlib import Path

from rlbench_pin.errors.base import RlbenchPinError


class DatasetError(RlbenchPinError, RuntimeError):
    """A stored demonstration is missing, truncated, of another version, or more were asked for than exist."""


class EpisodeFileError(DatasetError):
    """One file of a dataset is missing, truncated, altered or of another format; `path` says which."""

    def __init__(self, path: Path | str, message: str) -> None:
        self.path = Path(path)
        super().__init__(message)


class StorageError(DatasetError):
    """The disk cannot be written to (full, read-only, no permission); what was stored before is still whole."""

    def __init__(self, path: Path | str, cause: OSError) -> None:
        self.path, self.errno = Path(path), cause.errno
        advice = _STORAGE_ADVICE.get(cause.errno or 0, "See whether the folder can be written to.")
        reason = cause.strerror or str(cause)
        super().__init__(f"'{path}' cannot be written: {reason}. {advice} Everything stored before is whole.")


_STORAGE_ADVICE = {
    errno.ENOSPC: "Free some space and run it again; `rlbench-pin record` goes on with `--resume`.",
    errno.EDQUOT: "Free some of your quota and run it again; `rlbench-pin record` goes on with `--resume`.",
    errno.EROFS: "The disk is read-only: choose another folder.",
    errno.EACCES: "You may not write there: choose another folder or change its rights.",
    errno.EPERM: "You may not write there: choose another folder or change its rights.",
    errno.EISDIR: "There is a folder of that name: choose another name.",
    errno.ENAMETOOLONG: "Choose a shorter name.",
    errno.ENOTDIR: "A part of the path is a file: choose another folder.",
    errno.EEXIST: "There is a file where a folder should be: choose another folder.",
}


class UntrustedTaskFile(DatasetError):
    """The task of stored demonstrations is code that came with them; it is run only when the user says so.

    Attributes:
        task: Task name.
        path: The file.
    """

    def __init__(self, task: str, path: Path | str, remark: str = "") -> None:
        self.task, self.path, self.remark = task, Path(path), remark
        super().__init__(
            f"The task '{task}' is code that came with its episodes: '{path}'.{remark} It is not run unless you say so. Read it; "
            "then pass `--trust-task-files` (`trust_task_files=True` in Python), or name your own file of it."
        )

    def __reduce__(self) -> tuple[type[UntrustedTaskFile], tuple[str, Path, str]]:
        return type(self), (self.task, self.path, self.remark)


class DatasetConflict(DatasetError):
    """Two sets of demonstrations, or a recording and what is stored, do not go together."""
