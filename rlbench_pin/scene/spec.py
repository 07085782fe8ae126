"""What a scene file says, as frozen records. Pure data: no file access, no physics.

Lengths in [m], angles in [rad], poses `[x, y, z, qx, qy, qz, qw]` in the frame of `parent`. A parent is written
`root` (the task root), `world`, `<body>`, `<body>/<link>`, `<frame>`, `<sensor>`, `<region>` or `<waypoint>`.

A file of format 1 says poses as they are here. In one of format 2 the height of `[placement]` counts from the table top,
and `rpy` and `poses` may stand for a rotation and for an array (`short_forms`); the records are the same.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, Strict, field_validator

from rlbench_pin.spatial import TABLE_HEIGHT

FORMAT = 2
"""Format of new files."""
ROOT = "root"
WORLD = "world"

FARTHEST = 100.0
"""Coordinates and sizes are at most so large [m]."""
TURN = 2.0 * np.pi + 1e-6
"""Angles are at most one turn [rad]."""
MOST_THINGS = 1000
"""Entries of a table, and points of a curve, at most."""

MOST_WAYPOINTS = 200
"""Waypoints of a scene at most."""

Number = Annotated[float, Strict()]
"""A number; truth values and text are none."""
Switch = Annotated[bool, Strict()]


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


Length = Annotated[Number, AfterValidator(_length)]
Angle = Annotated[Number, AfterValidator(_angle)]
Vec3 = tuple[Length, Length, Length]
Pose7 = tuple[Length, Length, Length, Number, Number, Number, Number]


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


Share = Annotated[Number, Field(ge=0.0, le=1.0)]
"""A number in 0..1."""
Pose = Annotated[Pose7, BeforeValidator(_full_pose)]
IDENTITY_POSE: Pose7 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
NAME_PATTERN = r"^[a-z][a-z0-9_]*$"
Name = Annotated[str, Field(pattern=NAME_PATTERN, max_length=100)]


class Spec(BaseModel):
    """Base of all records: frozen, unknown keys refused, numbers finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class PosedSpec(Spec):
    """Something with a name and a place."""

    name: Name
    parent: str = ROOT
    pose: Pose = IDENTITY_POSE


class BodySpec(PosedSpec):
    """One object: an URDF asset, fixed to the world or free."""

    asset: str
    """Path below `assets/`, such as `objects/saucepan/saucepan.urdf`, or relative to the scene file when it starts with `./`."""
    fixed: Switch = False
    """Welded to its place; otherwise free under gravity."""
    collides: Switch = True
    """Touches other things; False for markers that are only seen."""
    color: tuple[Share, Share, Share, Share] | tuple[Share, Share, Share] | None = None
    """Overrides every visual colour, rgb or rgba in 0..1."""
    scale: Number = Field(default=1.0, ge=1e-4, le=100.0)
    """Uniform scale of the asset."""
    spin_damping: Number | None = Field(default=None, ge=0.0, le=100.0)
    """How fast its turning dies away, as a share of the speed per time [1/s]; brings balls to rest that have no rolling friction,
    which costs two rows of the solver per contact. None leaves it to the simulator: 0.04."""


class SpringSpec(Spec):
    """A motor that pulls a joint to `rest`."""

    rest: Number = 0.0
    stiffness: Number = Field(gt=0.0)
    """[N/m] or [N m/rad]."""
    damping: Number = Field(default=0.0, ge=0.0)
    """[N s/m] or [N m s/rad]."""
    max_force: Number | None = Field(default=None, ge=0.0)
    """[N] or [N m]; None is unlimited."""


class JointSpec(Spec):
    """How a joint of a body starts and resists. The name is `<body>/<joint>`."""

    name: str
    position: Number = 0.0
    """Start value [m] or [rad]."""
    friction: Number = Field(default=0.0, ge=0.0)
    """Dry friction [N] or [N m] that holds the joint where it is left."""
    damping: Number | None = Field(default=None, ge=0.0)
    """Overrides the damping of the URDF."""
    spring: SpringSpec | None = None
    locked: Switch = False
    """Held by a stiff motor until the task unlocks it (a latch)."""


class FrameSpec(PosedSpec):
    """A named place."""


