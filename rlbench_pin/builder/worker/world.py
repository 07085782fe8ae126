"""The world of the edited task in the worker process."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.builder.contracts import OpenedTask, PlannedPath, ReachSpot, WaypointVerdict
from rlbench_pin.builder.worker.problems import Pair, problem_of
from rlbench_pin.builder.worker.process import NothingOpen
from rlbench_pin.builder.worker.reach import planned_paths, verdicts
from rlbench_pin.checking.reach import reach_of
from rlbench_pin.control.differential_ik import DifferentialIK
from rlbench_pin.environment import Environment, TaskEnvironment
from rlbench_pin.environment.actions.modes import Discrete, JointPosition, MoveArmThenGripper
from rlbench_pin.environment.episode import EpisodeRandom, drawn_variations
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.environment.reset import lay_out
from rlbench_pin.environment.runtime import Listener, Runtime
from rlbench_pin.errors import BoundaryError, PlanningError, ResetError, RlbenchPinError
from rlbench_pin.planning.plan import Plan, PlanRequest
from rlbench_pin.robot.geometry import to_placement
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.scene.spec import ROOT, PlacementSpec, SceneSpec
from rlbench_pin.sim import Body, World
from rlbench_pin.spatial import IDENTITY, FloatArray, compose, relative, se3_to_pose
from rlbench_pin.tasks import Task, camel_case
from rlbench_pin.tasks.registry import load_task_file
from rlbench_pin.urdf import UrdfJoint, read_urdf
from rlbench_pin.values import as_vector
from rlbench_pin.viewer.recording import (
    Failure,
    Frame,
    FrameRecorder,
    OnFrame,
    Recording,
    camera_images,
    failure_of,
    record_demonstration,
    success_texts,
)

RAISED = (Exception, SystemExit, KeyboardInterrupt, GeneratorExit)
"""Errors that a task may raise."""
OnAlive = Callable[[], None]
"""Called now and then while there is nothing else to report; an exception ends the work."""
_ALIVE_INTERVAL = 0.5
"""Least time between two such calls [s]."""
FOLLOW_TICKS = 30
"""Control ticks of one step after a dragged gripper at most."""
_ARRIVED = 1e-4
"""Largest error of a tip that has arrived, [m] and [rad]."""
MAX_VARIATIONS = 20
"""Variations in a reach map."""


class AliveListener(Listener):
    """Calls back while a runtime plans, simulates or solves inverse kinematics."""

    def __init__(self, on_alive: OnAlive, interval: float = _ALIVE_INTERVAL) -> None:
        self._on_alive, self._interval, self._last = on_alive, interval, time.monotonic()

    def on_reach(self, seconds: float) -> None:
        self._beat()

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        self._beat()

    def on_tick(self, seconds: float) -> None:
        self._beat()

    def _beat(self) -> None:
        if time.monotonic() - self._last >= self._interval:
            self._last = time.monotonic()
            self._on_alive()


class TaskWorld:
    """The world of one task: build, set up, inspect and simulate it."""

    def __init__(self) -> None:
        self._pair: Pair | None = None
        self._runs_code, self._robot = False, ""
        self._environment: Environment | None = None
        self._task: TaskEnvironment | None = None
        self._ik: tuple[RobotModel, DifferentialIK] | None = None
        self._episode: tuple[int, int] | None = None
        self._began = 0.0
        self._stale = self._moved = False

    @property
    def runtime(self) -> Runtime:
        """World, task and planner of the opened task."""
        return self._opened("runtime").runtime

    # Building --------------------------------------------------------------------------------------------------------------

    def open(self, pair: Pair, run_task: bool, robot: str) -> OpenedTask:
        """Build a task; without `run_task` the scene alone, and none of its code runs."""
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
            task = load_task_file(self._pair.python) if self._runs_code else scene_only(self._pair.scene)
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
        """Use the changed scene file: move its items if only poses have changed, else build the task again."""
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

    # Inspection --------------------------------------------------------------------------------------------------------------

    def reach(self) -> tuple[WaypointVerdict, ...]:
        """Return whether the gripper reaches each waypoint, in the current layout."""
        with self._laid_out("reach") as runtime:
            return verdicts(runtime)

    def paths(self, on_path: Callable[[PlannedPath], None]) -> tuple[PlannedPath, ...]:
        """Plan the path to each waypoint, in the current layout."""
        with self._laid_out("paths") as runtime:
            return planned_paths(runtime, on_path)

    def follow(self, pose: FloatArray, configuration: FloatArray) -> tuple[FloatArray, float]:
        """Move a configuration (n,) towards a pose (7,) of the tip, within the joint limits; see `WorkerClient.follow`."""
        model = self._opened("follow").runtime.model
        if self._ik is None or self._ik[0] is not model:
            self._ik = (model, DifferentialIK(model))
        ik, limits = self._ik[1], model.limits
        start = as_vector(configuration, model.size, "configuration")
        q, v = np.clip(start, limits.lower, limits.upper), np.zeros(model.size)
        for _ in range(FOLLOW_TICKS):
            if _tip_error(model, pose, q) < _ARRIVED:
                break
            v = ik.velocity_to_pose(q, v, pose)
            q = np.clip(q + ik.config.dt * v, limits.lower, limits.upper)
        return q, _tip_error(model, pose, q)

    def images(self, size: int, frame: Frame | None = None) -> dict[str, Any]:
        """Return the images of the cameras now, or in a frame of a recording."""
        runtime = self._opened("images").runtime
        if frame is None:
            return camera_images(runtime, size)
        before = runtime.world.save()
        try:
            move_to_frame(runtime.world, frame)
            return camera_images(runtime, size)
        finally:
            runtime.world.restore(before)

    # Playing ---------------------------------------------------------------------------------------------------------------

    def reset(self, seed: int, variation: int, on_alive: OnAlive = lambda: None) -> Recording:
        """Start an episode; its recording has one frame, and a failure if the reset was refused."""
        environment = self._fresh("reset")
        failure = None
        try:
            with environment.runtime.listening(AliveListener(on_alive)):
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

    def demonstrate(self, seed: int, variation: int, on_frame: OnFrame, on_alive: OnAlive = lambda: None) -> Recording:
        """Reset and play the demonstration; the frames go to `on_frame` only."""
        environment = self._fresh("demonstrate")
        self._episode, self._moved = (seed, variation), True

        def seen(frame: Frame) -> None:
            self._began = environment.world.time - frame.time
            on_frame(frame)

        try:
            with environment.runtime.listening(AliveListener(on_alive)):
                recording = record_demonstration(environment, seed, variation, seen)
            return replace(recording, frames=())
        except RAISED as error:
            return replace(self._empty(environment), failure=self._failure(error, environment))

    def simulate(self, seconds: float, on_frame: OnFrame) -> Recording:
        """Continue from the current state with the arm stationary; the frames go to `on_frame` only."""
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

    # Reach map ---------------------------------------------------------------------------------------------------------------

    def reach_map(self, layouts: int, on_spot: Callable[[ReachSpot], None]) -> tuple[ReachSpot, ...]:
        """Set up the task for each seed and check which waypoints can be reached; a layout without a free place is left out."""
        environment = self._fresh("reach_map")
        self._episode, self._moved = None, False
        variations = drawn_variations(environment.variation_count(), MAX_VARIATIONS)
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
        """Put the task for a block into the layout in which the last episode began, or into that of its scene."""
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
        self._environment = self._task = self._ik = None


def _tip_error(model: RobotModel, pose: FloatArray, q: FloatArray) -> float:
    """Return the larger of distance [m] and angle [rad] between the tip in a configuration (n,) and a pose (7,)."""
    off = relative(pose, model.tip_pose(q))
    angle = 2.0 * np.arctan2(np.linalg.norm(off[3:6]), abs(off[6]))
    return float(max(np.linalg.norm(off[:3]), angle))


def _with_evidence(failure: Failure, runtime: Runtime) -> Failure:
    """Add to a refused start the verdict on the first waypoint that is not free in the scene at rest, which is then shown."""
    try:
        lacking = next((verdict.failure for verdict in verdicts(runtime) if verdict.failure is not None), None)
    except RAISED:  # waypoints of the task's own
        return failure
    return failure if lacking is None else replace(lacking, cause=failure.cause, problem=failure.problem)


# Poses without simulation -----------------------------------------------------------------------------------------------------

_POSED = ("body", "frame", "region", "sensor", "waypoint")


def only_moves(old: SceneSpec, new: SceneSpec) -> bool:
    """Return whether two scenes differ only in poses, joint positions and placement."""
    return _without_places(old) == _without_places(new)


def move_to_scene(world: World, scene: SceneSpec) -> None:
    """Move everything to the poses of a scene that differs from the world's in poses only; the arm is at home."""
    world.restore(world.origin)
    joints = {joint.name: joint for joint in scene.joint}
    for body in world.bodies.values():
        for name in body.joints:
            start = joints.get(f"{body.name}/{name}")
            body.joints[name].set_position(0.0 if start is None else start.position)
    world.place_root(np.array(scene.placement.pose))
    frames = (*scene.frame, *scene.waypoint, *scene.region, *scene.sensor)
    for frame in frames:
        world.frame(frame.name).set_state(frame.parent, np.array(frame.pose, dtype=np.float64))
    for spec in sorted(scene.body, key=lambda spec: _depth(scene, spec.name)):
        parent = _pose_of(world, spec.parent)
        world.body(spec.name).set_pose(compose(parent, np.array(spec.pose)))


