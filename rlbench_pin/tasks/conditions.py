"""The conditions that a task may register; they are evaluated at the present instant."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence, Sized
from typing import TYPE_CHECKING, cast

import numpy as np

from rlbench_pin.errors import InvalidValue, TaskError
from rlbench_pin.spatial import FloatArray, pose_to_matrix, pose_to_se3, relative
from rlbench_pin.tasks.arguments import (
    ARM,
    BODY,
    BODY_OR_FRAME,
    COLORED_BODY,
    FRAME,
    GRIPPER,
    JOINT,
    POSED,
    SENSOR,
    as_object,
    as_objects,
    has_extent,
)
from rlbench_pin.values import as_flag, as_number, as_record, as_rows, as_several, as_vector, as_whole

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, Frame, ObjectJoint, Sensor, SimGripper, SimRobot

__all__ = [
    "Aligned",
    "AllOf",
    "AnyOf",
    "Condition",
    "Detected",
    "DetectedSeveral",
    "FollowPath",
    "Grasped",
    "HasColor",
    "InOrder",
    "JointMoved",
    "ListEmpty",
    "NothingGrasped",
    "TipInside",
]


class Condition(ABC):
    """A condition that is true or false at the present instant.

    Conditions with a memory override `reset`, `state` and `set_state`.
    """

    @abstractmethod
    def met(self) -> bool:
        """Return whether the condition holds now."""

    def reset(self) -> None:  # noqa: B027
        """Reset the memory; called after the world of a new episode has settled."""

    def state(self) -> object:
        """Return the memory as an immutable value."""
        return None

    def set_state(self, state: object) -> None:  # noqa: B027
        """Restore a memory that `state()` returned."""


class _Combined(Condition):
    """A combination of members, to which it passes reset and state.

    Args:
        members: The conditions, at least one.
    """

    def __init__(self, members: Sequence[Condition]) -> None:
        what = f"members of {type(self).__name__}"
        for number, member in enumerate(members := as_several(members, what)):
            as_record(member, Condition, f"entry {number} of {what}")  # type: ignore[type-abstract]
        self.members = tuple(members)
        if not self.members:
            raise TaskError(f"{type(self).__name__} needs at least one condition. Pass some.")

    def _asked(self) -> list[bool]:
        """Evaluate all members, so that members with a memory see each instant."""
        return [member.met() for member in self.members]

    def reset(self) -> None:
        """Reset all members."""
        for member in self.members:
            member.reset()

    def state(self) -> tuple[object, ...]:
        """Return the states of the members."""
        return tuple(member.state() for member in self.members)

    def set_state(self, state: object) -> None:
        """Set the states of the members."""
        for member, value in zip(self.members, cast(tuple[object, ...], state), strict=True):
            member.set_state(value)


class AllOf(_Combined):
    """Holds while all members hold at the same instant."""

    def met(self) -> bool:
        """Return whether all members hold now; all are evaluated."""
        return all(self._asked())


class AnyOf(_Combined):
    """Holds while at least one member holds."""

    def met(self) -> bool:
        """Return whether a member holds now; all are evaluated."""
        return any(self._asked())


class InOrder(_Combined):
    """Holds after all members have held in order, and then until reset.

    Each evaluation passes the consecutive members that hold now, and stops at the first that does not. Passed members stay
    passed, so the members need not hold at the same time.

    Args:
        members: The conditions in the order in which they have to hold, at least one.
    """

    def __init__(self, members: Sequence[Condition]) -> None:
        super().__init__(members)
        self.passed = 0

    def met(self) -> bool:
        """Pass the members that hold now, in order, and return whether all have been passed."""
        while self.passed < len(self.members) and self.members[self.passed].met():
            self.passed += 1
        return self.passed == len(self.members)

    def reset(self) -> None:
        """Restart at the first member."""
        super().reset()
        self.passed = 0

    def state(self) -> tuple[object, ...]:
        """Return the number of passed members, then the states of all."""
        return (self.passed, *super().state())

    def set_state(self, state: object) -> None:
        """Set the number of passed members, and the states of all."""
        passed, *members = cast(tuple[object, ...], state)
        self.passed = cast(int, passed)
        super().set_state(tuple(members))


def is_detected(element: Body | Frame, sensor: Sensor) -> bool:
    """Return whether a part of a body touches the volume, or whether the origin of a frame is in it."""
    return sensor.detects(element.name) if has_extent(element) else sensor.contains(element.position)


class Detected(Condition):
    """Holds while a part of a body touches the volume of a sensor; the origin of a frame must be inside.

    Args:
        element: A body or a frame.
        sensor: The volume.
        negated: Invert the result.
    """

    def __init__(self, element: Body | Frame, sensor: Sensor, negated: bool = False) -> None:
        self.element, self.sensor = as_object(element, BODY_OR_FRAME, "element"), as_object(sensor, SENSOR, "sensor")
        self.negated = as_flag(negated, "negated")

    def met(self) -> bool:
        """Return whether the object is detected now, or not detected if negated."""
        return is_detected(self.element, self.sensor) != self.negated


class DetectedSeveral(Condition):
    """Holds while at least `count` of the objects are detected.

    Args:
        elements: Bodies and frames.
        sensor: The volume.
        count: Minimum number of detected objects, from 1 to all.
    """

    def __init__(self, elements: Sequence[Body | Frame], sensor: Sensor, count: int) -> None:
        self.elements, self.sensor = as_objects(elements, BODY_OR_FRAME, "elements"), as_object(sensor, SENSOR, "sensor")
        self.count = as_whole(count, "count")
        if not 0 < self.count <= len(self.elements):
            raise TaskError(
                f"DetectedSeveral has {len(self.elements)} elements, but count={count}. Choose 1 to {len(self.elements)}."
            )

    def met(self) -> bool:
        """Return whether at least `count` objects are detected now."""
        return sum(is_detected(element, self.sensor) for element in self.elements) >= self.count


class Aligned(Condition):
    """Holds while all objects have the orientation of a reference: roll, pitch and yaw in its frame are each at most `angle`.

    Args:
        elements: Bodies and frames, at least one.
        reference: A body or a frame.
        angle: Largest roll, pitch and yaw, in either direction [rad].
    """

    def __init__(self, elements: Sequence[Body | Frame], reference: Body | Frame, angle: float) -> None:
        self.elements = as_objects(elements, POSED, "elements")
        if not self.elements:
            raise TaskError("Aligned needs at least one element. Pass some.")
        self.reference = as_object(reference, POSED, "reference")
        self.angle = as_number(angle, "angle [rad]", least=0.0)

    def met(self) -> bool:
        """Return whether all objects have the orientation of the reference now."""
        return all(self._largest_angle(element) <= self.angle for element in self.elements)

    def _largest_angle(self, element: Body | Frame) -> float:
        turn = pose_to_matrix(relative(element.pose, self.reference.pose))
        roll, yaw = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
        pitch = np.arctan2(-turn[2, 0], np.hypot(turn[2, 1], turn[2, 2]))
        return float(np.abs([roll, pitch, yaw]).max())


class TipInside(Condition):
    """Holds while the gripper tip point is inside the volume of a sensor.

    Args:
        robot: The arm, `self.robot`.
        sensor: The volume.
    """

    def __init__(self, robot: SimRobot, sensor: Sensor) -> None:
        self.robot, self.sensor = as_object(robot, ARM, "robot"), as_object(sensor, SENSOR, "sensor")

    def met(self) -> bool:
        """Return whether the tip point is inside the volume now."""
        return self.sensor.contains(self.robot.tip_pose()[:3])


MAX_STRIKES = 3


class FollowPath(Condition):
    """Holds after a body has visited all points in order, within half of `tolerance` of each.

    After the start of the path, each evaluation with the body farther than `tolerance` from the next point is a strike.
    A visited point clears the strikes. After `MAX_STRIKES` strikes, the next one sets `lost`.

    Args:
        body: The moving body.
        points: Points of the path, shape (n, 3), [m], in the coordinates of `frame`.
        frame: Frame of the points; None is the world.
        tolerance: Distance of a miss [m].
        start_after_first: Count no strikes before the first visited point.
    """

    def __init__(
        self,
        body: Body,
        points: Sequence[Sequence[float]] | FloatArray,
        frame: Frame | None = None,
        tolerance: float = 0.01,
        start_after_first: bool = True,
    ) -> None:
        self.body = as_object(body, BODY, "body")
        self.frame = None if frame is None else as_object(frame, FRAME, "frame")
        self.points = np.array(as_rows(points, 3, "points"))
        self.tolerance = as_number(tolerance, "tolerance [m]", above=0.0)
        self.start_after_first = as_flag(start_after_first, "start_after_first")
        self.index, self.strikes, self.lost = 0, 0, False

    def met(self) -> bool:
        """Advance over the points at the present position of the body, and return whether all were visited."""
        first = True
        while self.index < len(self.points):
            distance = self._distance()
            if distance > self.tolerance / 2.0:
                if distance > self.tolerance and first:
                    self._miss()
                return False
            self.index, self.strikes, first = self.index + 1, 0, False
        return True

    def _miss(self) -> None:
        if self.index == 0 and self.start_after_first:
            return
        self.lost = self.strikes > MAX_STRIKES
        self.strikes += 1

    def _distance(self) -> float:
        point = self.points[self.index]
        if self.frame is not None:
            point = pose_to_se3(self.frame.pose).act(point)
        return float(np.linalg.norm(self.body.position - point))

    def reset(self) -> None:
        """Restart at the first point, without strikes."""
        self.index, self.strikes, self.lost = 0, 0, False

    def state(self) -> tuple[int, int, bool]:
        """Return the number of visited points, the strikes, and whether the path was lost."""
        return self.index, self.strikes, self.lost

    def set_state(self, state: object) -> None:
        """Set the number of visited points, the strikes, and whether the path was lost."""
        self.index, self.strikes, self.lost = cast(tuple[int, int, bool], state)


class Grasped(Condition):
    """Holds while the gripper holds `body`: it is attached or, with `attach_grasped_objects=False`, both fingers touch it.

    Args:
        gripper: The gripper, `self.gripper`.
        body: A body that may be grasped.
    """

    def __init__(self, gripper: SimGripper, body: Body) -> None:
        self.gripper = as_object(gripper, GRIPPER, "gripper")
        self.body = as_object(body, BODY, "body")

    def met(self) -> bool:
        """Return whether the gripper holds the body now."""
        return self.body.name in self.gripper.held


class NothingGrasped(Condition):
    """Holds while the gripper holds no body, in the sense of `Grasped`.

    Args:
        gripper: The gripper, `self.gripper`.
    """

    def __init__(self, gripper: SimGripper) -> None:
        self.gripper = as_object(gripper, GRIPPER, "gripper")

    def met(self) -> bool:
        """Return whether the gripper holds no body now."""
        return not self.gripper.held


class HasColor(Condition):
    """Holds while the visible colour of `body` is exactly `rgb`.

    Args:
        body: The body.
        rgb: Red, green, blue in 0..1.
    """

    def __init__(self, body: Body, rgb: Sequence[float]) -> None:
        self.body = as_object(body, COLORED_BODY, "body")
        self.rgb = np.array(as_vector(rgb, 3, "rgb", most=1.0))

    def met(self) -> bool:
        """Return whether the body has the colour now."""
        color = self.body.color
        return color is not None and np.allclose(np.asarray(color, dtype=float)[:3], self.rgb, rtol=0.0, atol=1e-9)


class JointMoved(Condition):
    """Holds while a joint is more than `distance` away from its value at the start of the episode, in either direction.

    Args:
        joint: The joint of an object.
        distance: Minimum change of its value, [rad] or [m].
    """

    def __init__(self, joint: ObjectJoint, distance: float) -> None:
        self.joint = as_object(joint, JOINT, "joint")
        self.distance = as_number(distance, "distance [rad] or [m]", least=0.0)
        self.start = float(joint.position)

    def met(self) -> bool:
        """Return whether the joint is far enough from its start now."""
        return abs(float(self.joint.position) - self.start) > self.distance

    def reset(self) -> None:
        """Use the present value of the joint as its start value."""
        self.start = float(self.joint.position)

    def state(self) -> float:
        """Return the value at the start [rad] or [m]."""
        return self.start

    def set_state(self, state: object) -> None:
        """Set the value at the start [rad] or [m]."""
        self.start = cast(float, state)


class ListEmpty(Condition):
    """Holds while a list of the task is empty.

    Args:
        items: The list itself; change it in place.
    """

    def __init__(self, items: Sized) -> None:
        try:
            len(items)
        except Exception as error:  # of whatever it is
            raise InvalidValue("items", items, "has to be a list, or another object with a length") from error
        self.items = items

    def met(self) -> bool:
        """Return whether the list is empty now."""
        return len(self.items) == 0
