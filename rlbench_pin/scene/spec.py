"""What a scene file says, as frozen records. Pure data: no file access, no physics.

Lengths in [m], angles in [rad], poses `[x, y, z, qx, qy, qz, qw]` in the frame of `parent`. A parent is written
`root` (the task root), `world`, `<body>`, `<body>/<link>`, `<frame>`, `<sensor>`, `<region>` or `<waypoint>`.

A file of format 1 says poses as they are here. In one of format 2 the height of `[placement]` counts from the table top,
and `rpy` and `poses` may stand for a rotation and for an array (`short_forms`); the records are the same.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator

from rlbench_pin.spatial import TABLE_HEIGHT

FORMAT = 2
"""Format of new files."""
ROOT = "root"
WORLD = "world"

Vec3 = tuple[float, float, float]
Pose7 = tuple[float, float, float, float, float, float, float]


def _full_pose(value: object) -> object:
    """Accept `[x, y, z]` and `[x, y, z, yaw]` as short forms of a pose; normalise quaternions."""
    if not isinstance(value, list | tuple) or not all(isinstance(v, int | float) for v in value):
        return value
    numbers = [float(v) for v in value]
    if len(numbers) == 3:
        return (*numbers, 0.0, 0.0, 0.0, 1.0)
    if len(numbers) == 4:
        half = numbers[3] / 2.0
        return (*numbers[:3], 0.0, 0.0, float(np.sin(half)), float(np.cos(half)))
    if len(numbers) == 7:
        norm = float(np.linalg.norm(numbers[3:]))
        if abs(norm - 1.0) > 1e-3:
            raise ValueError(f"the quaternion {numbers[3:]} has norm {norm:.4f}, not 1")
        return (*numbers[:3], *(v / norm for v in numbers[3:]))
    raise ValueError(f"a pose has 3 (x y z), 4 (x y z yaw) or 7 (x y z qx qy qz qw) numbers, not {len(numbers)}")


Pose = Annotated[Pose7, BeforeValidator(_full_pose)]
IDENTITY_POSE: Pose7 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
NAME_PATTERN = r"^[a-z][a-z0-9_]*$"
Name = Annotated[str, Field(pattern=NAME_PATTERN)]


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
    fixed: bool = False
    """Welded to its place; otherwise free under gravity."""
    collides: bool = True
    """Touches other things; False for markers that are only seen."""
    color: tuple[float, float, float, float] | tuple[float, float, float] | None = None
    """Overrides every visual colour, rgb or rgba in 0..1."""
    scale: float = Field(default=1.0, gt=0.0)
    """Uniform scale of the asset."""


class SpringSpec(Spec):
    """A motor that pulls a joint to `rest`."""

    rest: float = 0.0
    stiffness: float = Field(gt=0.0)
    """[N/m] or [N m/rad]."""
    damping: float = Field(default=0.0, ge=0.0)
    """[N s/m] or [N m s/rad]."""
    max_force: float | None = None
    """[N] or [N m]; None is unlimited."""


class JointSpec(Spec):
    """How a joint of a body starts and resists. The name is `<body>/<joint>`."""

    name: str
    position: float = 0.0
    """Start value [m] or [rad]."""
    friction: float = Field(default=0.0, ge=0.0)
    """Dry friction [N] or [N m] that holds the joint where it is left."""
    damping: float | None = Field(default=None, ge=0.0)
    """Overrides the damping of the URDF."""
    spring: SpringSpec | None = None
    locked: bool = False
    """Held by a stiff motor until the task unlocks it (a latch)."""


class FrameSpec(PosedSpec):
    """A named place."""


class RegionSpec(PosedSpec):
    """A box in which things are placed at random; flat when its height is 0."""

    size: Vec3


class SensorSpec(PosedSpec):
    """A volume that detects bodies."""

    shape: Literal["box", "cylinder", "sphere"]
    size: tuple[float, ...]
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
    angle: float
    """Sweep [rad], right-handed about `axis`."""
    twist: bool = True
    """Turn the hand with the sweep; otherwise only its position follows."""


class WaypointSpec(PosedSpec):
    """A pose that the gripper tip visits in a demonstration. Names are `waypoint0`, `waypoint1`, ... without gaps."""

    path: Literal["plan", "straight", "curve"] = "plan"
    ignore_collisions: bool = False
    gripper: Literal["open", "close"] | float | None = None
    """After arriving: open fully, close fully, or drive to an opening fraction 0..1."""
    points: tuple[Pose, ...] = ()
    """For `curve`: the poses to pass, in the waypoint's frame, ending at the last."""
    arc: ArcSpec | None = None
    """For `curve`: a circular sweep instead of points."""
    symmetry: int = Field(default=1, ge=1, le=12)
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
    static: bool = False
    """The root stays at its nominal pose in every episode."""
    yaw: tuple[float, float] = (-3.14, 3.14)
    """Bounds of the random yaw of the root [rad]."""
    footprint: tuple[float, float] | None = None
    """Size x, y of the patch that has to fit in the placement area; None takes the bounding box of all bodies."""
    footprint_center: tuple[float, float] = (0.0, 0.0)
    """Centre of the patch in the root frame."""


class SceneSpec(Spec):
    """A whole scene file."""

    format: Literal[1, 2]
    """Format of the file."""
    placement: PlacementSpec = PlacementSpec()
    body: tuple[BodySpec, ...] = ()
    joint: tuple[JointSpec, ...] = ()
    frame: tuple[FrameSpec, ...] = ()
    region: tuple[RegionSpec, ...] = ()
    sensor: tuple[SensorSpec, ...] = ()
    waypoint: tuple[WaypointSpec, ...] = ()
    file: str = Field(default="", exclude=True)
    """Where the scene was read from; not part of the file."""

    def posed(self) -> tuple[PosedSpec, ...]:
        """Return everything that has a name and a place."""
        return (*self.body, *self.frame, *self.region, *self.sensor, *self.waypoint)
