"""A task that stays open, whatever happens to the process that has its world."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any

from rlbench_pin.builder.contracts import OpenedTask, Problem, TaskText
from rlbench_pin.builder.stage.faults import NothingOpen, StageClosed, StageFault
from rlbench_pin.builder.stage.folder import PrivateFolder
from rlbench_pin.builder.stage.limits import StageLimits
from rlbench_pin.builder.stage.link import Link, OnNote
from rlbench_pin.builder.stage.turns import Turns
from rlbench_pin.builder.stage.wire import record


class Session:
    """The text that is open, the process that has built it, and the episode that is laid out there.

    Args:
        folder: Takes the pair of files.
        limits: How long things may take.

    Attributes:
        link: The process.
        turns: The turns that threads take at it.
        run_task: Whether the module of the task may run.
        robot: Name of the arm.
        episode: Seed and variation of the episode that is laid out, None for what the scene says.
    """

    def __init__(self, folder: PrivateFolder, limits: StageLimits) -> None:
        self._folder, self._limits = folder, limits
        self.link, self.turns = Link("world", folder.path, limits), Turns(limits.wait)
        self.run_task, self.robot = False, ""
        self.episode: tuple[int, int] | None = None
        self._text: TaskText | None = None
        self._problem: Problem | None = None
        self._opened_in, self._ran_in, self._closed = 0, 0, False

    def open(self, text: TaskText, run_task: bool, robot: str) -> OpenedTask:
        """Open a task instead of the one that was open."""
        with self.turn("open"):
            self._text, self.run_task, self.robot = text, run_task, robot
            return self._open()

    def place(self, scene: str) -> OpenedTask:
        """Take over another text of the scene."""
        with self.turn("place"):
            if self._text is None:
                raise NothingOpen("place")
            before, self._text, self.episode = self._text, replace(self._text, scene=scene), None
            if self._problem is not None or not self._is_open:
                return self._open()
            self.link.python = self._folder.update(self.link.python, before, self._text)
            return self._built("place", {}, self._limits.place)[0]

    def ask(self, operation: str, question: dict[str, Any], limit: float, on_note: OnNote | None = None) -> Any:
        """Ask the process in a turn of its own, opened again when it is a new one; see `Link.ask`."""
        with self.turn(operation):
            self.usable(operation)
            if not self._is_open:
                self._open_again(operation)
            return self.link.ask(operation, question, limit, on_note)

    @contextmanager
    def turn(self, operation: str) -> Iterator[None]:
        """Have the process for a block; one that is gone after it is started anew at once, to be ready for the next."""
        with self.turns.take(operation):
            if self._closed:
                raise StageClosed(operation)
            try:
                yield
            finally:
                with suppress(StageFault):
                    self.link.warm()

    def usable(self, operation: str) -> TaskText:
        """Return the text that is open.

        Raises:
            NothingOpen: There is none, or it cannot be built.
            StageClosed: `close` was called.
        """
        if self._closed:
            raise StageClosed(operation)
        if self._text is None:
            raise NothingOpen(operation)
        if self._problem is not None:
            raise NothingOpen(operation, f"it cannot be built. {self._problem.message}")
        return self._text

    def close(self) -> None:
        """End the process for good."""
        self._closed = True
        self.link.close()

    def _open(self) -> OpenedTask:
        """Open the text; what fails in a process in which a module has run before is tried again in a new one."""
        has_run = self._ran_in == self.link.generation
        opened, is_late = self._opened()
        if opened.problems and has_run and not is_late:
            self.link.end()
            opened, _ = self._opened()
        if self.run_task:
            self._ran_in = self.link.generation
        return opened

    def _opened(self) -> tuple[OpenedTask, bool]:
        """Open the text once; return also whether it took too long."""
        assert self._text is not None
        self.episode, self.link.python = None, self._folder.write("world", self._text)
        question = {"python": str(self.link.python), "folder": str(self._text.folder)}
        return self._built("open", {**question, "run_task": self.run_task, "robot": self.robot}, self._limits.open)

    def _built(self, operation: str, question: dict[str, Any], limit: float) -> tuple[OpenedTask, bool]:
        """Let the world be built, and say whether it took too long; a process that dies of it is a problem of the task."""
        is_late = False
        try:
            opened = record(OpenedTask, self.link.ask(operation, question, limit))
        except StageFault as fault:
            problem = fault.problem or Problem("task" if self.run_task else "scene", None, str(fault))
            opened, is_late = OpenedTask(0, (), (), (), (problem,)), fault.kind == "timed out"
        self._problem = opened.problems[0] if opened.problems else None
        self._opened_in = self.link.generation
        return opened, is_late

    def _open_again(self, operation: str) -> None:
        """Bring a new process to where the last one was: the task open, and the episode laid out."""
        episode = self.episode
        if self._open().problems:
            self.usable(operation)
        if episode is not None:
            self.link.ask("reset", {"seed": episode[0], "variation": episode[1]}, self._limits.reset)
            self.episode = episode

    @property
    def _is_open(self) -> bool:
        return self.link.pid is not None and self.link.generation == self._opened_in
