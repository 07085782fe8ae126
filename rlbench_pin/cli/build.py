"""`rlbench-pin build [NAME]`: the task builder, in a browser on this machine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from rlbench_pin.cli.options import MaybePath, check_folder
from rlbench_pin.cli.pages import announce, check_port, wait_for_end
from rlbench_pin.errors import MissingExtra, TaskEnvironmentError

if TYPE_CHECKING:
    from rlbench_pin.builder.document import TaskDocument

MaybeName = Annotated[str, tyro.conf.arg(metavar="[NAME]", help_behavior_hint="")]
"""A task that may be left out."""
UNNAMED = "my_task"
"""Name of a new task when none is given."""
_ENDS = (".toml", ".py")


@dataclass(frozen=True)
class Build:
    """Make or change a task in the browser: scene, behaviour, demonstration and validation. Writes NAME.toml and NAME.py."""

    name: tyro.conf.Positional[MaybeName] = ""
    """Name of a task in `--out` or in the library to edit, or the name of a new task in snake case. Default: a new task."""
    task_file: MaybePath = None
    """Instead of a name: one of the two files of a task."""
    out: Path = Path()
    """Folder of the task; a task of the library stays in its own folder. Nothing is written outside the folder."""
    port: int = 0
    """Port of the page on 127.0.0.1; 0 takes a free port."""
    browser: bool = True
    """Open the page in a browser if there is a screen. The address is always printed."""
    trust: bool = False
    """Run the Python code of the task from the start. Otherwise the page asks first, unless the builder wrote the code."""

    def run(self) -> int:
        """Serve until Ctrl-C."""
        try:
            from rlbench_pin.builder.server import LocalServer
            from rlbench_pin.builder.view import Window
            from rlbench_pin.builder.worker import WorkerClient
        except ModuleNotFoundError as error:
            raise MissingExtra("The task builder", error.name or "viser", "builder") from error

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
                    kept = "there is no draft of them" if draft is None else f"the next start offers them from the draft {draft}"
                    print(f"Changes of '{document.name}' since the last save are not saved; {kept}.")
        return 0

    def _document(self) -> TaskDocument:
        """Return the task to edit."""
        from rlbench_pin.builder.document import TaskDocument
        from rlbench_pin.tasks import library_names
        from rlbench_pin.tasks.registry import LIBRARY

        if self.task_file is not None:
            if self.name:
                raise TaskEnvironmentError(
                    f"The name '{self.name}' and --task-file '{self.task_file}' both name a task. Leave one of them out."
                )
            if self.task_file.suffix not in _ENDS or not self.task_file.is_file():
                raise TaskEnvironmentError(
                    f"There is no task file '{self.task_file}'. Check the path, or make a new task with `rlbench-pin build NAME "
                    "--out FOLDER`."
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
