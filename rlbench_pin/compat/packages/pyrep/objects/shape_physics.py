"""How shapes move and what they touch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pyrep.objects.object import Object
from rlbench_pin.compat.things import physics
from rlbench_pin.sim import Body
from rlbench_pin.spatial import FloatArray

Numbers = Sequence[float] | FloatArray


class ShapePhysics(Object):
    """Mass, friction, and whether a shape moves and touches."""

    def body(self, call: str) -> Body:
        """Return the body that the shape is, or is a link of.

        Raises:
            UnsupportedCall: It is a plane or a part of the arm.
        """
        return physics.body_of(self.table, self.element, call)

    def is_respondable(self) -> bool:
        """Whether it touches other things."""
        return physics.has_body(self.element) and self.body("is_respondable").collides

    def set_respondable(self, value: bool) -> None:
        """Let it touch other things, or pass through them; a link shares this with its whole body."""
        physics.set_respondable(self.table, self.element, bool(value))

    def is_dynamic(self) -> bool:
        """Whether it moves under gravity and contacts."""
        return physics.has_body(self.element) and not self.body("is_dynamic").fixed

    def set_dynamic(self, value: bool) -> None:
        """Let it move under gravity and contacts, or weld it to where it is."""
        physics.set_dynamic(self.table, self.element, bool(value))

    def get_mass(self) -> float:
        """Return its mass [kg]; that of the base link for a body."""
        return physics.mass(self.table, self.element)

    def set_mass(self, mass: float) -> None:
        """Give it another mass [kg]; it stays so until it is set again, resets included."""
        if not 0.0 < mass < float("inf"):
            raise ValueError(f"A mass is positive and finite, not {mass} kg.")
        physics.set_mass(self.table, self.element, float(mass))

    def get_bullet_friction(self) -> float:
        """Return the coefficient of sliding friction."""
        return physics.friction(self.table, self.element)

    def set_bullet_friction(self, friction: float) -> None:
        """Set the coefficient of sliding friction; it stays so until it is set again, resets included."""
        if not 0.0 <= friction < float("inf"):
            raise ValueError(f"A coefficient of friction is not negative, but {friction} was given.")
        physics.set_friction(self.table, self.element, float(friction))

    def compute_mass_and_inertia(self, density: float) -> None:
        """Set the mass from a density [kg/m^3] and the volume of its solid parts; its inertia grows alike."""
        self.set_mass(density * physics.volume(self.thing))

    def add_force(self, position: Numbers, force: Numbers, reset_force_torque: bool = False) -> None:
        """Push it during the next step. The push acts as an impulse at once; call it before each step to go on pushing.

        Args:
            position: Where, in its own frame (3,) [m].
            force: How, along its own axes (3,) [N].
            reset_force_torque: Accepted; what was added before has acted already.
        """
        T_world_shape = self.get_matrix()
        at = T_world_shape @ np.append(_three(position), 1.0)
        physics.push(self.table, self.element, T_world_shape[:3, :3] @ _three(force), np.zeros(3), at[:3])

    def add_force_and_torque(
        self, force: Numbers, torque: Numbers, reset_force: bool = False, reset_torque: bool = False
    ) -> None:
        """Push and turn it about its centre of mass during the next step, as `add_force` does.

        Args:
            force: Along the axes of the world (3,) [N].
            torque: About the axes of the world (3,) [N m].
            reset_force: Accepted; what was added before has acted already.
            reset_torque: Accepted.
        """
        physics.push(self.table, self.element, _three(force), _three(torque))

    def set_velocity(self, linear: Any, angular: Any = (0.0, 0.0, 0.0)) -> None:
        """Set linear (3,) [m/s] and angular (3,) [rad/s] velocity in world axes."""
        self.body("set_velocity").set_velocity(np.concatenate([np.asarray(linear, float), np.asarray(angular, float)]))


def _three(values: Numbers) -> FloatArray:
    numbers = np.asarray(values, dtype=float).reshape(-1)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise ValueError(f"A position, force or torque has 3 finite numbers, not {numbers.tolist()}.")
    return numbers
