"""URDF and SRDF files as frozen records of plain numbers; a file is read again only after it has changed.

Units are those of URDF: metres, radians, kilograms. Meshes are not opened.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from rlbench_pin.errors import AssetInvalid, AssetNotFound

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)
CONTINUOUS = (-4.0 * math.pi, 4.0 * math.pi)
"""Range of a `continuous` joint in models and simulation, more than any motion uses [rad]."""
UNBOUNDED = (float("-inf"), float("inf"))
"""Limits of a joint that has none."""
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@dataclass(frozen=True)
class UrdfOrigin:
    """A pose in the frame of a link or joint."""

    xyz: Vector = ZERO
    """[m]."""
    rpy: Vector = ZERO
    """Rotation Rz(yaw) Ry(pitch) Rx(roll), [rad]."""


@dataclass(frozen=True)
class Finish:
    """Material of a visual without its colour: gloss, emission, pattern."""

    gloss: Vector = ZERO
    """Share of red, green, blue that it throws back like a mirror, `<specular rgb>`."""
    emission: Vector | None = None
    """Colour in which it shines, `<emission rgb>`; in other colours it does not."""
    reach: float = 0.0
    """How far its light reaches over the table when it shines, `<emission reach>` [m]."""
    pattern: Path | None = None
    """Image file that brightens and darkens the colour, `<pattern filename>`."""
    pattern_size: float = 0.25
    """Side of that image on the surface, `<pattern size>` [m]."""


DULL = Finish()
"""A material without a finish."""


@dataclass(frozen=True)
class UrdfShape:
    """One visual or collision element of a link."""

    kind: str
    """`box`, `sphere`, `cylinder`, `capsule` or `mesh`; empty when the element has no geometry."""
    size: tuple[float, ...]
    """box: x, y, z; sphere: radius; cylinder, capsule: radius, length [m]; mesh: factor along each axis."""
    mesh: Path | None
    """File of a mesh."""
    origin: UrdfOrigin | None
    """Placement in the link frame; None where the file has none."""
    color: tuple[float, ...] | None
    """Red, green, blue, opacity from 0 to 1 of its own material."""
    finish: Finish = DULL
    """Material without the colour."""


@dataclass(frozen=True)
class UrdfInertial:
    """Mass distribution of a link."""

    mass: float
    """[kg]."""
    origin: UrdfOrigin | None
    """Placement of the inertial frame in the link frame; None where the file has none."""
    inertia: tuple[float, ...]
    """ixx, ixy, ixz, iyy, iyz, izz in the inertial frame [kg m^2]."""


@dataclass(frozen=True)
class UrdfLink:
    """One link: a rigid body."""

    name: str
    """Unique in a valid file."""
    visuals: tuple[UrdfShape, ...]
    """Visual shapes, in file order."""
    collisions: tuple[UrdfShape, ...]
    """Collision shapes, in file order."""
    inertial: UrdfInertial | None
    """None where the file has none."""


@dataclass(frozen=True)
class Follows:
    """Coupling to another joint: position = `ratio` * position of the other + `offset`."""

    joint: str
    """Name of the other."""
    ratio: float = 1.0
    offset: float = 0.0
    """[rad] or [m]."""


@dataclass(frozen=True)
class UrdfJoint:
    """One joint: a connection of two links."""

    name: str
    """Unique in a valid file."""
    kind: str
    """`fixed`, `revolute`, `continuous`, `prismatic`, ..."""
    parent: str
    """Name of the link nearer to the base; empty where the file has none."""
    child: str
    """Name of the link that it moves; empty where the file has none."""
    limits: tuple[float, float]
    """Smallest and largest position [rad] or [m]."""
    origin: UrdfOrigin | None
    """Placement of the child at position 0 in the frame of the parent; None where the file has none."""
    axis: Vector
    """About or along which it moves, in the frame of the child."""
    follows: Follows | None = None
    """The joint that it follows, `<mimic>`; None for a joint that moves by itself."""
    effort: float | None = None
    """Largest torque [N m] or force [N]; None where the file has none, or not more than 0."""
    velocity: float | None = None
    """Largest speed [rad/s] or [m/s]; None where the file has none, or not more than 0."""


@dataclass(frozen=True)
class Urdf:
    """Contents of one URDF file."""

    path: Path
    """The file."""
    links: tuple[UrdfLink, ...]
    """In file order."""
    joints: tuple[UrdfJoint, ...]
    """In file order."""
    meshes: tuple[Path, ...]
    """Mesh files that it names, in file order, each once."""
    textures: tuple[Path, ...]
    """Image files that its materials name."""
    name: str = ""
    """Of the `<robot>`."""

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links, in file order."""
        return tuple(link.name for link in self.links)

    @property
    def base_link(self) -> str:
        """Name of the first link that is not the child of a joint.

        Raises:
            AssetInvalid: There is no such link.
        """
        children = {joint.child for joint in self.joints}
        if set(self.link_names) <= children:
            raise AssetInvalid(self.path, "every link is the child of a joint")
        return next(name for name in self.link_names if name not in children)

    @property
    def joint_limits(self) -> dict[str, tuple[float, float]]:
        """Name of a movable joint -> smallest and largest position [rad] or [m]."""
        return {joint.name: joint.limits for joint in self.joints if joint.kind != "fixed"}


