"""Simulation recorded frame by frame: where every link is, what the arm does, which success conditions hold."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType

import numpy as np

from rlbench_pin.builder.contracts import Failure, Frame, Leg, Recording
from rlbench_pin.builder.playback.conditions import looked_at, success_texts
from rlbench_pin.builder.playback.failures import failure_of
from rlbench_pin.environment.demos import DemoPlayer
from rlbench_pin.environment.runtime import Listener, Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, PlanningError, ResetError, WaypointError
from rlbench_pin.planning.plan import Plan
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint

OnFrame = Callable[[Frame], None]
"""Called with every frame as it is made; what it raises ends the simulation."""
OnLeg = Callable[[Leg], None]
"""Called when the motion to a waypoint is about to begin."""


def link_poses(world: World) -> dict[str, FloatArray]:
    """Return `<body>/<link>` -> pose (7,) of every link of every body of a world, in the order of the bodies."""
    return {f"{name}/{link}": body.link_pose(link) for name, body in world.bodies.items() for link in body.links}


def painted_links(world: World) -> dict[str, tuple[float, float, float, float]]:
    """Return `<body>/<link>` -> rgba of every link that was painted since its file was read."""
    painted = {name: (body, body.colors) for name, body in world.bodies.items()}
    return {
        f"{name}/{link}": colors[index]
        for name, (body, colors) in painted.items()
        for link, index in (body.model.links.items() if colors else ())
        if index in colors
    }


class FrameRecorder(Listener):
    """Makes a frame of the world as it is, and one after each control tick of a block; changes nothing that it looks at.

    Conditions that keep count are asked with what they remember: it is for whoever runs the episode to ask the task every tick,
    as actions and demonstrations do.

    Args:
        runtime: The running task.
        on_frame: Called with every frame.
        on_leg: Called with every leg of a demonstration.

    Attributes:
        frames: The frames so far.
        legs: The legs of a demonstration so far.
        added: Bodies that were added to the world so far, by name.
    """

    def __init__(self, runtime: Runtime, on_frame: OnFrame | None = None, on_leg: OnLeg | None = None) -> None:
        self._runtime, self._on_frame, self._tell_leg = runtime, on_frame, on_leg
        self._began = runtime.world.time
        self.frames: list[Frame] = []
        self.legs: list[Leg] = []
        self.added: dict[str, BodySpec] = {}
        self._listening = runtime.listening(self)

    def __enter__(self) -> FrameRecorder:
        self._listening.__enter__()
        self._runtime.register_step_callback(self._keep)
        self.restart()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self._runtime.remove_step_callback(self._keep)
        self._listening.__exit__(kind, error, traceback)

    def restart(self) -> None:
        """Forget all frames and begin at time 0 with the world as it is, as after a reset."""
        self.frames.clear()
        self.legs.clear()
        self.added.clear()
        self._began = self._runtime.world.time
        self._keep()

    def frame(self) -> Frame:
        """Return the world as it is now, without keeping it."""
        runtime, robot = self._runtime, self._runtime.robot
        held = looked_at(runtime.task.get_success_conditions())
        return Frame(
            time=runtime.world.time - self._began,
            poses=link_poses(runtime.world),
            arm=robot.joint_positions,
            fingers=robot.fingers,
            velocities=robot.joint_velocities,
            torques=np.array(robot.joint_torques),
            held=held,
            success=bool(held) and all(held),
            colors=painted_links(runtime.world),
        )

    def on_segment(self, waypoint: Waypoint, plan: Plan) -> None:
        """Note where a leg of a demonstration begins."""
        leg = Leg(waypoint.frame.name, len(self.frames) - 1, plan.report.method)
        self.legs.append(leg)
        if self._tell_leg is not None:
            self._tell_leg(leg)

    def recording(self, failure: Failure | None = None) -> Recording:
        """Return what was recorded so far."""
        task = self._runtime.task
        instruction = next(iter(self._runtime.instructions), "")
        legs, added = tuple(self.legs), tuple(self.added.values())
        return Recording(tuple(self.frames), success_texts(task), instruction, legs, failure, added)

    def _keep(self) -> None:
        frame = self.frame()
        self.added.update(self._runtime.world.spawned)
        self.frames.append(frame)
        if self._on_frame is not None:
            self._on_frame(frame)


def record_reset(task_environment: TaskEnvironment, seed: int, variation: int) -> Recording:
    """Reset a task and return the one frame that there is then, with the reason where no start is found.

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
    on_leg: OnLeg | None = None,
) -> Recording:
    """Reset a task, play its demonstration once and return every frame, with the reason where it fails.

    Args:
        task_environment: The task.
        seed: Seed of the episode.
        variation: Its variation.
        on_frame: Called with every frame, the reset first; an error that it raises ends the demonstration and is passed on.
        on_leg: Called with every leg as it begins.
    """
    runtime, start = task_environment.runtime, record_reset(task_environment, seed, variation)
    if start.failure is not None:
        return start
    player = DemoPlayer(runtime, record=False)
    with FrameRecorder(runtime, on_frame, on_leg) as recorder:
        try:
            player.play()
        except (PlanningError, WaypointError, DemoError) as error:
            waypoint = "" if player.waypoint is None else player.waypoint.frame.name
            return recorder.recording(failure_of(error, waypoint, runtime.task))
        return recorder.recording()
