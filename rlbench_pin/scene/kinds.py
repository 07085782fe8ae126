"""Kinds of values in a scene file: what the reader takes, in which unit and bounds, and how a page shows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, Strict

FARTHEST = 100.0
"""Coordinates and sizes are at most so large [m]."""
TURN = 2.0 * np.pi + 1e-6
"""Angles are at most one turn [rad]."""
MOST_THINGS = 1000
"""Entries of a table, and points of a curve, at most."""
MOST_WAYPOINTS = 200
"""Waypoints of a scene at most."""
NAME_PATTERN = r"^[a-z][a-z0-9_]*$"


@dataclass(frozen=True)
class Kind:
    """What a reader of the reference page is told about a kind of value; the reader of scene files ignores it."""

    text: str
    """What it is, such as `number`."""
    unit: str = ""
    """Unit, empty where there is none."""
    bounds: str = ""
    """Bounds that the type does not say by itself."""


def _length(value: float) -> float:
    if abs(value) > FARTHEST:
        raise ValueError(f"a length is at most {FARTHEST:g} m; lengths are in metres. Were these millimetres?")
    return value


def _angle(value: float) -> float:
    if abs(value) > TURN:
        raise ValueError(
            f"an angle is at most one turn, 2 pi = 6.2832 rad; angles are in radians. Were these degrees? "
            f"{value:g} degrees are {np.radians(value):.4f} rad"
        )
    return value


def is_number(value: object) -> bool:
    """Whether a value of a file is a number that a float can hold; truth values are none."""
    return not isinstance(value, bool) and isinstance(value, int | float) and abs(value) <= 1e300


def _full_pose(value: object) -> object:
    """Accept `[x, y, z]` and `[x, y, z, yaw]` as short forms of a pose; normalise quaternions."""
    if not isinstance(value, list | tuple) or not all(is_number(v) for v in value):
        return value
    numbers = [float(v) for v in value]
    if len(numbers) == 3:
        return (*numbers, 0.0, 0.0, 0.0, 1.0)
    if len(numbers) == 4:
        half = _angle(numbers[3]) / 2.0
        return (*numbers[:3], 0.0, 0.0, float(np.sin(half)), float(np.cos(half)))
    if len(numbers) == 7:
        norm = float(np.linalg.norm(numbers[3:]))
        if abs(norm - 1.0) > 1e-3:
            raise ValueError(f"the quaternion {numbers[3:]} has norm {norm:.4f}, not 1")
        return (*numbers[:3], *(v / norm for v in numbers[3:]))
    raise ValueError(f"a pose has 3 (x y z), 4 (x y z yaw) or 7 (x y z qx qy qz qw) numbers, not {len(numbers)}")


def _real(value: object) -> object:
    """Keep complex numbers of numpy out, which pass for floats."""
    if isinstance(value, np.complexfloating):
        raise ValueError("a complex number is none of a scene")
    return value


Number = Annotated[float, Strict(), BeforeValidator(_real), Kind("number")]
"""A number; truth values and text are none."""
Switch = Annotated[bool, Strict(), Kind("switch")]
"""True or false; numbers and text are neither."""
Share = Annotated[Number, Field(ge=0.0, le=1.0), Kind("number", bounds="0 to 1")]
"""A number in 0..1."""
Length = Annotated[Number, AfterValidator(_length), Kind("number", "m", f"{-FARTHEST:g} to {FARTHEST:g}")]
"""A coordinate."""
Size = Annotated[Length, Field(gt=0.0), Kind("number", "m", f"above 0, to {FARTHEST:g}")]
"""A size that cannot be zero."""
Height = Annotated[Length, Field(ge=0.0), Kind("number", "m", f"0 to {FARTHEST:g}")]
"""A size that may be zero."""
Angle = Annotated[Number, AfterValidator(_angle), Kind("number", "rad", "-2 pi to 2 pi")]
"""At most one turn either way."""
JointValue = Annotated[Number, Kind("number", "rad or m")]
"""Position of a revolute or of a prismatic joint; the same pairs of units for what follows."""
Force = Annotated[Number, Kind("number", "N m or N")]
Stiffness = Annotated[Number, Kind("number", "N m/rad or N/m")]
Damping = Annotated[Number, Kind("number", "N m s/rad or N s/m")]
Name = Annotated[str, Field(pattern=NAME_PATTERN, max_length=100), Kind("name", bounds="small letters, digits, `_`; at most 100")]
Words = Annotated[str, Strict(), Field(min_length=1, max_length=500), Kind("text", bounds="1 to 500 characters")]
"""What people read."""
Direction = Annotated[tuple[Length, Length, Length], Kind("3 numbers", bounds="not all 0")]
"""A vector whose length does not matter."""
Pose7 = tuple[Length, Length, Length, Number, Number, Number, Number]
Pose = Annotated[Pose7, BeforeValidator(_full_pose), Kind("pose", "m, rad", f"x, y, z: {-FARTHEST:g} to {FARTHEST:g}")]
IDENTITY_POSE: Pose7 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
