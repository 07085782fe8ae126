"""Frozen records of scene files, types of their values, and messages about refused values. No file access, no physics.

Lengths in [m], angles in [rad], poses `[x, y, z, qx, qy, qz, qw]` in the frame of `parent`. A parent is written
`root` (the task root), `world`, `<body>`, `<body>/<link>`, `<frame>`, `<sensor>`, `<region>` or `<waypoint>`.

A file of format 1 has poses as in these records. In a file of format 2 the height of `[placement]` counts from the table top,
and the short forms `rpy` (a rotation) and `poses` (an array) are allowed (`write_out` in `reader`). The records are the same.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, Strict, ValidationError, field_validator

from rlbench_pin.errors import InvalidRecord, nearest_name, shown
from rlbench_pin.spatial import TABLE_HEIGHT

_WORDS = {
    "Input should be a valid tuple": "it has to be a list",
    "Input should be a valid string": "it has to be a text",
    "Input should be a valid boolean": "it has to be true or false",
    "Input should be a valid dictionary": "it has to be a table",
    "Input should be": "it has to be",
    "String should match pattern '^[a-z][a-z0-9_]*$'": "it has to be small letters, digits and `_`, a letter first",
    "String should have": "it has to have",
    "Tuple should have": "it has to have",
}
"""How messages of pydantic begin -> our words for it."""
_KINDS = ("float", "int", "str", "literal", "bool")


@dataclass(frozen=True)
class Finding:
    """The first mistake in a record."""

    kind: Literal["unknown", "missing", "wrong"]
    """Whether the key is unknown, a required key is missing, or the value is invalid."""
    location: tuple[int | str, ...]
    """Path of keys and indices to the mistake."""
    value: object
    """The given value."""
    problem: str
    """The problem, as a sentence."""


def first_finding(error: ValidationError) -> Finding:
    """Return the first finding of a validation; an unknown key comes before a missing one, because it may be its misspelling."""
    findings = error.errors(include_url=False)
    first = next((f for f in findings if f["type"] == "extra_forbidden"), findings[0])
    *way, last = first["loc"] or ("",)
    location = (*(part for part in way if not _is_kind(part)), last)
    given = first["input"]
    if first["type"] == "extra_forbidden":
        return Finding("unknown", location, given, f"'{location[-1]}' is not known here.")
    if first["type"] == "missing":
        if isinstance(last, int):
            return Finding("wrong", location[:-1], given, f"it has to have more than {last} items.")
        return Finding("missing", location, given, f"the key '{last}' is missing.")
    location = tuple(part for part in first["loc"] if not _is_kind(part))
    value = "" if isinstance(given, dict) else f" (given: {shown(given)})"
    return Finding("wrong", location, given, f"{_in_our_words(first['msg'])}{value}.")


def _in_our_words(message: str) -> str:
    for theirs, ours in _WORDS.items():
        if message.startswith(theirs):
            return ours + message.removeprefix(theirs).replace(" after validation", "")
    return message.removeprefix("Value error, ")


def _is_kind(part: int | str) -> bool:
    """Whether a part of a location is a type name that pydantic adds for a union."""
    return part in _KINDS or (isinstance(part, str) and "[" in part)


def key_hint(key: str, known: Collection[str]) -> str:
    """Return a hint with the key nearest to an unknown one, or with all known keys."""
    names = sorted(known)
    near = nearest_name(key, names)
    return f"Did you mean '{near}'?" if near else f"Known keys: {', '.join(names)}."


def dotted(parts: tuple[int | str, ...]) -> str:
    """Write a location as one text, such as `arc.axis.0`."""
    return ".".join(str(part) for part in parts)


FARTHEST = 100.0
"""Coordinates and sizes are at most so large [m]."""
TURN = 2.0 * np.pi + 1e-6
"""Largest angle [rad]."""
MAX_ELEMENTS = 1000
"""Entries of a table, and points of a curve, at most."""
MAX_WAYPOINTS = 200
"""Waypoints of a scene at most."""
NAME_PATTERN = r"^[a-z][a-z0-9_]*$"


@dataclass(frozen=True)
class Kind:
    """Description of a type of values for the reference page; the reader of scene files ignores it."""

    text: str
    """Type, such as `number`."""
    unit: str = ""
    """Unit, empty where there is none."""
    bounds: str = ""
    """Bounds that the type does not say by itself."""


def _length(value: float) -> float:
    if abs(value) > FARTHEST:
        raise ValueError(f"a length is at most {FARTHEST:g} m; lengths are in metres. Are these millimetres?")
    return value


def _angle(value: float) -> float:
    if abs(value) > TURN:
        raise ValueError(
            f"an angle is at most 2 pi = 6.2832 rad; angles are in radians. Are these degrees? "
            f"{value:g} degrees are {np.radians(value):.4f} rad"
        )
    return value


def is_number(value: object) -> bool:
    """Whether a value of a file is a number in the range of floats; booleans are not numbers."""
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
    """Refuse complex numbers of numpy, which pydantic accepts as floats."""
    if isinstance(value, np.complexfloating):
        raise ValueError("a scene has no complex numbers. Give a real number")
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
"""Text for people."""
Direction = Annotated[tuple[Length, Length, Length], Kind("3 numbers", bounds="not all 0")]
"""A vector whose length does not matter."""
Pose7 = tuple[Length, Length, Length, Number, Number, Number, Number]
Pose = Annotated[Pose7, BeforeValidator(_full_pose), Kind("pose", "m, rad", f"x, y, z: {-FARTHEST:g} to {FARTHEST:g}")]
IDENTITY_POSE: Pose7 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


FORMAT = 2
"""Format of new files."""
ROOT = "root"
WORLD = "world"


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)


class _RecordType(ModelMetaclass):
    """Metaclass of records: converts validation errors to InvalidRecord."""

    model_fields: Mapping[str, object]

    def __call__(cls, *values: Any, **keys: Any) -> Any:
        """Return a record made in Python; `read_scene` validates a file as a whole and has its own messages."""
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
    """Base of all records: frozen, with finite numbers; an unknown key or an invalid value raises InvalidRecord."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _plain(cls, value: object) -> object:
        """Accept arrays and numbers of numpy as lists and numbers, but not dates and other types."""
        return value.tolist() if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biuf" else value


