"""The stage as the server asks it: the world of one task, in a process that may hang, crash, or run a user's module."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rlbench_pin.builder.contracts import (
    Frame,
    Judgement,
    OpenedTask,
    PlannedPath,
    ReachSpot,
    Recording,
    TaskText,
    WaypointVerdict,
)
from rlbench_pin.builder.stage.faults import NothingOpen, StageStopped
from rlbench_pin.builder.stage.folder import PrivateFolder, check_name
from rlbench_pin.builder.stage.limits import StageLimits
from rlbench_pin.builder.stage.link import Link, OnNote
from rlbench_pin.builder.stage.session import Session
from rlbench_pin.builder.stage.turns import Turns
from rlbench_pin.builder.stage.wire import plain, record
from rlbench_pin.robot.description import robot_description
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array, as_flag, as_function, as_number, as_pose, as_record, as_seed, as_text, as_whole

LONGEST_SIMULATION = 600.0
"""Simulated time of one call at most [s]."""
LARGEST_PICTURE = 1024
"""Width and height of a picture at most [px]."""
MOST_EPISODES, MOST_LAYOUTS = 10_000, 100_000
_TEXT = "the text of a task"


class StageClient:
    """The world of a task that is being built, for any thread of the server; every method waits for the answer.

    The world lives in one process, the validator in a second one, so that a task can be edited while it is judged. Either is
    started anew when it died, hung or was stopped, and the task opened again, by the next operation.

    Args:
        limits: How long things may take; None takes the default.

    Raises:
        StageBusy: (all operations) Another one runs, and did not end while this one waited.
        StageFault: (all operations) The process died, hung, or could not do it.
        StageStopped: (all operations) `cancel` was called.
        NothingOpen: (all but `open`) No task is open, or the one that is cannot be built.
        StageClosed: (all operations) `close` was called.
    """

    def __init__(self, limits: StageLimits | None = None) -> None:
        limits = StageLimits() if limits is None else as_record(limits, StageLimits, "limits")
        self.limits = limits
        self._folder = PrivateFolder()
        self._session = Session(self._folder, limits)
        self._judges, self._judge_turns = Link("judge", self._folder.path, limits), Turns(limits.wait)
        self._session.link.warm()

    @property
    def process_id(self) -> int | None:
        """Number of the process of the world, None before it has answered."""
        return self._session.link.pid

    @property
    def folder(self) -> Path:
        """The private folder, which goes away with the server."""
        return self._folder.path

    # Building --------------------------------------------------------------------------------------------------------------

    def open(self, text: TaskText, *, run_task: bool, robot: str = "panda") -> OpenedTask:
        """Build a task from its text, and lay it out where its scene says.

        Args:
            text: The two files.
            run_task: Run the module. Otherwise no line of it runs: the scene stands alone, without conditions.
            robot: Name of the arm.

        Returns:
            What it holds, or with `problems` why it cannot be built; then the other operations raise NothingOpen.

        Raises:
            UnknownRobot: There is no such arm.
            InvalidValue: The name of the task is none.
        """
        check_name(as_record(text, TaskText, _TEXT).name)
        run_task, robot = as_flag(run_task, "run_task"), robot_description(robot).name
        return self._session.open(text, run_task, robot)

    def place(self, scene: str) -> OpenedTask:
        """Take a changed scene over, and lay it out where it says; quick where it only puts things elsewhere.

        Args:
            scene: Content of `<task>.toml`.
        """
        return self._session.place(as_text(scene, "scene"))

    # Looking ---------------------------------------------------------------------------------------------------------------

    def reach(self) -> tuple[WaypointVerdict, ...]:
        """Say of each waypoint whether the hand gets there after the ones before it, in the present layout."""
        answer = self._session.ask("reach", {}, self.limits.reach)
        return tuple(record(WaypointVerdict, verdict) for verdict in answer)

    def follow(self, pose: ArrayLike, configuration: ArrayLike) -> tuple[FloatArray, float]:
        """Let the arm follow a dragged hand.

        Args:
            pose: Pose (7,) of the hand's tip in the world.
            configuration: Joint positions (n,) from which the arm goes there [rad].

        Returns:
            Joint positions (n,) nearer to it, and what is left: the larger of distance [m] and angle [rad].
        """
        question = {"pose": as_pose(pose, "pose"), "configuration": as_array(configuration, "configuration")}
        q, error = self._session.ask("follow", question, self.limits.follow)
        return np.array(q), float(error)

    def paths(self, on_path: Callable[[PlannedPath], None] | None = None) -> tuple[PlannedPath, ...]:
        """Plan the way to each waypoint, in the present layout; `on_path` is called with each as it is found."""
        return tuple(
            record(PlannedPath, path) for path in self._session.ask("paths", {}, self.limits.paths, _on(PlannedPath, on_path))
        )

    def pictures(self, size: int = 128) -> dict[str, NDArray[np.uint8]]:
        """Return name -> picture (size, size, 3) of each of the five cameras at the present moment."""
        return self._pictures(size, None)

    def pictures_at(self, frame: Frame, size: int = 128) -> dict[str, NDArray[np.uint8]]:
        """Return what the cameras see in a frame of a recording; the world stays as it is."""
        return self._pictures(size, plain(as_record(frame, Frame, "frame")))

    def _pictures(self, size: int, frame: object) -> dict[str, NDArray[np.uint8]]:
        question = {"size": as_whole(size, "size [px]", least=8, most=LARGEST_PICTURE), "frame": frame}
        pictures: dict[str, NDArray[np.uint8]] = self._session.ask("pictures", question, self.limits.picture)
        return pictures

    # Playing ---------------------------------------------------------------------------------------------------------------

    def reset(self, seed: int, variation: int = 0) -> Recording:
        """Lay out an episode; its recording is one frame, with a failure when the reset was refused."""
        recording = record(Recording, self._session.ask("reset", _episode(seed, variation), self.limits.reset))
        self._session.episode = (seed, variation)
        return recording

    def demonstrate(self, seed: int, variation: int = 0, on_frame: Callable[[Frame], None] | None = None) -> Recording:
        """Reset, play the demonstration once, and return every frame; `on_frame` is called with each while it runs."""
        try:
            recording = self._recording("demonstrate", _episode(seed, variation), on_frame)
        except StageStopped:
            self._session.episode = (seed, variation)
            raise
        self._session.episode = (seed, variation)
        return recording

    def simulate(self, seconds: float, on_frame: Callable[[Frame], None] | None = None) -> Recording:
        """Go on from the present moment with the arm held still; before the first reset with the task where its scene says."""
        seconds = as_number(seconds, "seconds [s]", above=0.0, most=LONGEST_SIMULATION)
        return self._recording("simulate", {"seconds": seconds}, on_frame)

    def _recording(self, operation: str, question: dict[str, Any], on_frame: Callable[[Frame], None] | None) -> Recording:
        frames: list[Frame] = []
        notes = _on(Frame, on_frame, frames)
        answer = self._session.ask(operation, question, self.limits.tick, notes)
        return replace(record(Recording, answer), frames=tuple(frames))

    # Judging ---------------------------------------------------------------------------------------------------------------

    def judge(
        self,
        episodes: int,
        on_judgement: Callable[[Judgement], None] | None = None,
        on_progress: Callable[[int, int], None] | None = None,
    ) -> tuple[Judgement, ...]:
        """Ask what `rlbench-pin check` asks.

        Args:
            episodes: How many demonstrations.
            on_judgement: Called with a line whenever it changes; `passed` is None until its part is done.
            on_progress: Called with the number of trials that are done and that there are.
        """
        episodes = as_whole(episodes, "episodes", least=1, most=MOST_EPISODES)
        as_function(on_progress, "on_progress")
        judged = _on(Judgement, on_judgement)

        def noted(name: str, value: Any) -> None:
            if name == "judgement":
                judged(name, value)
            elif on_progress is not None:
                on_progress(*value)

        with self._judge_turn("judge") as question:
            if not self._session.run_task:
                raise NothingOpen("judge", "its code was not allowed to run. Open it with run_task=True.")
            answer = self._judges.ask("judge", {**question, "episodes": episodes}, self.limits.trial, noted)
        return tuple(record(Judgement, line) for line in answer)

    def reach_map(self, layouts: int, on_spot: Callable[[ReachSpot], None] | None = None) -> tuple[ReachSpot, ...]:
        """Lay the task out so many times, from seed 0 on, and see which waypoints can be reached from each place."""
        question = {"layouts": as_whole(layouts, "layouts", least=1, most=MOST_LAYOUTS)}
        notes = _on(ReachSpot, on_spot)
        with self._judge_turn("reach_map") as pair:
            self._judges.ask("open", {**pair, "run_task": self._session.run_task, "robot": self._session.robot}, self.limits.open)
            answer = self._judges.ask("reach_map", question, self.limits.trial, notes)
        return tuple(record(ReachSpot, spot) for spot in answer)

    # Life ------------------------------------------------------------------------------------------------------------------

    def cancel(self, operation: str = "") -> bool:
        """End what runs, from another thread; it raises StageStopped there.

        Args:
            operation: End this one alone, such as `judge`; empty: all.

        Returns:
            Whether something ran.
        """
        places = ((self._session.turns, self._session.link), (self._judge_turns, self._judges))
        stopped = [link.stop() for turns, link in places if operation in ("", turns.running)]
        return any(stopped)

    def close(self) -> None:
        """End the processes and remove the private folder; may be called again."""
        self._session.close()
        self._judges.close()
        self._folder.close()

    def __enter__(self) -> StageClient:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    @contextmanager
    def _judge_turn(self, operation: str) -> Iterator[dict[str, str]]:
        """Have the validator for a block, with the pair as it is now in a folder of its own."""
        with self._judge_turns.take(operation):
            text = self._session.usable(operation)
            self._judges.python = self._folder.write("judge", text)
            yield {"python": str(self._judges.python), "folder": str(text.folder)}


def _episode(seed: int, variation: int) -> dict[str, Any]:
    return {"seed": as_seed(seed), "variation": as_whole(variation, "variation", least=0)}


def _on(kind: type, callback: Callable[[Any], None] | None, kept: list[Any] | None = None) -> OnNote:
    """Return what makes a record of what arrives, keeps it, and calls back."""
    as_function(callback, "a callback")

    def noted(name: str, value: Any) -> None:
        if name == "alive":
            return
        made: Any = record(kind, value)
        if kept is not None:
            kept.append(made)
        if callback is not None:
            callback(made)

    return noted
