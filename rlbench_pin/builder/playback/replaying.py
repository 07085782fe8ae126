"""Stored demonstrations played again in a world, and recorded frame by frame on the way."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rlbench_pin.builder.contracts import Failure, Leg, Recording
from rlbench_pin.builder.playback.failures import missing_conditions
from rlbench_pin.builder.playback.recorder import FrameRecorder, OnFrame
from rlbench_pin.datasets import key_frames
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DatasetError, DemoError, InvalidActionError
from rlbench_pin.observation import Demo
from rlbench_pin.spatial import FloatArray


def recording_of_demo(task_environment: TaskEnvironment, demo: Demo, on_frame: OnFrame | None = None) -> Recording:
    """Restore the start of a stored demonstration, play what the arm did again, and return every frame.

    It plays the recorded actions, and where there are none the recorded joint positions and hand. Motions of the hand take as
    many frames as they take ticks, however many of them were stored. Its legs lead from key frame to key frame.

    Args:
        task_environment: Its task, with absolute joint positions and an opening as actions, as `make_environment` has them.
        demo: The demonstration; pictures are not needed.
        on_frame: Called with every frame, the start first; an error that it raises ends the motion and is passed on.

    Raises:
        TaskEnvironmentError: It is of another task, or its start cannot be restored.
        DemoError: It holds neither actions nor joint positions.
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
    return Recording(played.frames, played.conditions, sentence, _legs(demo, places), failure, played.added)


def _actions(demo: Demo) -> Iterator[FloatArray]:
    """Yield joint positions [rad] and opening of the hand for each frame but the first."""
    for number, observation in enumerate(demo[1:], start=1):
        if "joint_position_action" in observation.misc:
            yield np.asarray(observation.misc["joint_position_action"], dtype=float)
        elif observation.joint_positions is not None and observation.gripper_open is not None:
            yield np.append(observation.joint_positions, observation.gripper_open)
        else:
            raise DemoError(
                f"Frame {number} of the demonstration holds neither `joint_position_action` nor `joint_positions` with "
                "`gripper_open`, so it cannot be played again. Record it live."
            )


def _legs(demo: Demo, places: list[int]) -> tuple[Leg, ...]:
    """Return the ways to the key frames, as far as they were played; none where velocities or the hand are not stored."""
    try:
        ends = [index for index in key_frames(demo) if index < len(places)]
    except DatasetError:
        return ()
    begins = [0, *ends[:-1]]
    return tuple(Leg(f"key frame {number}", places[begin], "") for number, begin in enumerate(begins[: len(ends)], start=1))


def _missed(demo: Demo, recorder: FrameRecorder, places: list[int], refused: str, task_environment: TaskEnvironment) -> Failure:
    stored = [observation.joint_positions for observation in demo[: len(places)]]
    apart = [
        float(np.abs(recorder.frames[place].arm - q).max()) for place, q in zip(places, stored, strict=True) if q is not None
    ]
    by = f" Its joints come as far as {max(apart):.3g} rad from the stored ones." if apart else ""
    missing = "; ".join(missing_conditions(task_environment.task))
    return Failure(
        f"Played again, the stored demonstration does not reach its goal.{by}{refused} What does not hold: {missing}. "
        "It was recorded with another version of the task or of a library; `rlbench-pin record` makes a new one."
    )
