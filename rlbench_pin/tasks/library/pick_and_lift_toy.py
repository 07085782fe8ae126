"""Lift a rubber duck to a floating marker."""

from __future__ import annotations

from rlbench_pin.tasks.library.pick_and_lift_cylinder import PickAndLiftCylinder


class PickAndLiftToy(PickAndLiftCylinder):
    """The rubber duck must be held at the marker. It, two cubes and the marker stand anywhere in a rectangle."""

    word = "rubber duck"
