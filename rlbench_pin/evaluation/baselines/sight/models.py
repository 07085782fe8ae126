"""Known object models: the surface of a model file at given joint values, as points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pinocchio as pin

from rlbench_pin.assets import asset_path
from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import UrdfLink, kinematic_urdf, read_urdf

SPACING = 0.006
"""Mean distance of points on a surface [m]."""
MOST = 6000
"""Points of one link at most."""
NO_JOINTS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Axis:
    """Where a joint is, in the frame of the model."""

    origin: FloatArray
    """A point on the axis (3,) [m]."""
    direction: FloatArray
    """Unit vector (3,): the axis of a hinge, the way of a slide."""


@dataclass(frozen=True, eq=False)
class KnownModel:
    """Kinematics and surface of an object."""

    kinematics: pin.Model
    """Its joints."""
    surfaces: Mapping[str, FloatArray]
    """Link -> points on its visible surface, in the frame of the link (n, 3) [m]."""

    @classmethod
    def named(cls, name: str) -> KnownModel:
        """Return the model of `objects/<name>.urdf` of the package, `chest/chest` for example."""
        return cls.load(asset_path(f"objects/{name}.urdf"))

    @classmethod
    def load(cls, urdf: Path) -> KnownModel:
        """Return the model of a URDF file; read once."""
        return _load(urdf)

    def points_at(self, joints: Mapping[str, float] = NO_JOINTS) -> FloatArray:
        """Return the surface of all links at joint values, 0 where none is given, in the frame of the model (n, 3) [m]."""
        return np.concatenate([self.link_points(link, joints) for link in self.surfaces])

    def link_points(self, link: str, joints: Mapping[str, float] = NO_JOINTS) -> FloatArray:
        """Return the surface of one link in the frame of the model (n, 3) [m]."""
        placement = self.placement(link, joints)
        return self.surfaces[link] @ placement.rotation.T + placement.translation

    def placement(self, link: str, joints: Mapping[str, float] = NO_JOINTS) -> pin.SE3:
        """Return the frame of a link in that of the model."""
        data = self.kinematics.createData()
        pin.framesForwardKinematics(self.kinematics, data, self._configuration(joints))
        return data.oMf[self.kinematics.getFrameId(link)].copy()

    def axis(self, joint: str, joints: Mapping[str, float] = NO_JOINTS) -> Axis:
        """Return where a joint is."""
        data, number = self.kinematics.createData(), self.kinematics.getJointId(joint)
        q = self._configuration(joints)
        pin.computeJointJacobians(self.kinematics, data, q)
        column = pin.getJointJacobian(self.kinematics, data, number, pin.LOCAL_WORLD_ALIGNED)
        moving = np.reshape(column, (6, -1))[:, self.kinematics.joints[number].idx_v]
        turning = moving[3:] if np.linalg.norm(moving[3:]) > 0.5 else moving[:3]
        return Axis(data.oMi[number].translation.copy(), turning.copy())

    def _configuration(self, joints: Mapping[str, float]) -> FloatArray:
        q = pin.neutral(self.kinematics)
        for name, value in joints.items():
            q[self.kinematics.joints[self.kinematics.getJointId(name)].idx_q] = value
        return q


@cache
def _load(urdf: Path) -> KnownModel:
    surfaces = {link.name: points for link in read_urdf(urdf).links if len(points := _sampled(link))}
    return KnownModel(pin.buildModelFromXML(kinematic_urdf(urdf)), MappingProxyType(surfaces))


def _sampled(link: UrdfLink) -> FloatArray:
    """Return points spread evenly over the visuals of a link; the same at every call."""
    rng = np.random.default_rng(0)
    corners = [shape_surface(shape) for shape in link.visuals]
    if not corners:
        return np.zeros((0, 3))
    triangles = np.concatenate([points[numbers] for points, numbers in corners])
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = 0.5 * np.linalg.norm(across, axis=1)
    count = int(min(MOST, max(40.0, areas.sum() / SPACING**2)))
    chosen = triangles[rng.choice(len(triangles), size=count, p=areas / areas.sum())]
    a, b = rng.random((2, count, 1))
    flip = a + b > 1.0
    a, b = np.where(flip, 1.0 - a, a), np.where(flip, 1.0 - b, b)
    points: FloatArray = chosen[:, 0] + a * (chosen[:, 1] - chosen[:, 0]) + b * (chosen[:, 2] - chosen[:, 0])
    return points
