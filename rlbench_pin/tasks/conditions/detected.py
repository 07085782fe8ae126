"""Something is inside a sensor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rlbench_pin.errors import TaskError
from rlbench_pin.tasks.conditions.condition import Condition
from rlbench_pin.tasks.conditions.parts import HasTip, Placed, Volume, as_part, as_parts
from rlbench_pin.tasks.things import is_solid
from rlbench_pin.values import as_flag, as_whole

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, Frame, Sensor, SimRobot


def is_detected(thing: Body | Frame, sensor: Sensor) -> bool:
    """Return whether any part of a body touches the volume, or whether the origin of a frame lies in it."""
    return sensor.detects(thing.name) if is_solid(thing) else sensor.contains(thing.position)


def as_sensor(value: Sensor) -> Sensor:
    """Return a sensor, or raise InvalidValue."""
    return as_part(value, Volume, "sensor", "a sensor, such as `self.world.sensor(name)`")


class Detected(Condition):
    """Holds while any part of a body touches the volume of a sensor; for a frame its origin must be inside.

    Args:
        thing: A body or a frame.
        sensor: The volume.
        negated: Invert the answer.
    """

    def __init__(self, thing: Body | Frame, sensor: Sensor, negated: bool = False) -> None:
        self.thing, self.sensor = as_part(thing, Placed, "thing", "a body or a frame"), as_sensor(sensor)
        self.negated = as_flag(negated, "negated")

    def met(self) -> bool:
        """Return whether the thing is detected now, or is not when negated."""
        return is_detected(self.thing, self.sensor) != self.negated


class DetectedSeveral(Condition):
    """Holds while at least `count` of the things are detected; which ones does not matter.

    Args:
        things: Bodies and frames.
        sensor: The volume.
        count: How many, from 1 to all.
    """

    def __init__(self, things: Sequence[Body | Frame], sensor: Sensor, count: int) -> None:
        self.things, self.sensor = as_parts(things, Placed, "things"), as_sensor(sensor)
        self.count = as_whole(count, "count")
        if not 0 < self.count <= len(self.things):
            raise TaskError(f"DetectedSeveral asks for {count} of {len(self.things)} things; choose 1 to {len(self.things)}.")

    def met(self) -> bool:
        """Return whether at least `count` things are detected now."""
        return sum(is_detected(thing, self.sensor) for thing in self.things) >= self.count


class TipInside(Condition):
    """Holds while the gripper tip point is inside the volume of a sensor.

    Args:
        robot: The arm, `self.robot`.
        sensor: The volume.
    """

    def __init__(self, robot: SimRobot, sensor: Sensor) -> None:
        self.robot, self.sensor = as_part(robot, HasTip, "robot", "the arm, `self.robot`"), as_sensor(sensor)

    def met(self) -> bool:
        """Return whether the tip point is inside the volume now."""
        return self.sensor.contains(self.robot.tip_pose()[:3])
