"""Requests to the worker process that simulates the edited task."""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np

from rlbench_pin.builder.contracts import OpenedTask, TaskText, WaypointVerdict
from rlbench_pin.builder.view.session import Session, WorldStatus
from rlbench_pin.builder.worker import WorkerClient
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot import DEFAULT_ROBOT, robot_description
from rlbench_pin.spatial import FloatArray
from rlbench_pin.viewer.job_thread import JobThread

_LOG = logging.getLogger(__name__)


class WorldSync:
    """Sends requests to the worker process, in order, from a thread of its own; results go to the thread of edits.

    Args:
        session: The edited task.
        worker: The worker process.
        on_arm: Called with the joint positions (n,) of an arm that follows a dragged waypoint.
    """

    def __init__(self, session: Session, worker: WorkerClient, on_arm: Callable[[FloatArray], None]) -> None:
        self.session, self.worker, self._on_arm = session, worker, on_arm
        self._allowed = False
        self._requested: tuple[TaskText, bool] | None = None
        self._built: tuple[str, bool] | None = None
        self._followed = np.array(robot_description(DEFAULT_ROBOT).home)
        self._requests = JobThread("requests", self._failed)
        session.listen(self.refresh)

    @property
    def run_task(self) -> bool:
        """Whether the Python file of the task may run: the user has allowed it, or the builder wrote it."""
        return self._allowed or self.session.document.wrote_python

    def refresh(self) -> None:
        """Send changed texts, in the thread of edits."""
        requested = (self.session.document.text, self.run_task)
        if requested == self._requested or any(p.file == "scene" for p in self.session.document.problems):
            return
        self._requested = requested
        self.session.status.paths = ()
        self.work("checking the scene", lambda: self._inspect(*requested), kind="inspect")

    def allow_code(self) -> None:
        """Allow the Python file of the task to run from now on, also one from another source, in the thread of edits."""
        self._allowed = True
        self.session.changed()

    def _inspect(self, text: TaskText, run_task: bool) -> None:
        opened = self._open(text, run_task)
        verdicts: tuple[WaypointVerdict, ...] = ()
        if not opened.problems and opened.waypoints:
            verdicts = tuple(self.worker.reach())

        def show() -> None:
            status = self.session.status
            found = {verdict.waypoint: verdict for verdict in verdicts}
            self.session.status = WorldStatus(opened, run_task, found, status.paths, status.work)
            self.session.changed()

        self.session.post(show, "inspected")

    def _open(self, text: TaskText, run_task: bool) -> OpenedTask:
        if self._built == (text.python, run_task):
            return self.worker.place(text.scene)
        self._built = None
        opened = self.worker.open(text, run_task=run_task)
        self._built = None if opened.problems else (text.python, run_task)
        return opened

    def work(self, name: str, job: Callable[[], None], kind: str = "") -> None:
        """Run a job in the thread of requests, and show its name until it ends.

        Args:
            name: Description of the work.
            job: Sends requests.
            kind: A waiting job of the same kind is dropped.
        """

        def run() -> None:
            self._show(name, "")
            try:
                job()
                self._show("", "")
            except RlbenchPinError as error:
                self._show("", str(error))
                self._built = None

        self._requests.post(run, kind)

    def follow(self, pose: FloatArray, begin: bool) -> None:
        """Make the arm follow a dragged waypoint to a pose (7,); a drag begins at the waypoint's configuration."""
        verdict = self.session.status.verdicts.get(self.session.selected)

        def request() -> None:
            start = self._followed
            if begin and verdict is not None and verdict.configuration is not None:
                start = verdict.configuration
            try:
                self._followed, _ = self.worker.follow(pose, start)
            except RlbenchPinError as error:
                self._show("", str(error))
                return
            self._on_arm(self._followed)

        self._requests.post(request, "" if begin else "follow")

    def plan(self) -> None:
        """Plan the path to each waypoint."""

        def request() -> None:
            paths = tuple(self.worker.paths())

            def show() -> None:
                self.session.status.paths = paths
                self.session.changed()

            self.session.post(show)

        self.work("planning paths", request, "paths")

    def wait(self, timeout: float) -> bool:
        """Wait until all requests are answered [s]; return False after a timeout."""
        return self._requests.wait(timeout)

    def _show(self, work: str, fault: str) -> None:
        def show() -> None:
            self.session.status.work, self.session.status.fault = work, fault
            self.session.changed()

        self.session.post(show)

    def _failed(self, error: Exception) -> None:
        _LOG.error("in the thread of requests", exc_info=error)
        self._show("", f"{type(error).__name__}: {error}")

    def stop(self) -> None:
        """End the thread of requests."""
        self.worker.cancel()
        self._requests.stop()
