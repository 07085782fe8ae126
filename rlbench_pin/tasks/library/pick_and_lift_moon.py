"""Lift a crescent moon to a floating marker."""

from __future__ import annotations

from rlbench_pin.tasks.library.pick_and_lift_cylinder import PickAndLiftCylinder


class PickAndLiftMoon(PickAndLiftCylinder):
    """The gripper must hold the crescent moon at the marker. The moon, two cubes and the marker start at random places."""

    word = "crescent moon"