def read_urdf(path: Path, needed_by: str = "a model") -> Urdf:
    """Return the content of a URDF file, which is read again only after it has changed.

    Args:
        path: The file.
        needed_by: Name of the caller, for the error message.

    Raises:
        AssetNotFound: The file does not exist.
        AssetInvalid: The file is not XML, or a number or a name in it is missing or wrong.
    """
    return _read_urdf(path, _time_of(path, needed_by))


def disabled_pairs(srdf: Path) -> frozenset[frozenset[str]]:
    """Return the pairs of links whose collisions an SRDF file disables.

    Raises:
        AssetNotFound: The file does not exist.
        AssetInvalid: The file is not XML.
    """
    return _disabled_pairs(srdf, _time_of(srdf, "a robot"))


def format_srdf(robot: str, pairs: Iterable[tuple[str, str, str]]) -> str:
    """Return the text of an SRDF file: pairs of links that are not checked for collisions, each with its reason."""
    root = ET.Element("robot", name=robot)
    for first, second, reason in pairs:
        ET.SubElement(root, "disable_collisions", link1=first, link2=second, reason=reason)
    ET.indent(root)
    head = '<?xml version="1.0"?>\n<!-- Pairs found by sampling configurations of the URDF. -->\n'
    return head + ET.tostring(root, encoding="unicode") + "\n"


def kinematic_urdf(path: Path, fixed: Collection[str] = ()) -> str:
    """Return the text of a URDF file without visual and collision elements, with the joints named in `fixed` fixed at zero.

    A `continuous` joint becomes a revolute joint with the range `CONTINUOUS`, so that the position of every joint is one number.

    Raises:
        AssetNotFound: The file does not exist.
        AssetInvalid: The file is not XML.
    """
    return _kinematic_urdf(path, _time_of(path, "a model"), tuple(fixed))


@lru_cache(maxsize=64)
def _kinematic_urdf(path: Path, written: int, fixed: tuple[str, ...]) -> str:
    root = _without_shapes(path, "visual", "collision")
    for joint in root.iterfind("joint"):
        if joint.get("name") in fixed:
            joint.set("type", "fixed")
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            limit = ET.SubElement(joint, "limit") if limit is None else limit
            limit.attrib.update(zip(("lower", "upper"), map(repr, CONTINUOUS), strict=True))
    return ET.tostring(root, encoding="unicode")


def solid_urdf(path: Path) -> str:
    """Return the text of a URDF file without visual elements.

    Raises:
        AssetNotFound: The file does not exist.
        AssetInvalid: The file is not XML.
    """
    return ET.tostring(_without_shapes(path, "visual"), encoding="unicode")


def _without_shapes(path: Path, *roles: str) -> ET.Element:
    """Return a URDF file without the elements of its links in these roles, `visual` or `collision`."""
    _time_of(path, "a model")
    root = _parse(path)
    for link in root.iterfind("link"):
        for shape in [shape for role in roles for shape in link.iterfind(role)]:
            link.remove(shape)
    return root


# Reading ----------------------------------------------------------------------------------------------------------


def _time_of(path: Path, needed_by: str) -> int:
    """Return the modification time of a file [ns]."""
    if not path.is_file():
        raise AssetNotFound(path, needed_by)
    return path.stat().st_mtime_ns


def _parse(path: Path) -> ET.Element:
    try:
        return ET.parse(path).getroot()
    except (ET.ParseError, LookupError) as error:
        raise AssetInvalid(path, f"it is not valid XML ({error})") from error


@lru_cache(maxsize=512)
def _disabled_pairs(srdf: Path, written: int) -> frozenset[frozenset[str]]:
    pairs = _parse(srdf).iterfind("disable_collisions")
    return frozenset(frozenset((pair.get("link1", ""), pair.get("link2", ""))) for pair in pairs)


@lru_cache(maxsize=512)
def _read_urdf(path: Path, written: int) -> Urdf:
    root = _parse(path)
    try:
        links = tuple(_link(path, element) for element in root.iterfind("link"))
        joints = tuple(_joint(element) for element in root.iterfind("joint"))
    except ValueError as error:
        raise AssetInvalid(path, str(error)) from error
    meshes = tuple(dict.fromkeys(_file(path, e) for e in root.iter("mesh")))
    textures = tuple(dict.fromkeys(_file(path, e) for tag in ("texture", "pattern") for e in root.iter(tag)))
    return Urdf(path, links, joints, meshes, textures, root.get("name", ""))