class PosedSpec(Spec):
    """Element with a name and a pose."""

    name: Name
    """Name for the Python of the task; unique in the file, and not `root`, `world`, `robot` or the name of a part of the room."""
    parent: str = ROOT
    """Element whose frame the pose is in, and with which it moves: `root`, `world`, `<body>`, `<body>/<link>`, or the name of a
    frame, region, sensor or waypoint."""
    pose: Pose = IDENTITY_POSE
    """Where it is, in the frame of `parent`."""


class BodySpec(PosedSpec):
    """One object: a URDF asset, fixed to the world or free."""

    asset: str
    """URDF file below `assets/`, such as `objects/cup/cup.urdf`, or relative to the scene file when it starts with `./`."""
    fixed: Switch = False
    """Welded to its place; otherwise free under gravity."""
    collides: Switch = True
    """Touches other objects; false for markers that are only seen."""
    color: tuple[Share, Share, Share, Share] | tuple[Share, Share, Share] | None = None
    """Overrides every visual colour: red, green, blue, and perhaps opacity."""
    scale: Number = Field(default=1.0, ge=1e-4, le=100.0)
    """Uniform scale of the asset."""
    look_alikes: tuple[str, ...] = ()
    """URDF files of similar objects, written as `asset` is. The factor `object_model` puts one of them in its place, with its
    size."""
    role: Literal["manipulated", "receiving"] | None = None
    """Use in a demonstration. `manipulated`: the gripper moves it. `receiving`: a manipulated object ends in, on or at
    it, or acts on it as a tool."""


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
    """Start position, friction, damping, spring and lock of a joint of a body."""

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
    """A named coordinate frame."""


class RegionSpec(PosedSpec):
    """A box in which objects are placed at random; flat when its height is 0."""

    size: tuple[Size, Size, Height]
    """Size along x, y and z; the pose is its middle."""


class SensorSpec(PosedSpec):
    """A volume that detects bodies."""

    shape: Literal["box", "cylinder", "sphere"]
    """Shape of the volume; the pose is its middle."""
    size: tuple[Size, ...]
    """box: x, y, z; cylinder: diameter, length along z; sphere: diameter."""


class ArcSpec(Spec):
    """An arc: the previous waypoint rotated about an axis in the frame of the waypoint."""

    axis: Direction
    """Direction through the origin of the waypoint's frame; its length does not matter."""
    angle: Angle
    """Sweep, right-handed about `axis`; at most 2 pi."""
    twist: Switch = True
    """Turn the gripper with the sweep; otherwise only its position follows."""

    @field_validator("axis")
    @classmethod
    def _direction(cls, value: Direction) -> Direction:
        if not np.linalg.norm(value) > 1e-9:
            raise ValueError("an axis has a length above zero")
        return value


