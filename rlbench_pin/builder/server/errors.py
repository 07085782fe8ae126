"""What the door of the builder refuses."""

from __future__ import annotations

from rlbench_pin.errors import RlbenchPinError


class ServerError(RlbenchPinError):
    """Base of the errors of the builder's server."""


class OutsideFolder(ServerError):
    """A path that the browser gave does not lie in the folder of the task."""

    def __init__(self, path: str, problem: str) -> None:
        self.path, self.problem = path, problem
        super().__init__(f"'{path}' {problem}. Give a path inside the folder of the task, such as 'meshes/handle.obj'.")


class UploadRefused(ServerError):
    """A file that was sent is not taken."""

    def __init__(self, name: str, problem: str, hint: str = "") -> None:
        self.name, self.problem = name, problem
        super().__init__(f"'{name}' is not taken: {problem}.{f' {hint}' if hint else ''}")
