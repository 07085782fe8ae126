"""The world of the task that is being built, as the process of the stage keeps it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from rlbench_pin.builder.contracts import (
    Failure,
    Frame,
    OpenedTask,
    PlannedPath,
    ReachSpot,
    Recording,
    WaypointVerdict,
)
from rlbench_pin.builder.pictures import camera_pictures
from rlbench_pin.builder.playback.conditions import success_texts
from rlbench_pin.builder.playback.failures import failure_of
from rlbench_pin.builder.playback.recorder import FrameRecorder, OnFrame, record_demonstration
from rlbench_pin.builder.stage.faults import NothingOpen
from rlbench_pin.builder.stage.inside.following import Follower
from rlbench_pin.builder.stage.inside.paths import planned_paths
from rlbench_pin.builder.stage.inside.posing import move_to_frame, move_to_scene, only_moves
from rlbench_pin.builder.stage.inside.pulse import Pulse
from rlbench_pin.builder.stage.inside.reachability import verdicts
from rlbench_pin.builder.stage.inside.standin import stand_in
from rlbench_pin.builder.stage.problems import Pair, problem_of
from rlbench_pin.checking.reach import reach_of
from rlbench_pin.environment import Environment, TaskEnvironment
from rlbench_pin.environment.actions.gripper import Discrete
from rlbench_pin.environment.actions.joint import JointPosition
from rlbench_pin.environment.actions.mode import MoveArmThenGripper
from rlbench_pin.environment.episode import EpisodeRandom, drawn_variations
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.environment.reset import lay_out
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import BoundaryError, ResetError, RlbenchPinError
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks.task_file import load_task_file

RAISED = (Exception, SystemExit, KeyboardInterrupt, GeneratorExit)
"""What a task may raise."""
OnAlive = Callable[[], None]
"""Called now and then while nothing else is; what it raises ends the work."""
MOST_VARIATIONS = 20
"""Variations that a map of what can be reached is drawn over."""


def _silent() -> None:
    """Nobody listens."""


class StageWorld:
    """One task at a time: built, laid out, looked at, played."""

    def __init__(self) -> None:
        self._pair: Pair | None = None
        self._runs_code, self._robot = False, ""
        self._environment: Environment | None = None
        self._task: TaskEnvironment | None = None
        self._follower: Follower | None = None
        self._episode: tuple[int, int] | None = None
        self._began = 0.0
        self._stale = self._moved = False

    @property
    def runtime(self) -> Runtime:
        """World, task and planner of the open task."""
        return self._opened("runtime").runtime

    # Building --------------------------------------------------------------------------------------------------------------

    def open(self, pair: Pair, run_task: bool, robot: str) -> OpenedTask:
        """Build a task; with `run_task` its module is run, otherwise the scene stands alone."""
        if robot != self._robot or self._environment is None:
            self.close()
            mode = MoveArmThenGripper(JointPosition(), Discrete())
            self._environment = Environment(mode, obs_config=low_dim_config(), robot_setup=robot, seed=0)
            self._robot = robot
        self._pair, self._runs_code = pair, run_task
        return self._build()

    def _build(self) -> OpenedTask:
        assert self._pair is not None and self._environment is not None
        self._task, self._episode, self._stale, self._moved = None, None, False, False
        try:
            task = load_task_file(self._pair.python) if self._runs_code else stand_in(self._pair.scene)
            self._task = self._environment.get_task(task)
            return self._description(self._task)
        except RAISED as error:
            self._task = None
            return OpenedTask(0, (), (), (), (problem_of(error, self._pair),))

    @staticmethod
    def _description(environment: TaskEnvironment) -> OpenedTask:
        task = environment.task
        waypoints = tuple(waypoint.frame.name for waypoint in task.get_waypoints())
        return OpenedTask(int(task.variation_count()), success_texts(task), task.get_graspable_objects(), waypoints)

    def place(self) -> OpenedTask:
        """Take the changed scene file over: things are moved where that is all that has changed, otherwise it is built anew."""
        assert self._pair is not None
        if self._task is None:
            return self._build()
        try:
            scene = read_scene(self._pair.scene)
            if not only_moves(self._task.world.spec, scene):
                return self._build()
            move_to_scene(self._task.world, scene)
        except RAISED as error:
            self._task = None
            return OpenedTask(0, (), (), (), (problem_of(error, self._pair),))
        self._stale, self._moved, self._episode = True, False, None
        return self._description(self._task)

    # Looking ---------------------------------------------------------------------------------------------------------------

    def reach(self) -> tuple[WaypointVerdict, ...]:
        """Say of each waypoint whether the hand gets there, in the present layout."""
        with self._laid_out("reach") as runtime:
            return verdicts(runtime)

    def paths(self, on_path: Callable[[PlannedPath], None]) -> tuple[PlannedPath, ...]:
        """Plan the way to each waypoint, in the present layout."""
        with self._laid_out("paths") as runtime:
            return planned_paths(runtime, on_path)

    def follow(self, pose: FloatArray, configuration: FloatArray) -> tuple[FloatArray, float]:
        """Let the arm follow a dragged hand; see `Follower`."""
        model = self._opened("follow").runtime.model
        if self._follower is None or self._follower.model is not model:
            self._follower = Follower(model)
        return self._follower.follow(pose, configuration)

    def pictures(self, size: int, frame: Frame | None = None) -> dict[str, Any]:
        """Return what the cameras see now, or in a frame of a recording."""
        runtime = self._opened("pictures").runtime
        if frame is None:
            return camera_pictures(runtime, size)
        before = runtime.world.save()
        try:
            move_to_frame(runtime.world, frame)
            return camera_pictures(runtime, size)
        finally:
            runtime.world.restore(before)

    # Playing ---------------------------------------------------------------------------------------------------------------

    def reset(self, seed: int, variation: int, on_alive: OnAlive = _silent) -> Recording:
        """Lay out an episode; its recording is one frame, with a failure when it was refused."""
        environment = self._fresh("reset")
        failure = None
        try:
            with environment.runtime.listening(Pulse(on_alive)):
                environment.reset(seed=seed, variation=variation)
        except ResetError as error:
            failure = _with_evidence(self._failure(error, environment), environment.runtime)
        except RAISED as error:
            failure = self._failure(error, environment)
        self._episode, self._moved, self._began = (seed, variation), False, environment.world.time
        recorder = FrameRecorder(environment.runtime)
        try:
            return replace(recorder.recording(failure), frames=(recorder.frame(),))
        except RAISED as error:  # a condition of the task's own
            return Recording((), (), "", (), failure or self._failure(error, environment))

    def demonstrate(self, seed: int, variation: int, on_frame: OnFrame, on_alive: OnAlive = _silent) -> Recording:
        """Reset and play the demonstration; the frames go to `on_frame` alone."""
        environment = self._fresh("demonstrate")
        self._episode, self._moved = (seed, variation), True

        def seen(frame: Frame) -> None:
            self._began = environment.world.time - frame.time
            on_frame(frame)

        try:
            with environment.runtime.listening(Pulse(on_alive)):
                recording = record_demonstration(environment, seed, variation, seen)
            return replace(recording, frames=())
        except RAISED as error:
            return replace(self._empty(environment), failure=self._failure(error, environment))

    def simulate(self, seconds: float, on_frame: OnFrame) -> Recording:
        """Go on from the present moment with the arm held still; the frames go to `on_frame` alone."""
        environment = self._opened("simulate")
        try:
            if self._episode is None and not self._moved:
                environment = self._begin_in_place()
            since, self._moved = environment.world.time - self._began, True
            environment.runtime.hold()
            with FrameRecorder(environment.runtime, lambda f: on_frame(replace(f, time=f.time + since))) as recorder:
                for _ in range(max(1, round(seconds / environment.world.control_dt))):
                    environment.runtime.step()
                    if environment.task.get_success_conditions():
                        environment.task.success()
                return replace(recorder.recording(), frames=())
        except RAISED as error:
            return replace(self._empty(environment), failure=self._failure(error, environment))

    def _begin_in_place(self) -> TaskEnvironment:
        """Begin an episode with the task where its scene says."""
        environment = self._fresh("simulate")
        lay_out(environment.runtime, 0, EpisodeRandom.from_seed(0), static=True)
        self._began = environment.world.time
        return environment

    def _empty(self, environment: TaskEnvironment) -> Recording:
        sentence = next(iter(environment.runtime.instructions), "")
        return Recording((), success_texts(environment.task), sentence)

    def _failure(self, error: BaseException, environment: TaskEnvironment) -> Failure:
        assert self._pair is not None
        problem = problem_of(error, self._pair)
        if not isinstance(error, RlbenchPinError):
            return Failure(problem.message, problem=problem)
        own = problem if problem.file == "task" and problem.line else None
        try:
            return replace(failure_of(error, "", environment.task), problem=own)
        except RAISED:  # a condition of the task's own
            return Failure(str(error), problem=own)

    # Judging ---------------------------------------------------------------------------------------------------------------

    def reach_map(self, layouts: int, on_spot: Callable[[ReachSpot], None]) -> tuple[ReachSpot, ...]:
        """Lay the task out so many times and see which waypoints can be reached; a layout without a place is left out."""
        environment = self._fresh("reach_map")
        self._episode, self._moved = None, False
        variations = drawn_variations(environment.variation_count(), MOST_VARIATIONS)
        spots: list[ReachSpot] = []
        for seed in range(layouts):
            try:
                reach = reach_of(environment.runtime, seed, variations[seed % len(variations)])
            except BoundaryError:
                continue
            spots.append(ReachSpot(reach.place, reach.reached, reach.spots, reach.free))
            on_spot(spots[-1])
        environment.world.restore(environment.world.origin)
        return tuple(spots)

    # What is open ----------------------------------------------------------------------------------------------------------

    def _opened(self, operation: str) -> TaskEnvironment:
        if self._task is None:
            raise NothingOpen(operation)
        return self._task

    def _fresh(self, operation: str) -> TaskEnvironment:
        """Return the task in a world that was built from the scene as it is now."""
        self._opened(operation)
        if self._stale:
            problems = self._build().problems
            if problems:
                raise NothingOpen(operation, problems[0].message)
        return self._opened(operation)

    @contextmanager
    def _laid_out(self, operation: str) -> Iterator[Runtime]:
        """Have the task for a block in the layout in which the last episode began, or where its scene says."""
        environment = self._opened(operation)
        runtime = environment.runtime
        if not self._moved:
            yield runtime
            return
        before = runtime.save()
        try:
            if self._episode is None:
                runtime.world.restore(runtime.world.origin)
            else:
                environment.reset(seed=self._episode[0], variation=self._episode[1])
            yield runtime
        finally:
            runtime.restore(before)

    def close(self) -> None:
        """Free the world."""
        if self._environment is not None:
            self._environment.shutdown()
        self._environment = self._task = self._follower = None


def _with_evidence(failure: Failure, runtime: Runtime) -> Failure:
    """Add to a refused start what the first waypoint lacks that is not free in the scene at rest, which is shown then."""
    try:
        lacking = next((verdict.failure for verdict in verdicts(runtime) if verdict.failure is not None), None)
    except RAISED:  # waypoints of the task's own
        return failure
    return failure if lacking is None else replace(lacking, cause=failure.cause, problem=failure.problem)
