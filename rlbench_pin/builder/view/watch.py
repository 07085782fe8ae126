"""Keeps the stage in step with what is being edited, and brings back what it sees."""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np

from rlbench_pin.builder.contracts import OpenedTask, TaskText, WaypointVerdict
from rlbench_pin.builder.view.contracts import Stage
from rlbench_pin.builder.view.session import Session, Sight
from rlbench_pin.builder.view.worker import Worker
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot import DEFAULT_ROBOT, robot_description
from rlbench_pin.spatial import FloatArray

_LOG = logging.getLogger(__name__)


class Watch:
    """Asks the stage, one question after the other, in a thread of its own; answers go to the thread of edits.

    Args:
        session: What is being edited.
        stage: The world.
        on_arm: Called with the joint positions (n,) of an arm that follows a dragged hand.

    Attributes:
        run_task: Whether the task's own module may run: what somebody has allowed.
    """

    def __init__(self, session: Session, stage: Stage, on_arm: Callable[[FloatArray], None]) -> None:
        self.session, self.stage, self._on_arm = session, stage, on_arm
        self.run_task = False
        self._asked: tuple[TaskText, bool] | None = None
        self._built: tuple[str, bool] | None = None
        self._followed = np.array(robot_description(DEFAULT_ROBOT).home)
        self._worker = Worker("stage", self._failed)
        session.listen(self.refresh)

    # What follows edits ----------------------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Have the stage look at the texts when they have changed; to be called in the thread of edits."""
        asked = (self.session.document.text, self.run_task)
        if asked == self._asked or any(p.file == "scene" for p in self.session.document.problems):
            return
        self._asked = asked
        self.session.sight.paths = ()
        self.work("looking at the scene", lambda: self._look(*asked), kind="look")

    def allow(self) -> None:
        """Let the task's own module run from now on; to be called in the thread of edits."""
        self.run_task = True
        self.session.changed()

    def again(self) -> None:
        """Have the stage build the task anew; to be called in the thread of edits."""
        self._asked, self._built = None, None
        self.session.changed()

    def _look(self, text: TaskText, run_task: bool) -> None:
        opened = self._open(text, run_task)
        verdicts: tuple[WaypointVerdict, ...] = ()
        if not opened.problems and opened.waypoints:
            verdicts = tuple(self.stage.reach())
        self.session.post(lambda: self._seen(opened, verdicts), "seen")

    def _open(self, text: TaskText, run_task: bool) -> OpenedTask:
        if self._built == (text.python, run_task):
            return self.stage.place(text.scene)
        self._built = None
        opened = self.stage.open(text, run_task=run_task)
        self._built = None if opened.problems else (text.python, run_task)
        return opened

    def _seen(self, opened: OpenedTask, verdicts: tuple[WaypointVerdict, ...]) -> None:
        sight = self.session.sight
        self.session.sight = Sight(opened, {v.waypoint: v for v in verdicts}, sight.paths, sight.work)
        self.session.changed()

    # Other questions -------------------------------------------------------------------------------------------------

    def work(self, name: str, job: Callable[[], None], kind: str = "") -> None:
        """Have the stage do something; what it is doing is shown meanwhile.

        Args:
            name: What it is, in words.
            job: Asks the stage.
            kind: A job of the same kind that still waits is dropped.
        """

        def done() -> None:
            self._say(name, "")
            try:
                job()
                self._say("", "")
            except RlbenchPinError as error:
                self._say("", str(error))
                self._built = None

        self._worker.post(done, kind)

    def follow(self, pose: FloatArray, begin: bool) -> None:
        """Have the arm follow a dragged hand to a pose (7,); from the waypoint's configuration at its begin."""
        verdict = self.session.sight.verdicts.get(self.session.selected)

        def ask() -> None:
            start = self._followed
            if begin and verdict is not None and verdict.configuration is not None:
                start = verdict.configuration
            try:
                self._followed, _ = self.stage.follow(pose, start)
            except RlbenchPinError as error:
                self._say("", str(error))
                return
            self._on_arm(self._followed)

        self._worker.post(ask, "" if begin else "follow")

    def plan(self) -> None:
        """Have the way to each waypoint planned."""

        def ask() -> None:
            paths = tuple(self.stage.paths())

            def show() -> None:
                self.session.sight.paths = paths
                self.session.changed()

            self.session.post(show)

        self.work("planning paths", ask, "paths")

    def wait(self, timeout: float) -> bool:
        """Wait until all questions are answered [s]; False when some are not."""
        return self._worker.wait(timeout)

    def _say(self, work: str, fault: str) -> None:
        def say() -> None:
            sight = self.session.sight
            sight.work, sight.fault = work, fault
            self.session.changed()

        self.session.post(say)

    def _failed(self, error: Exception) -> None:
        _LOG.error("in the thread of the stage", exc_info=error)
        self._say("", f"{type(error).__name__}: {error}")

    def stop(self) -> None:
        """End the thread of questions."""
        self.stage.cancel()
        self._worker.stop()


__all__ = ["Watch"]
