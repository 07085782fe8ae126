"""URDF files of a box, a cylinder or a sphere, as a person would write them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from rlbench_pin.errors import InvalidValue
from rlbench_pin.values import as_choice, as_number, as_text

Vector3 = tuple[float, float, float]
Primitive = Literal["box", "cylinder", "sphere"]
"""A solid without a mesh."""
PRIMITIVES: tuple[Primitive, ...] = ("box", "cylinder", "sphere")
SIZES = {"box": ("x", "y", "z"), "cylinder": ("diameter", "height"), "sphere": ("diameter",)}
"""What the numbers of their sizes are [m]."""
_LARGEST = 2.0


def primitive_urdf(name: str, kind: Primitive, size: Sequence[float], mass: float, color: Sequence[float]) -> str:
    """Return a URDF file of one link around its centre, with the inertia of a solid of even density.

    Args:
        name: Of model and link.
        kind: Its shape.
        size: As `SIZES` says [m].
        mass: [kg].
        color: Red, green, blue from 0 to 1.

    Raises:
        InvalidValue: A size or the mass is not above 0, or there are too many or too few numbers.
    """
    words = SIZES[as_choice(kind, "kind", PRIMITIVES)]
    if len(size) != len(words):
        raise InvalidValue("size", size, f"has to be {', '.join(words)} [m]")
    lengths = [as_number(value, f"{word} [m]", above=0.0, most=_LARGEST) for word, value in zip(words, size)]
    mass = as_number(mass, "mass [kg]", above=0.0, most=100.0)
    rgba = " ".join(f"{as_number(share, 'colour', least=0.0, most=1.0):g}" for share in (*color[:3], 1.0))
    return _text(as_text(name, "name"), _shape(kind, lengths), mass, _moments(kind, lengths, mass), rgba)


def _text(name: str, shape: str, mass: float, moments: Vector3, rgba: str) -> str:
    geometry = f"      <geometry>{shape}</geometry>"
    x, y, z = (f"{moment:.6g}" for moment in moments)
    lines = (
        '<?xml version="1.0"?>',
        f'<robot name="{name}">',
        f'  <link name="{name}">',
        '    <contact><lateral_friction value="0.8"/></contact>',
        "    <inertial>",
        f'      <mass value="{mass:g}"/>',
        f'      <inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/>',
        "    </inertial>",
        "    <visual>",
        geometry,
        f'      <material name="{name}"><color rgba="{rgba}"/></material>',
        "    </visual>",
        "    <collision>",
        geometry,
        "    </collision>",
        "  </link>",
        "</robot>",
    )
    return "\n".join(lines) + "\n"


def _shape(kind: Primitive, size: Sequence[float]) -> str:
    if kind == "box":
        return f'<box size="{size[0]:g} {size[1]:g} {size[2]:g}"/>'
    if kind == "cylinder":
        return f'<cylinder radius="{size[0] / 2.0:g}" length="{size[1]:g}"/>'
    return f'<sphere radius="{size[0] / 2.0:g}"/>'


def _moments(kind: Primitive, size: Sequence[float], mass: float) -> Vector3:
    """Moments of inertia about the centre [kg m^2]."""
    if kind == "box":
        x, y, z = (side * side for side in size)
        return mass * (y + z) / 12.0, mass * (x + z) / 12.0, mass * (x + y) / 12.0
    if kind == "cylinder":
        radius, height = size[0] / 2.0, size[1]
        across = mass * (3.0 * radius**2 + height**2) / 12.0
        return across, across, mass * radius**2 / 2.0
    moment = 0.4 * mass * (size[0] / 2.0) ** 2
    return moment, moment, moment
