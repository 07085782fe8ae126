"""The client of the worker processes: the world of one task, and its validator."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rlbench_pin.builder.contracts import (
    OpenedTask,
    PlannedPath,
    ReachSpot,
    TaskText,
    ValidationLine,
    WaypointVerdict,
)
from rlbench_pin.builder.worker.encoding import decode, encode
from rlbench_pin.builder.worker.process import (
    NothingOpen,
    OnNote,
    PrivateFolder,
    WorkerClosed,
    WorkerFault,
    WorkerLimits,
    WorkerProcess,
    WorkerStopped,
    check_name,
)
from rlbench_pin.robot.description import robot_description
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array, as_flag, as_function, as_number, as_pose, as_record, as_seed, as_text, as_whole
from rlbench_pin.viewer.recording import Frame, Problem, Recording

MAX_SIMULATION = 600.0
"""Simulated time of one call at most [s]."""
MAX_IMAGE_SIZE = 1024
"""Width and height of an image at most [px]."""
MAX_EPISODES, MAX_LAYOUTS = 10_000, 100_000


class WorkerClient:
    """The world of the edited task, for any thread of the server; every method waits for the answer.

    The world lives in one process and the validator in a second one, so that a task can be edited while it is validated. After
    a crash, a time limit or a stop, the next operation starts a new process and opens the task again.

    Args:
        limits: Time limits and memory; None uses the defaults.

    Raises:
        WorkerBusy: (all operations) Another one runs, and did not end in time.
        WorkerFault: (all operations) The process died, hung, or failed.
        WorkerStopped: (all operations) `cancel` was called.
        NothingOpen: (all but `open`) No task is open, or it cannot be built.
        WorkerClosed: (all operations) `close` was called.
    """

    def __init__(self, limits: WorkerLimits | None = None) -> None:
        self.limits = WorkerLimits() if limits is None else as_record(limits, WorkerLimits, "limits")
        self._folder = PrivateFolder()
        self._world = WorkerProcess("world", self._folder.path, self.limits)
        self._validator = WorkerProcess("validator", self._folder.path, self.limits)
        self._run_task, self._robot = False, ""
        self._episode: tuple[int, int] | None = None
        self._text: TaskText | None = None
        self._problem: Problem | None = None
        self._opened_in, self._ran_in, self._closed = 0, 0, False
        self._world.start()

    @property
    def folder(self) -> Path:
        """The private folder, which is removed at the end."""
        return self._folder.path

    # Building -----------------------------------------------------------------------------------------------------------------

    def open(self, text: TaskText, *, run_task: bool, robot: str = "panda") -> OpenedTask:
        """Build a task from its text, with the layout of its scene.

        Args:
            text: The two files.
            run_task: Run the Python file. Otherwise none of its code runs: the scene is built alone, without conditions.
            robot: Name of the arm.

        Returns:
            Its content, or in `problems` why it cannot be built; then the other operations raise NothingOpen.

        Raises:
            UnknownRobot: There is no such arm.
            InvalidValue: The name of the task is not valid.
        """
        check_name(as_record(text, TaskText, "the text of a task").name)
        run_task, robot = as_flag(run_task, "run_task"), robot_description(robot).reference
        with self._world_turn("open"):
            self._text, self._run_task, self._robot = text, run_task, robot
            return self._open()

    def place(self, scene: str) -> OpenedTask:
        """Use a changed scene, with the layout of the scene; fast if only poses and joint positions have changed.

        Args:
            scene: Content of `<task>.toml`.
        """
        scene = as_text(scene, "scene")
        with self._world_turn("place"):
            if self._text is None:
                raise NothingOpen("place")
            before, self._text, self._episode = self._text, replace(self._text, scene=scene), None
            if self._problem is not None or not self._is_open:
                return self._open()
            self._world.python = self._folder.update(self._world.python, before, self._text)
            return self._build("place", {}, self.limits.place)[0]

    # Inspection -----------------------------------------------------------------------------------------------------------------

    def reach(self) -> tuple[WaypointVerdict, ...]:
        """Return for each waypoint whether the gripper reaches it after the ones before it, in the current layout."""
        return tuple(decode(WaypointVerdict, verdict) for verdict in self._ask("reach", {}, self.limits.reach))

    def follow(self, pose: ArrayLike, configuration: ArrayLike) -> tuple[FloatArray, float]:
        """Move the arm towards a dragged gripper.

        Args:
            pose: Pose (7,) of the tip in the world.
            configuration: Joint positions (n,) from which the arm moves [rad].

        Returns:
            Joint positions (n,) nearer to it, and the remaining error: the larger of distance [m] and angle [rad].
        """
        question = {"pose": as_pose(pose, "pose"), "configuration": as_array(configuration, "configuration")}
        q, error = self._ask("follow", question, self.limits.follow)
        return np.array(q), float(error)

    def paths(self, on_path: Callable[[PlannedPath], None] | None = None) -> tuple[PlannedPath, ...]:
        """Plan the path to each waypoint in the current layout; `on_path` is called with each."""
        found = self._ask("paths", {}, self.limits.paths, _on(PlannedPath, on_path))
        return tuple(decode(PlannedPath, path) for path in found)

    def images(self, size: int = 128, frame: Frame | None = None) -> dict[str, NDArray[np.uint8]]:
        """Return name -> image (size, size, 3) of each of the five cameras.

        Args:
            size: Width and height [px].
            frame: A frame of a recording, which changes nothing in the world; None uses the current state.
        """
        sent = None if frame is None else encode(as_record(frame, Frame, "frame"))
        question = {"size": as_whole(size, "size [px]", least=8, most=MAX_IMAGE_SIZE), "frame": sent}
        images: dict[str, NDArray[np.uint8]] = self._ask("images", question, self.limits.image)
        return images

    # Playing ------------------------------------------------------------------------------------------------------------------

    def reset(self, seed: int, variation: int = 0) -> Recording:
        """Start an episode; its recording has one frame, and a failure if the reset was refused."""
        recording = decode(Recording, self._ask("reset", _episode(seed, variation), self.limits.reset))
        self._episode = (seed, variation)
        return recording

    def demonstrate(self, seed: int, variation: int = 0, on_frame: Callable[[Frame], None] | None = None) -> Recording:
        """Reset, play the demonstration once, and return every frame; `on_frame` is called with each while it runs."""
        try:
            recording = self._recording("demonstrate", _episode(seed, variation), on_frame)
        except WorkerStopped:
            self._episode = (seed, variation)
            raise
        self._episode = (seed, variation)
        return recording

    def simulate(self, seconds: float, on_frame: Callable[[Frame], None] | None = None) -> Recording:
        """Continue from the current state with the arm stationary; before the first reset, with the layout of the scene."""
        seconds = as_number(seconds, "seconds [s]", above=0.0, most=MAX_SIMULATION)
        return self._recording("simulate", {"seconds": seconds}, on_frame)

    def _recording(self, operation: str, question: dict[str, Any], on_frame: Callable[[Frame], None] | None) -> Recording:
        frames: list[Frame] = []
        answer = self._ask(operation, question, self.limits.tick, _on(Frame, on_frame, frames))
        return replace(decode(Recording, answer), frames=tuple(frames))

    # Validation ---------------------------------------------------------------------------------------------------------------

    def validate(
        self,
        episodes: int,
        on_line: Callable[[ValidationLine], None] | None = None,
        on_progress: Callable[[int, int], None] | None = None,
    ) -> tuple[ValidationLine, ...]:
        """Run the trials of `rlbench-pin check`.

        Args:
            episodes: Number of demonstrations.
            on_line: Called with a line whenever it changes; `passed` is None until its part is done.
            on_progress: Called with the numbers of finished and of all trials.
        """
        episodes = as_whole(episodes, "episodes", least=1, most=MAX_EPISODES)
        as_function(on_progress, "on_progress")
        on_sent_line = _on(ValidationLine, on_line)

        def noted(name: str, value: Any) -> None:
            if name == "line":
                on_sent_line(name, value)
            elif on_progress is not None:
                on_progress(*value)

        with self._validator_turn("validate") as question:
            if not self._run_task:
                raise NothingOpen("validate", "its code may not run. Open it with run_task=True.")
            answer = self._validator.ask("validate", {**question, "episodes": episodes}, self.limits.trial, noted)
        return tuple(decode(ValidationLine, line) for line in answer)

    def reach_map(self, layouts: int, on_spot: Callable[[ReachSpot], None] | None = None) -> tuple[ReachSpot, ...]:
        """Lay the task out for that many seeds, from 0 on, and return which waypoints the arm reaches in each layout."""
        question = {"layouts": as_whole(layouts, "layouts", least=1, most=MAX_LAYOUTS)}
        notes = _on(ReachSpot, on_spot)
        with self._validator_turn("reach_map") as pair:
            self._validator.ask("open", {**pair, "run_task": self._run_task, "robot": self._robot}, self.limits.open)
            answer = self._validator.ask("reach_map", question, self.limits.trial, notes)
        return tuple(decode(ReachSpot, spot) for spot in answer)

    # Life ---------------------------------------------------------------------------------------------------------------------

    def cancel(self, operation: str = "") -> bool:
        """Stop the running operation from another thread; the operation raises WorkerStopped.

        Args:
            operation: End only this operation, such as `validate`; empty: all.

        Returns:
            Whether an operation ran.
        """
        stopped = [process.stop() for process in (self._world, self._validator) if operation in ("", process.running)]
        return any(stopped)

    def close(self) -> None:
        """End the processes and remove the private folder; repeated calls have no effect."""
        self._closed = True
        self._world.close()
        self._validator.close()
        self._folder.close()

    def __enter__(self) -> WorkerClient:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    # The processes ------------------------------------------------------------------------------------------------------------

    @contextmanager
    def _world_turn(self, operation: str) -> Iterator[None]:
        """Reserve the world for a block; a process that has died in it is restarted at once."""
        with self._world.turn(operation):
            if self._closed:
                raise WorkerClosed(operation)
            try:
                yield
            finally:
                with suppress(WorkerFault):
                    self._world.start()

    @contextmanager
    def _validator_turn(self, operation: str) -> Iterator[dict[str, str]]:
        """Reserve the validator for a block, with the current text in a folder of its own."""
        with self._validator.turn(operation):
            text = self._usable(operation)
            self._validator.python = self._folder.write("validator", text)
            yield {"python": str(self._validator.python), "folder": str(text.folder)}

    def _ask(self, operation: str, question: dict[str, Any], limit: float, on_note: OnNote | None = None) -> Any:
        """Ask the world, with the task opened again if its process is new; see `WorkerProcess.ask`."""
        with self._world_turn(operation):
            self._usable(operation)
            if not self._is_open:
                self._open_again(operation)
            return self._world.ask(operation, question, limit, on_note)

    def _usable(self, operation: str) -> TaskText:
        """Return the text that is open; raise NothingOpen or WorkerClosed if there is none."""
        if self._closed:
            raise WorkerClosed(operation)
        if self._text is None:
            raise NothingOpen(operation)
        if self._problem is not None:
            raise NothingOpen(operation, f"it cannot be built. {self._problem.message}")
        return self._text

    def _open(self) -> OpenedTask:
        """Open the text; a failure in a process in which a module has run before is tried again in a new one."""
        has_run = self._ran_in == self._world.generation
        opened, is_late = self._open_once()
        if opened.problems and has_run and not is_late:
            self._world.end()
            opened, _ = self._open_once()
        if self._run_task:
            self._ran_in = self._world.generation
        return opened

    def _open_once(self) -> tuple[OpenedTask, bool]:
        assert self._text is not None
        self._episode, self._world.python = None, self._folder.write("world", self._text)
        question = {"python": str(self._world.python), "folder": str(self._text.folder)}
        return self._build("open", {**question, "run_task": self._run_task, "robot": self._robot}, self.limits.open)

    def _build(self, operation: str, question: dict[str, Any], limit: float) -> tuple[OpenedTask, bool]:
        """Build the world, and return also whether it took too long; a process that dies of it is a problem of the task."""
        is_late = False
        try:
            opened = decode(OpenedTask, self._world.ask(operation, question, limit))
        except WorkerFault as fault:
            problem = fault.problem or Problem("task" if self._run_task else "scene", None, str(fault))
            opened, is_late = OpenedTask(0, (), (), (), (problem,)), fault.kind == "timed out"
        self._problem = opened.problems[0] if opened.problems else None
        self._opened_in = self._world.generation
        return opened, is_late

    def _open_again(self, operation: str) -> None:
        """Open the task in a new process, and start the episode again."""
        episode = self._episode
        if self._open().problems:
            self._usable(operation)
        if episode is not None:
            self._world.ask("reset", {"seed": episode[0], "variation": episode[1]}, self.limits.reset)
            self._episode = episode

    @property
    def _is_open(self) -> bool:
        return self._world.pid is not None and self._world.generation == self._opened_in


def _episode(seed: int, variation: int) -> dict[str, Any]:
    return {"seed": as_seed(seed), "variation": as_whole(variation, "variation", least=0)}


def _on(kind: type, callback: Callable[[Any], None] | None, kept: list[Any] | None = None) -> OnNote:
    """Return a function that decodes a note, keeps it, and calls back."""
    as_function(callback, "a callback")

    def noted(name: str, value: Any) -> None:
        if name == "alive":
            return
        made: Any = decode(kind, value)
        if kept is not None:
            kept.append(made)
        if callback is not None:
            callback(made)

    return noted
