"""Recordings of simulation, one frame per control tick: episodes, demonstrations, and replayed stored demonstrations."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import TracebackType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.datasets import key_frames
from rlbench_pin.environment.demos import DemoPlayer
from rlbench_pin.environment.runtime import Listener, Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import (
    DatasetError,
    DemoError,
    InvalidActionError,
    NoIkSolution,
    PlanningError,
    ResetError,
    RlbenchPinError,
    WaypointError,
)
from rlbench_pin.observation import CAMERAS, Demo
from rlbench_pin.planning.plan import Plan
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.sim import Request, World
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import (
    Aligned,
    AllOf,
    AnyOf,
    Condition,
    Detected,
    DetectedSeveral,
    FollowPath,
    Grasped,
    HasColor,
    InOrder,
    JointMoved,
    ListEmpty,
    NothingGrasped,
    Task,
    TipInside,
    Waypoint,
)

FileKind = Literal["scene", "task"]
"""Kind of a file of a task: `<task>.toml` or `<task>.py`."""


@dataclass(frozen=True)
class Problem:
    """A problem in one of the two files of a task."""

    file: FileKind
    """The file."""
    line: int | None
    """Line, from 1; None for the whole file."""
    message: str
    """The problem, the allowed values, and the next step."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The world at the end of one control tick."""

    time: float
    """Time since the reset [s]."""
    poses: Mapping[str, FloatArray]
    """`<body>/<link>` -> pose (7,) of the link frame in the world, for all links of all bodies of the scene."""
    arm: FloatArray
    """Joint positions of the arm [rad], shape (n,)."""
    fingers: FloatArray
    """Joint positions of the fingers [m]."""
    velocities: FloatArray
    """Joint velocities of the arm [rad/s], shape (n,)."""
    torques: FloatArray
    """Joint torques of the arm [Nm], shape (n,)."""
    conditions_met: tuple[bool, ...]
    """Whether each success condition holds, in their order."""
    success: bool
    """Whether all success conditions hold."""
    colors: Mapping[str, tuple[float, float, float, float]] = field(default_factory=dict)
    """`<body>/<link>` -> RGBA from 0 to 1 of links whose colour differs from their model file."""


@dataclass(frozen=True, eq=False)
class Failure:
    """Failure of a reset, a demonstration or a waypoint."""

    cause: str
    """Cause as text, with the next step."""
    waypoint: str = ""
    """Name of the waypoint that was approached; empty if there was none."""
    pairs: tuple[tuple[str, str], ...] = ()
    """Pairs of links in contact, by name."""
    nearest: FloatArray | None = None
    """The reachable tip pose (7,) nearest to the target; None if unknown."""
    problem: Problem | None = None
    """The line of the task file that raised the error; None if other code did."""


@dataclass(frozen=True)
class Segment:
    """The motion of a demonstration to one waypoint."""

    waypoint: str
    """Name of the waypoint."""
    begins: int
    """Index of its first frame."""
    method: str
    """Planning method."""


@dataclass(frozen=True, eq=False)
class Recording:
    """Recording of a demonstration or another part of a simulation."""

    frames: tuple[Frame, ...]
    """One frame for each control tick, with the reset first."""
    conditions: tuple[str, ...]
    """The success conditions as text, in the order of `Frame.conditions_met`."""
    instruction: str = ""
    """The first instruction of the episode."""
    segments: tuple[Segment, ...] = ()
    """The segments, in order."""
    failure: Failure | None = None
    """The failure; None after success."""
    added: tuple[BodySpec, ...] = ()
    """Bodies that were added to the world; a frame contains them while its `poses` has their names."""


def evaluate_conditions(conditions: Sequence[Condition]) -> tuple[bool, ...]:
    """Return whether each condition holds now; the state of the conditions does not change."""
    before = [condition.state() for condition in conditions]
    try:
        return tuple(bool(condition.met()) for condition in conditions)
    finally:
        for condition, state in zip(conditions, before, strict=True):
            condition.set_state(state)


def success_texts(task: Task) -> tuple[str, ...]:
    """Return the success conditions of a task as text, in order."""
    return tuple(condition_text(condition) for condition in task.get_success_conditions())


