"""What a scene file says, as frozen records. Pure data: no file access, no physics.

Lengths in [m], angles in [rad], poses `[x, y, z, qx, qy, qz, qw]` in the frame of `parent`. A parent is written
`root` (the task root), `world`, `<body>`, `<body>/<link>`, `<frame>`, `<sensor>`, `<region>` or `<waypoint>`.

A file of format 1 says poses as they are here. In one of format 2 the height of `[placement]` counts from the table top,
and `rpy` and `poses` may stand for a rotation and for an array (`short_forms`); the records are the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, Strict, ValidationError, field_validator

from rlbench_pin.errors import InvalidRecord
from rlbench_pin.scene.findings import dotted, first_finding, key_hint
from rlbench_pin.scene.kinds import (
    IDENTITY_POSE,
    MOST_THINGS,
    MOST_WAYPOINTS,
    Angle,
    Damping,
    Direction,
    Force,
    Height,
    JointValue,
    Kind,
    Length,
    Name,
    Number,
    Pose,
    Share,
    Size,
    Stiffness,
    Switch,
    Words,
)
from rlbench_pin.spatial import TABLE_HEIGHT

FORMAT = 2
"""Format of new files."""
ROOT = "root"
WORLD = "world"


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)


class _RecordType(ModelMetaclass):
    """Makes records, and says in our words what is wrong with what they are made of."""

    model_fields: Mapping[str, object]

    def __call__(cls, *values: Any, **keys: Any) -> Any:
        """Make a record by hand; records within a file are checked as parts of it, where `read_scene` words the error."""
        if values:
            problem = "it is made with keys, not with bare values."
            raise InvalidRecord(cls.__name__, "", values[0], problem, key_hint("", cls.model_fields))
        try:
            return super().__call__(**keys)
        except ValidationError as error:
            found = first_finding(error)
            hint = key_hint(str(found.location[-1]), cls.model_fields) if found.kind == "unknown" else ""
            raise InvalidRecord(cls.__name__, dotted(found.location), found.value, found.problem, hint) from error


class Spec(BaseModel, metaclass=_RecordType):
    """Base of all records: frozen, unknown keys refused, numbers finite; made wrongly, they raise InvalidRecord."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _plain(cls, value: object) -> object:
        """Take arrays and numbers of numpy where lists and numbers are; dates and the like are neither."""
        return value.tolist() if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biuf" else value


class PosedSpec(Spec):
    """Something with a name and a place."""

    name: Name
    """What the task calls it by; unique in the file, and not `root`, `world`, `robot` or the name of a part of the room."""
    parent: str = ROOT
    """Whose frame the pose is in, and with what it moves: `root`, `world`, `<body>`, `<body>/<link>`, or the name of a frame,
    region, sensor or waypoint."""
    pose: Pose = IDENTITY_POSE
    """Where it is, in the frame of `parent`."""


class BodySpec(PosedSpec):
    """One object: an URDF asset, fixed to the world or free."""

    asset: str
    """URDF file below `assets/`, such as `objects/cup/cup.urdf`, or relative to the scene file when it starts with `./`."""
    fixed: Switch = False
    """Welded to its place; otherwise free under gravity."""
    collides: Switch = True
    """Touches other things; false for markers that are only seen."""
    color: tuple[Share, Share, Share, Share] | tuple[Share, Share, Share] | None = None
    """Overrides every visual colour: red, green, blue, and perhaps opacity."""
    scale: Number = Field(default=1.0, ge=1e-4, le=100.0)
    """Uniform scale of the asset."""


class SpringSpec(Spec):
    """A motor that pulls a joint to `rest`."""

    rest: JointValue = 0.0
    """Where it pulls the joint to."""
    stiffness: Stiffness = Field(gt=0.0)
    """Force per distance from rest."""
    damping: Damping = Field(default=0.0, ge=0.0)
    """Force per speed, against it."""
    max_force: Force | None = Field(default=None, ge=0.0)
    """Largest force; unlimited when left out."""


