"""Grippers: opening and closing of the fingers, and grasped objects.

Only the gripper of the current robot can be constructed. Programs import one module per gripper; all these names are aliases
of this module.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pyrep.objects import Object, ProximitySensor, Shape
from pyrep.robots import RobotComponent
from rlbench_pin.compat import add_aliases
from rlbench_pin.compat.joints import FingerMotors
from rlbench_pin.compat.objects import Element
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.runtime import Runtime

NEAR = 5e-4
"""Tolerance of a finger position [m]."""


@dataclass(frozen=True)
class Actuation:
    """A motion of the fingers over several steps."""

    amount: float
    """Target opening, from 0 (closed) to 1 (open)."""
    velocity: float
    """Speed of a finger [m/s]."""
    ticks: int
    """Tick counter of the world at its start."""


class Gripper(RobotComponent):
    """The gripper of the current world.

    Args:
        count: Index of the gripper; only 0 is possible, since a world has one gripper.
        name: Name of the gripper.
        joint_names: Names of the finger joints.
    """

    def __init__(self, count: int, name: str, joint_names: Sequence[str]) -> None:
        super().__init__(count, name, joint_names)
        self._actuation: Actuation | None = None

    @property
    def motors(self) -> FingerMotors:
        """The motors of the fingers."""
        return FingerMotors()

    @property
    def _proximity_sensor(self) -> ProximitySensor:
        """The proximity sensor between the fingertips."""
        return ProximitySensor(f"{self.get_name()}_attachProxSensor")

    # Grasping --------------------------------------------------------------------------------------------------------

    def grasp(self, obj: Object) -> bool:
        """Fix an object to the gripper at its current pose, if a part of it is between the fingers.

        Returns:
            Whether this call attached the object: False if it is elsewhere, already attached, or fixed in the world.
        """
        element = obj.element
        if element.kind != "body" or element.name in self._runtime.gripper.grasped:
            return False
        return self._runtime.gripper.reaches_between_fingers(element.name) and self._runtime.gripper.grasp(element.name)

    def release(self) -> None:
        """Release all objects; the fingers do not move."""
        self._runtime.gripper.release()

    def get_grasped_objects(self) -> list[Object]:
        """Return the objects that are fixed to the gripper, in the order of their grasps.

        With `attach_grasped_objects=False`, return the objects between the fingers.
        """
        return [Shape(self.table.handle(Element("body", name))) for name in self._runtime.gripper.held]

    # Fingers ---------------------------------------------------------------------------------------------------------

    def actuate(self, amount: float, velocity: float) -> bool:
        """Move the fingers towards an opening; call it before each simulation step until it returns True.

        Args:
            amount: Target opening, from 0 (closed) to 1 (open).
            velocity: Speed of a finger [m/s].

        Returns:
            Whether the fingers have reached the opening, or are blocked.

        Raises:
            ValueError: `amount` is not between 0 and 1, or `velocity` is not positive and finite.
        """
        if not 0.0 <= amount <= 1.0 or not 0.0 < velocity < float("inf"):
            raise ValueError(
                f"The opening is {amount} and the speed {velocity} m/s; they must be from 0 to 1, and positive and finite."
            )
        runtime, goes_on = self._runtime, self._goes_on(amount, velocity)
        if self._is_at(amount) and not (goes_on and runtime.gripper.moving):
            self._actuation = None
            return True
        if self._actuation is None or not goes_on:
            self.motors.open_to(float(amount), float(velocity))
            self._actuation = Actuation(float(amount), float(velocity), runtime.world.ticks)
            return False
        if runtime.world.ticks > self._actuation.ticks + 1 and not runtime.gripper.moving:
            self._actuation = None
        return self._actuation is None

    def get_open_amount(self) -> list[float]:
        """Return the opening of each finger, from 0 (closed) to 1 (open)."""
        return np.clip(self._runtime.gripper.opening, 0.0, 1.0).tolist()

    # Touch -----------------------------------------------------------------------------------------------------------

    def get_touch_sensor_forces(self) -> list[list[float]]:
        """Return the contact force (3,) [N] on each finger, in the frame of the finger."""
        return self._runtime.robot.touch_forces().reshape(-1, 3).tolist()

    @property
    def _runtime(self) -> Runtime:
        return Simulator.current().runtime

    def _goes_on(self, amount: float, velocity: float) -> bool:
        """Return whether the fingers still execute the motion of an earlier `actuate` with the same arguments."""
        going, control = self._actuation, self._runtime.gripper.control
        if going is None or (going.amount, going.velocity) != (amount, velocity) or going.ticks > self._runtime.world.ticks:
            return False
        return control.speed == velocity and bool(np.allclose(control.target, amount * self._runtime.description.gripper_open))

    def _is_at(self, amount: float) -> bool:
        """Return whether both fingers are at an opening, from 0 (closed) to 1 (open)."""
        goal = amount * self._runtime.description.gripper_open
        return bool((np.abs(self._runtime.robot.fingers - goal) < NEAR).all())


class KnownGripper(Gripper):
    """Base of the gripper classes of PyRep.

    Args:
        count: Index of the gripper; only 0 is possible, since a world has one gripper.
    """

    known_name: ClassVar[str]
    known_joints: ClassVar[tuple[str, ...]]

    def __init__(self, count: int = 0) -> None:
        super().__init__(count, self.known_name, self.known_joints)


def _known_gripper(title: str, name: str, joints: tuple[str, ...] = ()) -> type[KnownGripper]:
    """Return the class `title` of the gripper with a name and finger joints in PyRep."""
    return type(title, (KnownGripper,), {"__module__": __name__, "known_name": name, "known_joints": joints})


PandaGripper = _known_gripper("PandaGripper", "Panda_gripper", ("Panda_gripper_joint1", "Panda_gripper_joint2"))
BarrettHand = _known_gripper("BarrettHand", "BarrettHand")
BaxterGripper = _known_gripper("BaxterGripper", "BaxterGripper")
JacoGripper = _known_gripper("JacoGripper", "JacoHand", ("JacoHand_joint1", "JacoHand_joint2"))
MicoGripper = _known_gripper("MicoGripper", "MicoGripper")
Robotiq85Gripper = _known_gripper("Robotiq85Gripper", "ROBOTIQ_85", ("ROBOTIQ_85_active1", "ROBOTIQ_85_active2"))

add_aliases(
    __name__, ("barrett_hand", "baxter_gripper", "gripper", "jaco_gripper", "mico_gripper", "panda_gripper", "robotiq85_gripper")
)
