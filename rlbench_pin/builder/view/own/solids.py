"""Solids of a link: the mass, centre and moments that they have together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh

from rlbench_pin.spatial import FloatArray

DENSITY = 500.0
"""Of what is given no mass [kg/m^3]: wood."""
MOMENTS = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
"""Names of moments of inertia in a URDF file, and where they stand in a matrix."""


@dataclass(frozen=True, eq=False)
class OwnAsset:
    """Files of an asset."""

    urdf: str
    """Name of its URDF file, among `files`."""
    files: dict[str, bytes]
    """Name -> content."""


@dataclass(frozen=True, eq=False)
class Inertia:
    """Mass distribution of a link."""

    mass: float
    """[kg]."""
    center: FloatArray
    """Centre of mass (3,) in the link frame [m]."""
    moments: FloatArray
    """About the centre, in axes of the link (3, 3) [kg m^2]."""


def inertia_of(solids: Sequence[trimesh.Trimesh], mass: float | None = None) -> Inertia:
    """Return the inertia of solids of even density, which are one body.

    Args:
        solids: Closed, in the link frame [m].
        mass: Of all together [kg]; None is that of wood.
    """
    volumes = np.array([solid.volume for solid in solids])
    center = volumes @ np.array([solid.center_mass for solid in solids]) / volumes.sum()
    mass = DENSITY * float(volumes.sum()) if mass is None else mass
    moments = np.sum([_moments(solid, center) for solid in solids], axis=0) * (mass / volumes.sum())
    return Inertia(mass, center, moments)


def _moments(solid: trimesh.Trimesh, center: FloatArray) -> FloatArray:
    """Return the moments (3, 3) of a solid of density 1 about a point."""
    away = solid.center_mass - center
    return np.asarray(solid.moment_inertia) + solid.volume * (away @ away * np.eye(3) - np.outer(away, away))


def written(numbers: Sequence[float] | FloatArray) -> str:
    """Return numbers as a URDF file has them."""
    return " ".join(f"{number:.6g}" for number in np.round(numbers, 9) + 0.0)