class JointSpec(Spec):
    """How a joint of a body starts and resists."""

    name: str
    """`<body>/<joint>`: a movable joint of the body's URDF file."""
    position: JointValue = 0.0
    """Where it starts; within the limits that its URDF file sets."""
    friction: Force = Field(default=0.0, ge=0.0)
    """Dry friction that holds the joint where it is left."""
    damping: Damping | None = Field(default=None, ge=0.0)
    """Overrides the damping of the URDF file."""
    spring: SpringSpec | None = None
    """A motor that pulls the joint back."""
    locked: Switch = False
    """Held by a stiff motor until the task unlocks it (a latch)."""


class FrameSpec(PosedSpec):
    """A named place."""


class RegionSpec(PosedSpec):
    """A box in which things are placed at random; flat when its height is 0."""

    size: tuple[Size, Size, Height]
    """Size along x, y and z; the pose is its middle."""


class SensorSpec(PosedSpec):
    """A volume that detects bodies."""

    shape: Literal["box", "cylinder", "sphere"]
    """Shape of the volume; the pose is its middle."""
    size: tuple[Size, ...]
    """box: x, y, z; cylinder: diameter, length along z; sphere: diameter."""


class ArcSpec(Spec):
    """A circular sweep of the previous waypoint about an axis given in the waypoint's frame."""

    axis: Direction
    """Direction through the origin of the waypoint's frame; its length does not matter."""
    angle: Angle
    """Sweep, right-handed about `axis`; at most one turn."""
    twist: Switch = True
    """Turn the hand with the sweep; otherwise only its position follows."""

    @field_validator("axis")
    @classmethod
    def _direction(cls, value: Direction) -> Direction:
        if not np.linalg.norm(value) > 1e-9:
            raise ValueError("an axis has a length other than zero")
        return value


class WaypointSpec(PosedSpec):
    """A pose that the gripper tip visits in a demonstration. Names are `waypoint0`, `waypoint1`, ... without gaps."""

    path: Literal["plan", "straight", "curve"] = "plan"
    """How to get there: any way that the planner finds, a straight line of the tip, or along `points` or `arc`."""
    ignore_collisions: Switch = False
    """Plan without looking at collisions, for contact; curves are always planned so."""
    gripper: Literal["open", "close"] | Annotated[Number, Kind("number", bounds="0 to 1")] | None = None
    """After arriving: open fully, close fully, or drive to a fraction of the opening; left alone when left out."""
    points: tuple[Pose, ...] = Field(default=(), max_length=MOST_THINGS)
    """For `curve`: the poses to pass, in the waypoint's frame, ending at the last."""
    arc: ArcSpec | None = None
    """For `curve`: a circular sweep instead of points."""
    symmetry: Annotated[int, Strict(), Kind("whole number")] = Field(default=1, ge=1, le=12)
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
    """Lowest and highest random yaw of the root."""
    footprint: tuple[Size, Size] | None = None
    """Size x, y of the patch that has to fit in the placement area; the bounding box of all bodies when left out."""
    footprint_center: tuple[Length, Length] = (0.0, 0.0)
    """Centre of the patch in the root frame."""


class DeviationSpec(Spec):
    """What differs from the specification of the task, for people to read; it changes nothing."""

    name: Words
    """What differs: a figure such as `yaw` or `sensor hook`, or a few words; unique in the file."""
    specified: Words
    """What the specification says."""
    here: Words
    """What is so in this scene, or in the class beside it."""
    reason: Words
    """Why."""
    binding: Switch = False
    """The specification asks for it; otherwise it proposes a value that a scene may choose."""


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
    deviation: tuple[DeviationSpec, ...] = Field(default=(), max_length=MOST_THINGS)
    file: str = Field(default="", exclude=True)
    """Where the scene was read from; not part of the file."""

    def posed(self) -> tuple[PosedSpec, ...]:
        """Return everything that has a name and a place."""
        return (*self.body, *self.frame, *self.region, *self.sensor, *self.waypoint)