class WaypointSpec(PosedSpec):
    """A pose that the gripper tip visits in a demonstration. Names are `waypoint0`, `waypoint1`, ... without gaps."""

    path: Literal["plan", "straight", "curve"] = "plan"
    """How to get there: any way that the planner finds, a straight line of the tip, or along `points` or `arc`."""
    ignore_collisions: Switch = False
    """Plan without collision checks, for contact; curves are always planned so."""
    gripper: Literal["open", "close"] | Annotated[Number, Kind("number", bounds="0 to 1")] | None = None
    """After arriving: open fully, close fully, or drive to a fraction of the opening; left alone when left out."""
    points: tuple[Pose, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    """For `curve`: the poses to pass, in the waypoint's frame, ending at the last."""
    arc: ArcSpec | None = None
    """For `curve`: a circular sweep instead of points."""
    compliant: Switch = False
    """Approach on a slow straight line that gives way to contact and searches the opening; for insertion. Collisions are ignored,
    and what is held is brought to the pose that it would have if it had been grasped exactly."""
    symmetry: Annotated[int, Strict(), Kind("whole number")] = Field(default=1, ge=1, le=12)
    """The gripper may arrive turned about its z by any multiple of 2 pi / symmetry; later waypoints of the same symmetry
    keep the turn."""

    @field_validator("gripper")
    @classmethod
    def _fraction(cls, value: object) -> object:
        if isinstance(value, float) and not 0.0 <= value <= 1.0:
            raise ValueError(f"an opening fraction is in 0..1, not {value}")
        return value


class PlacementSpec(Spec):
    """Pose of the task root, and the bounds of its random placement."""

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


class InstructionsSpec(Spec):
    """Templates of instructions; the task replaces `{word}` by a word of the variation."""

    training: tuple[Words, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    """Returned by resets and recorded with demonstrations."""
    held_out: tuple[Words, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    """Paraphrases that no demonstration comes with."""
    vague: tuple[Words, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    """Say no more than is needed to know the goal in this scene."""
    specific: tuple[Words, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    """Say how to reach the goal as well."""


class ExcludedFactorSpec(Spec):
    """A factor of generalisation that is excluded or limited for this task."""

    name: Name
    """Name of the factor."""
    reason: Words
    """Why."""
    within: tuple[Number, Number] | None = None
    """Lowest and highest number of the factor that this task supports; the factor is excluded altogether when left out."""


class DeviationSpec(Spec):
    """A documented deviation from the specification of the task; it has no effect."""

    name: Words
    """What differs: a figure such as `yaw` or `sensor hook`, or a few words; unique in the file."""
    specified: Words
    """Value in the specification."""
    here: Words
    """Value in this scene or in its class."""
    reason: Words
    """Why."""
    binding: Switch = False
    """The specification asks for it; otherwise it proposes a value that a scene may choose."""


class HistorySpec(Spec):
    """A change of start states, dynamics or success, after which results cannot be compared with earlier ones."""

    version: Annotated[int, Strict(), Kind("whole number")] = Field(ge=2, le=MAX_ELEMENTS)
    """Version of the task since this change: 2, 3, ... without gaps. Version 1 has no entry."""
    change: Words
    """Description of the change, as one sentence."""
    release: Words | None = None
    """Release of the package that had the change first, such as `0.2.0`."""


class SceneSpec(Spec):
    """A whole scene file."""

    format: Literal[1, 2]
    """Format of the file."""
    base: Name | None = Field(default=None, exclude=True)
    """Task beside this one that has the same Python code. Its scene holds here too; a table replaces the one of the same name."""
    placement: PlacementSpec = PlacementSpec()
    body: tuple[BodySpec, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    joint: tuple[JointSpec, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    frame: tuple[FrameSpec, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    region: tuple[RegionSpec, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    sensor: tuple[SensorSpec, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    waypoint: tuple[WaypointSpec, ...] = Field(default=(), max_length=MAX_WAYPOINTS)
    instructions: InstructionsSpec = InstructionsSpec()
    excluded_factor: tuple[ExcludedFactorSpec, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    deviation: tuple[DeviationSpec, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    history: tuple[HistorySpec, ...] = Field(default=(), max_length=MAX_ELEMENTS)
    file: str = Field(default="", exclude=True)
    """File that the scene was read from; not part of the file."""

    @property
    def version(self) -> int:
        """Version of the task, from 1: that of the last entry of `history`."""
        return self.history[-1].version if self.history else 1

    def posed(self) -> tuple[PosedSpec, ...]:
        """Return all elements that have a name and a pose."""
        return (*self.body, *self.frame, *self.region, *self.sensor, *self.waypoint)