def _file(path: Path, element: ET.Element) -> Path:
    name = element.get("filename", "")
    if not name:
        raise AssetInvalid(path, f"a <{element.tag}> has no filename")
    return path.parent / name


def _numbers(element: ET.Element, key: str, default: str) -> tuple[float, ...]:
    numbers = tuple(float(word) for word in element.get(key, default).split())
    if not all(math.isfinite(number) for number in numbers):
        raise ValueError(f"'{key}' of a <{element.tag}> is not a finite number: {element.get(key)}")
    return numbers


def _vector(element: ET.Element, key: str, default: str = "0 0 0") -> Vector:
    numbers = _numbers(element, key, default)
    if len(numbers) != 3:
        raise ValueError(f"'{key}' of a <{element.tag}> has 3 numbers, not {len(numbers)}")
    return numbers[0], numbers[1], numbers[2]


def _origin(element: ET.Element) -> UrdfOrigin | None:
    origin = element.find("origin")
    return None if origin is None else UrdfOrigin(_vector(origin, "xyz"), _vector(origin, "rpy"))


def _link(path: Path, link: ET.Element) -> UrdfLink:
    visuals, collisions = (tuple(_shape(path, e) for e in link.iterfind(role)) for role in ("visual", "collision"))
    return UrdfLink(link.get("name", ""), visuals, collisions, _inertial(link))


def _shape(path: Path, element: ET.Element) -> UrdfShape:
    geometry, color = element.find("geometry"), element.find("material/color")
    shape = geometry[0] if geometry is not None and len(geometry) else None
    rgba = None if color is None else _numbers(color, "rgba", "1 1 1 1")
    finish = _finish(path, element)
    if shape is None:
        return UrdfShape("", (), None, _origin(element), rgba, finish)
    mesh = _file(path, shape) if shape.tag == "mesh" else None
    return UrdfShape(shape.tag, _size(shape), mesh, _origin(element), rgba, finish)


def _finish(path: Path, element: ET.Element) -> Finish:
    specular, emission, pattern = (element.find(f"material/{tag}") for tag in ("specular", "emission", "pattern"))
    size = 0.25 if pattern is None else _numbers(pattern, "size", "0.25")[0]
    if size <= 0.0:
        raise ValueError(f"'size' of a <pattern> is above 0, not {size}")
    return Finish(
        gloss=ZERO if specular is None else _vector(specular, "rgb"),
        emission=None if emission is None else _vector(emission, "rgb"),
        reach=0.0 if emission is None else _numbers(emission, "reach", "0")[0],
        pattern=None if pattern is None else _file(path, pattern),
        pattern_size=size,
    )


def _size(shape: ET.Element) -> tuple[float, ...]:
    """Return the value of `UrdfShape.size`; empty for an unknown shape."""
    if shape.tag == "box":
        return _vector(shape, "size", "")
    if shape.tag == "mesh":
        return _vector(shape, "scale", "1 1 1")
    (radius,), (length,) = _numbers(shape, "radius", "0"), _numbers(shape, "length", "0")
    return {"sphere": (radius,), "cylinder": (radius, length), "capsule": (radius, length)}.get(shape.tag, ())


def _inertial(link: ET.Element) -> UrdfInertial | None:
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    moments = tuple(0.0 if inertia is None else float(inertia.get(key, 0)) for key in _INERTIA)
    return UrdfInertial(0.0 if mass is None else float(mass.get("value", 0)), _origin(inertial), moments)


def _joint(joint: ET.Element) -> UrdfJoint:
    limit, axis, kind, limits = joint.find("limit"), joint.find("axis"), joint.get("type", ""), UNBOUNDED
    if limit is not None and kind != "continuous":
        limits = float(limit.get("lower", "0")), float(limit.get("upper", "0"))
    parent, child = ("" if e is None else e.get("link", "") for e in (joint.find("parent"), joint.find("child")))
    along = (1.0, 0.0, 0.0) if axis is None else _vector(axis, "xyz")
    mimic = joint.find("mimic")
    follows = None
    if mimic is not None:
        (ratio,), (offset,) = _numbers(mimic, "multiplier", "1"), _numbers(mimic, "offset", "0")
        follows = Follows(mimic.get("joint", ""), ratio, offset)
    effort, velocity = (0.0 if limit is None else _numbers(limit, key, "0")[0] for key in ("effort", "velocity"))
    own = joint.get("name", ""), kind, parent, child, limits, _origin(joint), along, follows
    return UrdfJoint(*own, effort if effort > 0.0 else None, velocity if velocity > 0.0 else None)


__all__ = [
    "CONTINUOUS",
    "UNBOUNDED",
    "ZERO",
    "Finish",
    "Follows",
    "Urdf",
    "UrdfInertial",
    "UrdfJoint",
    "UrdfLink",
    "UrdfOrigin",
    "UrdfShape",
    "disabled_pairs",
    "format_srdf",
    "kinematic_urdf",
    "read_urdf",
    "solid_urdf",
]
