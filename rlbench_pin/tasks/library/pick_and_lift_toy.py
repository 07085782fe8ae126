"""Lift a rubber duck to a floating marker."""

from __future__ import annotations

from rlbench_pin.tasks.library.pick_and_lift_cylinder import PickAndLiftCylinder


class PickAndLiftToy(PickAndLiftCylinder):
    """The gripper must hold the rubber duck at the marker. The duck, two cubes and the marker start at random places."""

    word = "rubber duck"
