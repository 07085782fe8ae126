"""Conditions under RLBench's names. Every condition is evaluated at the present instant."""

from __future__ import annotations

from collections.abc import Sequence, Sized
from typing import Any

import numpy as np

from pyrep.objects import ProximitySensor
from pyrep.objects.joint import Joint
from pyrep.objects.object import Object
from pyrep.objects.shape import Shape
from pyrep.robots.end_effectors import Gripper
from rlbench_pin import tasks
from rlbench_pin.compat.task_memory import SavedAttributes
from rlbench_pin.spatial import FloatArray

MAX_STRIKES = 3
"""Number of misses that a `FollowCondition` tolerates."""

Answer = tuple[bool, bool]
"""Whether the condition is met, and whether the episode should end."""


class Condition:
    """Base class; subclasses override `condition_met`, and `reset` if they have state."""

    def condition_met(self) -> Answer:
        """Return whether the condition is met now, and whether the episode should end."""
        raise NotImplementedError(f"{type(self).__name__} must define condition_met(self) -> (met, terminate).")

    def reset(self) -> None:
        """Reset the state; called at the start of an episode."""


class NativeCondition(tasks.Condition):
    """Native condition for a condition of a program; its state is saved with the episode."""

    def __init__(self, condition: Condition) -> None:
        self.condition, self._memory = condition, SavedAttributes(condition)

    def met(self) -> bool:
        """Return whether the condition is met now."""
        return bool(self.condition.condition_met()[0])

    def reset(self) -> None:
        """Reset the condition."""
        self.condition.reset()

    def state(self) -> object:
        """Return the state of the condition."""
        return self._memory.state()

    def set_state(self, state: Any) -> None:
        """Restore the state that `state()` returned."""
        self._memory.set_state(state)


class LibraryCondition(Condition):
    """A condition of a library task, with the interface of RLBench."""

    def __init__(self, condition: tasks.Condition) -> None:
        self.condition = condition

    def condition_met(self) -> Answer:
        """Return whether the condition is met now, and False: it does not end the episode."""
        return self.condition.met(), False

    def reset(self) -> None:
        """Reset the condition."""
        self.condition.reset()


def condition_of(native: tasks.Condition) -> Condition:
    """Return a registered condition with the interface of RLBench: that of the program, or a view of a native one."""
    return native.condition if isinstance(native, NativeCondition) else LibraryCondition(native)


class JointCondition(Condition):
    """Met while a joint is more than `position` [rad] or [m] away from its position at the creation of the condition."""

    def __init__(self, joint: Joint, position: float) -> None:
        self.joint, self.position = joint, position
        self.start = float(joint.get_joint_position())

    def condition_met(self) -> Answer:
        """Return whether the joint is far enough from its start now."""
        met = abs(float(self.joint.get_joint_position()) - self.start) > self.position
        return met, met


class DetectedCondition(Condition):
    """Met while a sensor detects an object; with `negated` while it does not."""

    def __init__(self, obj: Object, detector: ProximitySensor, negated: bool = False) -> None:
        self.obj, self.detector, self.negated = obj, detector, negated

    def condition_met(self) -> Answer:
        """Return whether the object is detected now; with `negated` whether it is not."""
        met = bool(self.detector.is_detected(self.obj)) != self.negated
        return met, met


class DetectedSeveralCondition(Condition):
    """Met while a sensor detects at least `number_needed` of the objects."""

    def __init__(self, objects: Sequence[Object], detector: ProximitySensor, number_needed: int) -> None:
        self.objects, self.detector, self.number_needed = objects, detector, number_needed

    def condition_met(self) -> Answer:
        """Return whether enough objects are detected now."""
        met = sum(bool(self.detector.is_detected(obj)) for obj in self.objects) >= self.number_needed
        return met, met


class NothingGrasped(Condition):
    """Met while no object is attached to the gripper."""

    def __init__(self, gripper: Gripper) -> None:
        self.gripper = gripper

    def condition_met(self) -> Answer:
        """Return whether nothing is attached to the gripper now."""
        met = len(self.gripper.get_grasped_objects()) == 0
        return met, met


class GraspedCondition(Condition):
    """Met while an object is attached to the gripper."""

    def __init__(self, gripper: Gripper, object: Object) -> None:
        self.gripper, self.object = gripper, object

    def condition_met(self) -> Answer:
        """Return whether the object is attached to the gripper now."""
        handle = self.object.get_handle()
        met = any(grasped.get_handle() == handle for grasped in self.gripper.get_grasped_objects())
        return met, met