def move_to_frame(world: World, frame: Frame) -> None:
    """Move bodies and arm to a frame of a recording, with its colours; bodies that are not in both are left alone."""
    for name, body in world.bodies.items():
        poses = {link: frame.poses[f"{name}/{link}"] for link in body.links if f"{name}/{link}" in frame.poses}
        if body.links[0] not in poses:
            continue
        body.set_pose(poses[body.links[0]])
        for joint, position in joint_positions(body, poses).items():
            body.joints[joint].set_state(position, 0.0)
        painted = {body.model.links[link]: frame.colors.get(f"{name}/{link}") for link in body.links}
        body.set_colors({index: color for index, color in painted.items() if color is not None})
    world.robot.reset_configuration(frame.arm, frame.fingers)


def joint_positions(body: Body, poses: Mapping[str, FloatArray]) -> dict[str, float]:
    """Return name -> position of the joints of a body, from the poses (7,) of its links by name."""
    joints = [joint for joint in read_urdf(body.model.urdf).joints if joint.name in body.joints]
    known = [joint for joint in joints if joint.parent in poses and joint.child in poses]
    return {joint.name: _position(joint, poses[joint.parent], poses[joint.child], body.model.scale) for joint in known}


def _position(joint: UrdfJoint, parent: FloatArray, child: FloatArray, scale: float) -> float:
    moved = relative(child, compose(parent, se3_to_pose(to_placement(joint.origin, scale))))
    axis = np.array(joint.axis) / max(float(np.linalg.norm(joint.axis)), 1e-12)
    if joint.kind == "prismatic":
        return float(axis @ moved[:3])
    return math.remainder(2.0 * math.atan2(float(axis @ moved[3:6]), float(moved[6])), 2.0 * math.pi)