class RegionSpec(PosedSpec):
    """A box in which things are placed at random; flat when its height is 0."""

    size: Vec3


class SensorSpec(PosedSpec):
    """A volume that detects bodies."""

    shape: Literal["box", "cylinder", "sphere"]
    size: tuple[Length, ...]
    """box: x, y, z; cylinder: diameter, length along z; sphere: diameter."""

    @field_validator("size")
    @classmethod
    def _positive(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if not value or min(value) <= 0.0:
            raise ValueError(f"every size is > 0, not {list(value)}")
        return value


class ArcSpec(Spec):
    """A circular sweep of the previous waypoint about an axis given in the waypoint's frame."""

    axis: Vec3
    """Direction through the origin of the waypoint's frame."""
    angle: Angle
    """Sweep [rad], right-handed about `axis`; at most one turn."""
    twist: Switch = True
    """Turn the hand with the sweep; otherwise only its position follows."""

    @field_validator("axis")
    @classmethod
    def _direction(cls, value: Vec3) -> Vec3:
        if not np.linalg.norm(value) > 1e-9:
            raise ValueError("an axis has a length other than zero")
        return value


class WaypointSpec(PosedSpec):
    """A pose that the gripper tip visits in a demonstration. Names are `waypoint0`, `waypoint1`, ... without gaps."""

    path: Literal["plan", "straight", "curve"] = "plan"
    ignore_collisions: Switch = False
    gripper: Literal["open", "close"] | Number | None = None
    """After arriving: open fully, close fully, or drive to an opening fraction 0..1."""
    points: tuple[Pose, ...] = Field(default=(), max_length=MOST_THINGS)
    """For `curve`: the poses to pass, in the waypoint's frame, ending at the last."""
    arc: ArcSpec | None = None
    """For `curve`: a circular sweep instead of points."""
    symmetry: Annotated[int, Strict()] = Field(default=1, ge=1, le=12)
    """The hand may arrive turned about its z by any multiple of 2 pi / symmetry; later waypoints of the same symmetry
    keep the turn."""

    @field_validator("gripper")
    @classmethod
    def _fraction(cls, value: object) -> object:
        if isinstance(value, float) and not 0.0 <= value <= 1.0:
            raise ValueError(f"an opening fraction lies in 0..1, not {value}")
        return value


class PlacementSpec(Spec):
    """Where the task root stands and how it may be placed at random."""

    pose: Pose = (0.25, 0.0, TABLE_HEIGHT, 0.0, 0.0, 0.0, 1.0)
    """Nominal pose of the root in the world; used as it is with static positions. In a file of format 2, z counts from the
    table top."""
    static: Switch = False
    """The root stays at its nominal pose in every episode."""
    yaw: tuple[Angle, Angle] = (-3.14, 3.14)
    """Bounds of the random yaw of the root [rad]."""
    footprint: tuple[Length, Length] | None = None
    """Size x, y of the patch that has to fit in the placement area, each > 0; None takes the bounding box of all bodies."""
    footprint_center: tuple[Length, Length] = (0.0, 0.0)
    """Centre of the patch in the root frame."""


class SceneSpec(Spec):
    """A whole scene file."""

    format: Literal[1, 2]
    """Format of the file."""
    placement: PlacementSpec = PlacementSpec()
    body: tuple[BodySpec, ...] = Field(default=(), max_length=MOST_THINGS)
    joint: tuple[JointSpec, ...] = Field(default=(), max_length=MOST_THINGS)
    frame: tuple[FrameSpec, ...] = Field(default=(), max_length=MOST_THINGS)
    region: tuple[RegionSpec, ...] = Field(default=(), max_length=MOST_THINGS)
    sensor: tuple[SensorSpec, ...] = Field(default=(), max_length=MOST_THINGS)
    waypoint: tuple[WaypointSpec, ...] = Field(default=(), max_length=MOST_WAYPOINTS)
    file: str = Field(default="", exclude=True)
    """Where the scene was read from; not part of the file."""

    def posed(self) -> tuple[PosedSpec, ...]:
        """Return everything that has a name and a place."""
        return (*self.body, *self.frame, *self.region, *self.sensor, *self.waypoint)