def missing_conditions(task: Task) -> tuple[str, ...]:
    """Return the success conditions that do not hold now, as text."""
    met = evaluate_conditions(task.get_success_conditions())
    return tuple(text for text, holds in zip(success_texts(task), met, strict=True) if not holds)


def condition_text(condition: Condition) -> str:
    """Return a condition as a short text; for a condition class of a task file, the name of the class."""
    return next((text(condition) for kind, text in _TEXTS if isinstance(condition, kind)), type(condition).__name__)


def _combined(words: str) -> Callable[[AllOf | AnyOf | InOrder], str]:
    return lambda condition: f"{words} ({'; '.join(condition_text(member) for member in condition.members)})"


_TEXTS: tuple[tuple[type[Condition], Callable[..., str]], ...] = (
    (Detected, lambda c: f"{c.element.name} {'outside' if c.negated else 'inside'} {c.sensor.name}"),
    (
        DetectedSeveral,
        lambda c: f"at least {c.count} of {', '.join(element.name for element in c.elements)} inside {c.sensor.name}",
    ),
    (
        Aligned,
        lambda c: f"{', '.join(element.name for element in c.elements)} turned like {c.reference.name} within {c.angle:.3g} rad",
    ),
    (TipInside, lambda c: f"tip inside {c.sensor.name}"),
    (FollowPath, lambda c: f"{c.body.name} visits {len(c.points)} points in order"),
    (Grasped, lambda c: f"{c.body.name} grasped"),
    (NothingGrasped, lambda c: "nothing grasped"),
    (HasColor, lambda c: f"{c.body.name} has colour {', '.join(f'{part:.3g}' for part in c.rgb)}"),
    (JointMoved, lambda c: f"{c.joint.name} moved by more than {c.distance:.4g}"),
    (ListEmpty, lambda c: "list of the task empty"),
    (AllOf, _combined("all of")),
    (AnyOf, _combined("any of")),
    (InOrder, _combined("in order")),
)


_NUMBER = re.compile(r"-?\d+(\.\d+)?")


def failure_of(error: RlbenchPinError, waypoint: str, task: Task) -> Failure:
    """Return the record of an error of a demonstration, with the evidence of the planning errors that caused it.

    Args:
        error: Error that ended the demonstration.
        waypoint: Name of the waypoint that was approached; empty if there was none.
        task: The running task; a DemoError lists the conditions that do not hold.
    """
    cause, missing = str(error), missing_conditions(task) if isinstance(error, DemoError) else ()
    if isinstance(error, ResetError):  # causes that differ only in numbers are counted together
        groups: dict[str, list[str]] = {}
        for text in error.causes:
            groups.setdefault(_NUMBER.sub("#", text), []).append(text)
        causes = "; ".join(f"{len(alike)} x {alike[0]}" for alike in groups.values())
        cause = f"No layout was found in {len(error.causes)} attempts: {causes}"
    cause += f" Conditions not met: {'; '.join(missing)}." if missing else ""
    planning = [link for link in _chain(error) if isinstance(link, PlanningError)]
    pairs = next((found for link in planning if (found := getattr(link, "pairs", ()))), ())
    poses = [link.nearest for link in planning if isinstance(link, NoIkSolution) and link.nearest is not None]
    nearest = np.array(poses[0], dtype=float) if poses else None
    return Failure(cause, waypoint, tuple((str(first), str(second)) for first, second in pairs), nearest)


def _chain(error: BaseException) -> Iterator[BaseException]:
    """Yield an error, its cause, the cause of the cause, and so on."""
    link: BaseException | None = error
    while link is not None:
        yield link
        link = link.__cause__ or link.__context__


OnFrame = Callable[[Frame], None]
"""Function that is called with each recorded frame; an exception ends the simulation."""
OnSegment = Callable[[Segment], None]
"""Function that is called before each segment."""