def _without_places(scene: SceneSpec) -> SceneSpec:
    at_origin = {"pose": tuple(IDENTITY)}
    tables: dict[str, object] = {
        name: tuple(item.model_copy(update=at_origin) for item in getattr(scene, name)) for name in _POSED
    }
    joints = tuple(joint.model_copy(update={"position": 0.0}) for joint in scene.joint)
    return scene.model_copy(update={**tables, "joint": joints, "placement": PlacementSpec(), "deviation": (), "file": ""})


def _depth(scene: SceneSpec, name: str) -> int:
    """Return the number of ancestors of an item."""
    parents = {item.name: item.parent.partition("/")[0] for item in scene.posed()}
    depth = 0
    while name in parents:
        name, depth = parents[name], depth + 1
    return depth


def _pose_of(world: World, name: str) -> FloatArray:
    """Return the pose (7,) of a body, a link, a frame, the root or the world."""
    if name == "world":
        return IDENTITY.copy()
    if name == ROOT or name in world.frames:
        return world.frame(name).pose
    body, _, link = name.partition("/")
    return world.body(body).link_pose(link) if link else world.body(body).pose


# Tasks without code -----------------------------------------------------------------------------------------------------------


NO_CODE = "No instruction: the code of this task was not run."


class SceneOnly(Task):
    """A task that only has the scene: one variation, no conditions."""

    def init_task(self) -> None:
        """Register nothing."""

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentence that says that the code was not run."""
        return [NO_CODE]

    def success(self) -> tuple[bool, bool]:
        """Return that the goal is not reached and the episode not over."""
        return False, False


def scene_only(scene: Path) -> type[Task]:
    """Return a task class with the name and the scene of a scene file, without the code of the task."""

    def scene_file(cls: type[Task]) -> Path:
        return scene

    return type(camel_case(scene.stem), (SceneOnly,), {"__doc__": SceneOnly.__doc__, "scene_file": classmethod(scene_file)})
