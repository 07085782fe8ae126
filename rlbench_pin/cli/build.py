"""`rlbench-pin build [NAME]`: the task builder, served to a browser of this machine."""

from __future__ import annotations

from pathlib import Path

from rlbench_pin.cli.arguments import build as arguments
from rlbench_pin.cli.process.files import check_folder
from rlbench_pin.cli.process.pages import announce, check_port, wait_for_end
from rlbench_pin.errors import MissingExtra, TaskEnvironmentError
from rlbench_pin.tasks import library_names
from rlbench_pin.tasks.registry import LIBRARY

try:
    from rlbench_pin.builder.document import TaskDocument
    from rlbench_pin.builder.server import LocalServer
    from rlbench_pin.builder.view import Window
    from rlbench_pin.builder.worker import WorkerClient
except ModuleNotFoundError as _error:
    raise MissingExtra("The task builder", _error.name or "viser", "builder") from _error

UNNAMED = "my_task"
"""What a new task is called that nobody has named."""
_ENDS = (".toml", ".py")


class Build(arguments.Build):
    """The work of `rlbench-pin build`."""

    def run(self) -> int:
        """Serve until Ctrl-C."""
        check_port(self)
        document = self._document()
        with LocalServer(self.port, title=f"{document.name} - task builder") as server, WorkerClient() as worker:
            window = Window(server.viser, document, worker)
            if self.trust:
                window.session.post(window.world.allow_code)
            try:
                print(f"'{document.name}' in {document.folder}")
                announce(server.address, self.browser)
                wait_for_end()
            finally:
                window.close()
                if document.unsaved and document.step:
                    draft = window.drafts.file
                    kept = "no draft of it is kept" if draft is None else f"the next opening offers it, from {draft}"
                    print(f"Not saved: what was changed in '{document.name}' since it was last saved; {kept}.")
        return 0

    def _document(self) -> TaskDocument:
        """Return the task that is to be edited."""
        if self.task_file is not None:
            if self.name:
                raise TaskEnvironmentError("Give a name or --task-file, not both.")
            if self.task_file.suffix not in _ENDS or not self.task_file.is_file():
                raise TaskEnvironmentError(
                    f"There is no task file '{self.task_file}'. `rlbench-pin build NAME --out FOLDER` makes a new pair of files."
                )
            return TaskDocument.open(self.task_file)
        check_folder(self.out)
        name = self.name or _free_name(self.out)
        for folder in (self.out, *([LIBRARY] * (name in library_names()))):
            if any(_file(folder, name, end).exists() for end in _ENDS):
                return TaskDocument.open(_file(folder, name, ".py"))
        return TaskDocument.new(self.out, name)


def _file(folder: Path, name: str, end: str) -> Path:
    return folder / f"{name}{end}"


def _free_name(folder: Path) -> str:
    """Return a name that no file of the folder has."""
    taken = {path.stem for path in folder.glob(f"{UNNAMED}*")} if folder.is_dir() else set()
    numbers = (f"{UNNAMED}_{k}" for k in range(2, len(taken) + 3))
    return next(name for name in (UNNAMED, *numbers) if name not in taken)