class FrameRecorder(Listener):
    """Records the world at the start of a `with` block and after each control tick in it, without an effect on the simulation.

    It does not change the state of conditions: the caller evaluates the task in each tick, as actions and demonstrations do.

    Args:
        runtime: The running task.
        on_frame: Function that is called with each frame.
        on_segment: Function that is called with each segment of a demonstration.

    Attributes:
        frames: The frames so far.
        segments: The segments of a demonstration so far.
        added: Bodies that were added to the world so far, by name.
    """

    def __init__(self, runtime: Runtime, on_frame: OnFrame | None = None, on_segment: OnSegment | None = None) -> None:
        self._runtime, self._on_frame, self._on_segment = runtime, on_frame, on_segment
        self._began = runtime.world.time
        self.frames: list[Frame] = []
        self.segments: list[Segment] = []
        self.added: dict[str, BodySpec] = {}
        self._listening = runtime.listening(self)

    def __enter__(self) -> FrameRecorder:
        self._listening.__enter__()
        self._runtime.register_step_callback(self._keep)
        self._began = self._runtime.world.time
        self._keep()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self._runtime.remove_step_callback(self._keep)
        self._listening.__exit__(kind, error, traceback)

    def frame(self) -> Frame:
        """Return a frame of the current world, without storing it."""
        runtime, robot = self._runtime, self._runtime.robot
        met = evaluate_conditions(runtime.task.get_success_conditions())
        return Frame(
            time=runtime.world.time - self._began,
            poses={f"{name}/{link}": body.link_pose(link) for name, body in runtime.world.bodies.items() for link in body.links},
            arm=robot.joint_positions,
            fingers=robot.fingers,
            velocities=robot.joint_velocities,
            torques=np.array(robot.joint_torques),
            conditions_met=met,
            success=bool(met) and all(met),
            colors=_painted_links(runtime.world),
        )

    def on_segment(self, waypoint: Waypoint, plan: Plan) -> None:
        """Add a segment of a demonstration."""
        self.segments.append(Segment(waypoint.frame.name, len(self.frames) - 1, plan.report.method))
        if self._on_segment is not None:
            self._on_segment(self.segments[-1])

    def recording(self, failure: Failure | None = None) -> Recording:
        """Return the recording so far, with a failure if there is one."""
        texts, instruction = success_texts(self._runtime.task), next(iter(self._runtime.instructions), "")
        return Recording(tuple(self.frames), texts, instruction, tuple(self.segments), failure, tuple(self.added.values()))

    def _keep(self) -> None:
        """Store a frame of the current world, and call `on_frame`."""
        frame = self.frame()
        self.added.update(self._runtime.world.spawned)
        self.frames.append(frame)
        if self._on_frame is not None:
            self._on_frame(frame)


def _painted_links(world: World) -> dict[str, tuple[float, float, float, float]]:
    """Return `<body>/<link>` -> RGBA from 0 to 1 of the links whose colour differs from their URDF file."""
    return {
        f"{name}/{link}": colors[index]
        for name, body in world.bodies.items()
        if (colors := body.colors)
        for link, index in body.model.links.items()
        if index in colors
    }


def record_reset(task_environment: TaskEnvironment, seed: int, variation: int) -> Recording:
    """Reset a task and return a recording with the frame after it, and with the failure if no start was found.

    Args:
        task_environment: The task.
        seed: Seed of the episode.
        variation: Its variation.
    """
    runtime, failure = task_environment.runtime, None
    try:
        task_environment.reset(seed=seed, variation=variation)
    except ResetError as error:
        failure = failure_of(error, "", runtime.task)
    with FrameRecorder(runtime) as recorder:
        return recorder.recording(failure)


def record_demonstration(
    task_environment: TaskEnvironment,
    seed: int,
    variation: int,
    on_frame: OnFrame | None = None,
    on_segment: OnSegment | None = None,
) -> Recording:
    """Reset a task, execute its demonstration once and return the recording, with the failure if there is one.

    Args:
        task_environment: The task.
        seed: Seed of the episode.
        variation: Its variation.
        on_frame: Function that is called with each frame, the reset first; its errors end the demonstration and are passed on.
        on_segment: Function that is called before each segment.
    """
    runtime, start = task_environment.runtime, record_reset(task_environment, seed, variation)
    if start.failure is not None:
        return start
    player = DemoPlayer(runtime, record=False)
    with FrameRecorder(runtime, on_frame, on_segment) as recorder:
        try:
            player.play()
        except (PlanningError, WaypointError, DemoError) as error:
            waypoint = "" if player.waypoint is None else player.waypoint.frame.name
            return recorder.recording(failure_of(error, waypoint, runtime.task))
        return recorder.recording()


