"""Key frames: the few frames of a demonstration that key-frame agents learn to reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.errors import DatasetError, DemoError
from rlbench_pin.observation import DISTURBANCES, PHASE, Observation
from rlbench_pin.values import as_number, as_record, as_whole


def key_frames(demo: Sequence[Observation], *, max_speed: float = 0.1, frames_between_stops: int = 4) -> list[int]:
    """Return the indices of the key frames of a demonstration, by the rule of published agents.

    A frame is a key frame when it is not the first and

    * `gripper_open` differs from the frame before, or
    * it is the last frame, or
    * the arm has stopped there. Frame i is a stop when no joint is faster than `max_speed`, `gripper_open` is the same in the
      frames i - 2 to i + 1, it is not one of the last two frames, and none of the `frames_between_stops` frames before is a stop.

    If the last two key frames are consecutive, the earlier one is left out. Frames of a disturbance are not key frames, because
    agents should not learn to reach them.

    As in the published programs, frame -1 is the last frame. The first frame is never a key frame, but it can be a stop and then
    excludes the frames after it.

    Args:
        demo: Observations with `joint_velocities` and `gripper_open`.
        max_speed: Largest speed of a stationary joint [rad/s].
        frames_between_stops: Number of frames after a stop that cannot be stops.

    Raises:
        DatasetError: An observation lacks one of the two fields.
    """
    max_speed = as_number(max_speed, "max_speed", least=0.0)
    frames_between_stops = as_whole(frames_between_stops, "frames_between_stops", least=0)
    demo = as_record(demo, Sequence, "demo")  # type: ignore[type-abstract]
    for observation in demo:
        as_record(observation, Observation, "An observation of the demo")
    resting = [_speed(demo, i) <= max_speed for i in range(len(demo))]
    opening = [_opening(demo, i) for i in range(len(demo))]
    stops = _stops(resting, opening, frames_between_stops)
    last = len(demo) - 1
    found = [i for i in range(1, len(demo)) if opening[i] != opening[i - 1] or i == last or i in stops]
    found = [i for i in found if demo[i].misc.get(PHASE) not in DISTURBANCES]
    if len(found) > 1 and found[-2] == last - 1:
        del found[-2]
    return found


def key_frame_actions(demo: Sequence[Observation]) -> list[np.ndarray]:
    """Return one action for each key frame of a demonstration: tip pose, gripper, and whether collisions are ignored, shape (9,).

    Args:
        demo: A demonstration with `gripper_pose` and `ignore_collisions`.

    Raises:
        DemoError: A frame lacks one of the two.
    """
    actions = []
    for index in key_frames(demo):
        frame = demo[index]
        if frame.gripper_pose is None or frame.gripper_open is None or frame.ignore_collisions is None:
            raise DemoError(
                f"Frame {index} of the demonstration lacks `gripper_pose`, `gripper_open` or `ignore_collisions`. Record it live."
            )
        actions.append(np.concatenate([frame.gripper_pose, [frame.gripper_open, float(frame.ignore_collisions)]]))
    return actions


def _stops(resting: Sequence[bool], opening: Sequence[float], frames_between: int) -> set[int]:
    stops: set[int] = set()
    free_from = 0
    for i in range(len(resting) - 2):
        unchanged = opening[i - 2] == opening[i - 1] == opening[i] == opening[i + 1]  # indices below 0 count from the end
        if i >= free_from and resting[i] and unchanged:
            stops.add(i)
            free_from = i + frames_between + 1
    return stops


def _speed(demo: Sequence[Observation], index: int) -> float:
    velocities = demo[index].joint_velocities
    if velocities is None:
        raise _missing("joint_velocities", index)
    return float(np.abs(velocities).max())


def _opening(demo: Sequence[Observation], index: int) -> float:
    opening = demo[index].gripper_open
    if opening is None:
        raise _missing("gripper_open", index)
    return opening


def _missing(field: str, index: int) -> DatasetError:
    return DatasetError(
        f"Frame {index} has no {field}, so its key frames are unknown. Record or read it with `ObservationConfig.{field} = True`."
    )
