"""Lift a star to a floating marker."""

from __future__ import annotations

from rlbench_pin.tasks.library.pick_and_lift_cylinder import PickAndLiftCylinder


class PickAndLiftStar(PickAndLiftCylinder):
    """The gripper must hold the star at the marker. The star, two cubes and the marker start at random places."""

    word = "star"