def recording_of_demo(task_environment: TaskEnvironment, demo: Demo, on_frame: OnFrame | None = None) -> Recording:
    """Restore the start of a stored demonstration, replay it, and return the recording.

    The replay uses the recorded actions, or without them the recorded joint positions and gripper openings. Motions of the
    gripper have one frame per control tick, for any number of stored frames. A segment is a motion between two key frames.

    Args:
        task_environment: Environment of the task, whose actions are absolute joint positions and an opening, as in
            `make_environment`.
        demo: The demonstration; it needs no images.
        on_frame: Function that is called with each frame, the start first; its errors end the replay and are passed on.

    Raises:
        TaskEnvironmentError: The demonstration is of another task, or its start state cannot be restored.
        DemoError: The demonstration contains neither actions nor joint positions.
    """
    actions = list(_actions(demo))
    instructions, _ = task_environment.reset_to_demo(demo)
    places, reached, refused = [0], False, ""
    with FrameRecorder(task_environment.runtime, on_frame) as recorder:
        for action in actions:
            try:
                reached = bool(task_environment.step(action)[1]) or reached
            except InvalidActionError as error:
                refused = f" An action was refused: {error}"
                break
            places.append(len(recorder.frames) - 1)
        failure = None if reached else _missed(demo, recorder, places, refused, task_environment)
        played = recorder.recording(failure)
    sentence = next(iter(demo.instructions or instructions), played.instruction)
    return Recording(played.frames, played.conditions, sentence, _segments(demo, places), failure, played.added)


def _actions(demo: Demo) -> Iterator[FloatArray]:
    """Yield joint positions [rad] and gripper opening for each frame but the first."""
    for number, observation in enumerate(demo[1:], start=1):
        if "joint_position_action" in observation.misc:
            yield np.asarray(observation.misc["joint_position_action"], dtype=float)
        elif observation.joint_positions is not None and observation.gripper_open is not None:
            yield np.append(observation.joint_positions, observation.gripper_open)
        else:
            raise DemoError(
                f"Frame {number} of the demonstration contains neither `joint_position_action` nor `joint_positions` with "
                "`gripper_open`, so it cannot be replayed. Record it live."
            )


def _segments(demo: Demo, places: list[int]) -> tuple[Segment, ...]:
    """Return the segments between key frames; none if velocities or gripper openings are not stored.

    Args:
        demo: The demonstration.
        places: Index of the recorded frame for each replayed frame of the demonstration.
    """
    try:
        ends = [index for index in key_frames(demo) if index < len(places)]
    except DatasetError:
        return ()
    begins = [0, *ends[:-1]]
    return tuple(Segment(f"key frame {number}", places[begin], "") for number, begin in enumerate(begins[: len(ends)], start=1))


def _missed(demo: Demo, recorder: FrameRecorder, places: list[int], refused: str, task_environment: TaskEnvironment) -> Failure:
    stored = [observation.joint_positions for observation in demo[: len(places)]]
    apart = [
        float(np.abs(recorder.frames[place].arm - q).max()) for place, q in zip(places, stored, strict=True) if q is not None
    ]
    by = f" Its joints come as far as {max(apart):.3g} rad from the stored ones." if apart else ""
    missing = "; ".join(missing_conditions(task_environment.task))
    return Failure(
        f"The replayed demonstration does not reach its goal.{by}{refused} Conditions not met: {missing}. "
        "It was recorded with another version of the task or of a library. Record a new one with `rlbench-pin record`."
    )


def camera_images(runtime: Runtime, size: int = 160) -> dict[str, NDArray[np.uint8]]:
    """Return the current image (size, size, 3) of each of the five cameras, with shadows as in the observation settings."""
    config = runtime.observer.config
    runtime.world.renderer.lighting = config.lighting
    requests = [
        Request(
            replace(runtime.cameras[name].view(), size=(size, size)),
            depth=False,
            mask=False,
            shadows=config.camera(name).draws_shadows,
        )
        for name in CAMERAS
    ]
    images = runtime.world.renderer.render_all(requests)
    return {name: image.rgb for name, image in zip(CAMERAS, images, strict=True) if image.rgb is not None}
