"""What forms show of the Python of a task: plain records that compare by value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

LookupKind = Literal["body", "joint", "frame", "region", "sensor"]
"""What the world is asked for."""


@dataclass(frozen=True)
class Named:
    """A thing of the scene, `self.world.<kind>("<name>")`."""

    kind: LookupKind
    """What the world is asked for."""
    name: str
    """Its name in the scene."""


@dataclass(frozen=True)
class Written:
    """An expression that no form can show; it stays as it is written."""

    text: str
    """The Python of it."""


@dataclass(frozen=True)
class ConditionForm:
    """A condition with what it is made of."""

    kind: str
    """Its class, such as `Detected`."""
    arguments: Mapping[str, Argument] = field(default_factory=dict)
    """Name of a parameter -> value, those at their default left out; arm and hand are given by themselves."""


Argument = Named | Written | ConditionForm | tuple["Argument", ...] | float | int | bool | str | None
"""What a condition is made of."""

Rotation = tuple[float, float, float]
"""Roll, pitch, yaw [rad]."""


@dataclass(frozen=True)
class SpawnedForm:
    """A thing that is put at a random place."""

    thing: Named | Written
    """A body or a frame."""
    min_rotation: Rotation | None = None
    """Lowest turn; None for any yaw."""
    max_rotation: Rotation | None = None
    """Highest turn; None for any yaw."""
    min_distance: float | None = None
    """Least distance from what was placed before [m]; None for 1 cm."""
    ignore_collisions: bool = False
    """Do not look at what was placed before."""


@dataclass(frozen=True)
class SpawnForm:
    """Regions in which things are placed, one after another."""

    regions: tuple[str, ...]
    """Names of the regions."""
    things: tuple[SpawnedForm, ...] = ()
    """What is placed in them, in order."""


ParameterKind = Literal[
    "body", "place", "joint", "frame", "sensor", "number", "whole", "flag", "numbers", "points", "conditions", "places"
]
"""What a form asks for; a place is a body or a frame, points are lists of three coordinates."""


@dataclass(frozen=True)
class Parameter:
    """What a form asks for one argument of a condition."""

    name: str
    """Name of the argument."""
    kind: ParameterKind
    """What it is."""
    text: str
    """What it means."""
    required: bool
    """Whether there is no default."""
    default: object = None
    """Its value when it is left out."""


@dataclass(frozen=True)
class ConditionKind:
    """A condition that a form can make."""

    name: str
    """Its class."""
    text: str
    """When it holds, in a sentence."""
    parameters: tuple[Parameter, ...]
    """What it is made of, arm and hand left out."""
