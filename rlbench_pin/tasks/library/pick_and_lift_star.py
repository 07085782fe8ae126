"""Lift a star to a floating marker."""

from __future__ import annotations

from rlbench_pin.tasks.library.pick_and_lift_cylinder import PickAndLiftCylinder


class PickAndLiftStar(PickAndLiftCylinder):
    """The star must be held at the marker. It, two cubes and the marker stand anywhere in a rectangle."""

    word = "star"