class EmptyCondition(Condition):
    """Met while a list of the task is empty."""

    def __init__(self, container: Sized) -> None:
        self.container = container

    def condition_met(self) -> Answer:
        """Return whether the list is empty now."""
        met = len(self.container) == 0
        return met, met


class FollowCondition(Condition):
    """Met once an object has visited all points in order, each within half of `delta_limit`.

    An evaluation with the object farther than `delta_limit` from the next point is a strike; a visited point
    clears the strikes. After more than `MAX_STRIKES` strikes, the next miss requests the end of the episode.

    Args:
        obj: The object that has to follow the points.
        points: Points (3,) or poses (7,), with x, y, z first [m].
        relative_to: Object in whose frame the points are; None is the world.
        delta_limit: Distance of a miss [m].
        start_after_first: Count no strikes before the first point was visited.
    """

    def __init__(
        self,
        obj: Object,
        points: Sequence[Sequence[float]] | FloatArray,
        relative_to: Object | None = None,
        delta_limit: float = 0.01,
        start_after_first: bool = True,
    ) -> None:
        self.obj, self.relative_to = obj, relative_to
        self.points = np.array([np.asarray(point, dtype=float)[:3] for point in points])
        self.delta_limit, self.start_after_first = delta_limit, start_after_first
        self.index, self.strikes = 0, 0

    def condition_met(self) -> Answer:
        """Mark the points at the object as visited; return whether all are visited, and whether the episode should end."""
        first = True
        while self.index < len(self.points):
            place = np.asarray(self.obj.get_position(relative_to=self.relative_to))
            distance = float(np.linalg.norm(place - self.points[self.index]))
            if distance > self.delta_limit / 2.0:
                misses = distance > self.delta_limit and first and (self.index > 0 or not self.start_after_first)
                lost = misses and self.strikes > MAX_STRIKES
                self.strikes += misses
                return False, lost
            self.index, self.strikes, first = self.index + 1, 0, False
        return True, True

    def reset(self) -> None:
        """Restart with the first point, without strikes."""
        self.index, self.strikes = 0, 0


class ConditionSet(Condition):
    """Met while all conditions are met; with `order_matters`, once they were met one after the other.

    Args:
        conditions: The conditions.
        order_matters: Each condition counts once it was met after the previous ones.
        simultaneously_met: No effect: conditions without order have to be met together.
    """

    def __init__(self, conditions: Sequence[Condition], order_matters: bool = False, simultaneously_met: bool = True) -> None:
        self.conditions, self.order_matters, self.simultaneously_met = list(conditions), order_matters, simultaneously_met
        self.passed = 0

    def condition_met(self) -> Answer:
        """Return whether all conditions are met."""
        if not self.order_matters:
            answers = [condition.condition_met() for condition in self.conditions]
            met = all(answer[0] for answer in answers)
            return met, met or any(answer[1] and not answer[0] for answer in answers)
        while self.passed < len(self.conditions) and self.conditions[self.passed].condition_met()[0]:
            self.passed += 1
        met = self.passed == len(self.conditions)
        return met, met

    def reset(self) -> None:
        """Reset the conditions, and restart with the first."""
        self.passed = 0
        for condition in self.conditions:
            condition.reset()


class OrConditions(Condition):
    """Met while at least one of the conditions is met."""

    def __init__(self, conditions: Sequence[Condition]) -> None:
        self.conditions = list(conditions)

    def condition_met(self) -> Answer:
        """Return whether at least one condition is met now; all are evaluated."""
        answers = [condition.condition_met() for condition in self.conditions]
        met = any(answer[0] for answer in answers)
        return met, met

    def reset(self) -> None:
        """Reset the conditions."""
        for condition in self.conditions:
            condition.reset()


class ColorCondition(Condition):
    """Met while an object has exactly the colour `success_rgb`, each channel from 0 to 1."""

    def __init__(self, shape: Shape, success_rgb: Sequence[float]) -> None:
        self.shape, self.success_rgb = shape, tuple(float(channel) for channel in success_rgb)[:3]

    def condition_met(self) -> Answer:
        """Return whether the object has the colour now."""
        met = bool(np.allclose(np.asarray(self.shape.get_color(), dtype=float)[:3], self.success_rgb, rtol=0.0, atol=1e-6))
        return met, met
