"""Analytic derivatives of kinematics and dynamics, and the inertia of held bodies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rlbench_pin.robot.geometry import to_placement
from rlbench_pin.robot.model import LARGEST, VELOCITY, FrameChoice, RobotModel
from rlbench_pin.scene.snapshot import NO_FILE, BodySnapshot, WorldSnapshot
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.urdf import read_urdf
from rlbench_pin.values import as_record, as_vector


@dataclass(frozen=True, eq=False)
class DynamicsDerivatives:
    """Partial derivatives of a torque or an acceleration (n,), each of shape (n, n)."""

    by_q: FloatArray
    """Derivative by the configuration, shape (n, n)."""
    by_v: FloatArray
    """Derivative by the joint velocity, shape (n, n)."""
    by_input: FloatArray
    """Derivative by the acceleration for inverse dynamics (the inertia), by the torque for forward dynamics (its inverse)."""


def inverse_dynamics_derivatives(model: RobotModel, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> DynamicsDerivatives:
    """Return the derivatives of `model.inverse_dynamics(q, v, a)`; arguments of shape (n,), [rad], [rad/s], [rad/s^2]."""
    q, v, a = _checked(model, q, v, a, "joint acceleration")
    by_q, by_v, by_a = pin.computeRNEADerivatives(model.arm, model.data, q, v, a)
    upper = np.triu(by_a)
    return DynamicsDerivatives(np.array(by_q), np.array(by_v), upper + np.triu(upper, 1).T)


def forward_dynamics_derivatives(model: RobotModel, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> DynamicsDerivatives:
    """Return the derivatives of `model.forward_dynamics(q, v, tau)`; arguments of shape (n,), [rad], [rad/s], [N m]."""
    q, v, tau = _checked(model, q, v, tau, "joint torque")
    by_q, by_v, by_tau = pin.computeABADerivatives(model.arm, model.data, q, v, tau)
    upper = np.triu(by_tau)
    return DynamicsDerivatives(np.array(by_q), np.array(by_v), upper + np.triu(upper, 1).T)


def jacobian_derivative(model: RobotModel, q: ArrayLike, frame: FrameChoice = "world") -> FloatArray:
    """Return dJ/dq of the tip Jacobian, shape (n, 6, n): entry k is the derivative by joint k; dJ/dt = sum_k v_k dJ/dq_k."""
    as_record(model, RobotModel, "model")
    return np.stack([model.jacobian_dot(q, axis, frame) for axis in np.eye(model.size)])


def manipulability_gradient(model: RobotModel, q: ArrayLike) -> FloatArray:
    """Return the gradient (n,) of m = `model.manipulability(q)`: dm/dq_k = m trace((J J^T)^-1 dJ/dq_k J^T); 0 where m is 0."""
    as_record(model, RobotModel, "model")
    jacobian, manipulability = model.jacobian(q), model.manipulability(q)
    if manipulability == 0.0:
        return np.zeros(model.size)
    inverse = np.linalg.solve(jacobian @ jacobian.T, jacobian)
    return manipulability * np.einsum("kij,ij->k", jacobian_derivative(model, q), inverse)


def _checked(
    model: RobotModel, q: ArrayLike, v: ArrayLike, last: ArrayLike, what: str
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return configuration, velocity and a third vector of an arm, or raise InvalidValue."""
    size = as_record(model, RobotModel, "model").size
    named = ((q, "configuration"), (v, VELOCITY), (last, what))
    q, v, last = (as_vector(vector, size, name, most=LARGEST) for vector, name in named)
    return q, v, last


def payload_inertia(model: RobotModel, snapshot: WorldSnapshot) -> pin.Inertia:
    """Return the inertia of all held bodies in the frame of the last arm joint, without bodies that are fixed to the world."""
    as_record(model, RobotModel, "model")
    as_record(snapshot, WorldSnapshot, "snapshot")
    total = pin.Inertia.Zero()
    held = [body for body in snapshot.bodies if body.name in snapshot.attached and not body.fixed]
    if held:
        pin.forwardKinematics(model.arm, model.data, np.asarray(snapshot.arm, dtype=float))
        T_joint_world = model.data.oMi[model.size].inverse()
        for body in held:
            total += T_joint_world.act(_body_inertia(body))
    return total


def _body_inertia(body: BodySnapshot) -> pin.Inertia:
    """Return the inertia of one body in the world."""
    total = pin.Inertia.Zero()
    links = {} if body.urdf == NO_FILE else _link_inertias(body.urdf)
    for name, pose in zip(body.link_names, body.link_poses, strict=True):
        if name in links:
            total += pose_to_se3(pose).act(_scaled(links[name], body.masses.get(name), body.scale))
    return total


def _scaled(inertia: pin.Inertia, mass: float | None, scale: float) -> pin.Inertia:
    """Return the inertia of a link with another mass [kg], None for its own, and all lengths multiplied by a factor."""
    mass = inertia.mass if mass is None else mass
    return pin.Inertia(mass, scale * inertia.lever, (mass / inertia.mass * scale**2) * inertia.inertia)


@cache
def _link_inertias(urdf: Path) -> dict[str, pin.Inertia]:
    """Return the inertia of each link in its link frame; links without mass are omitted."""
    found: dict[str, pin.Inertia] = {}
    for link in read_urdf(urdf).links:
        if link.inertial is not None and link.inertial.mass > 0.0:
            inertia = pin.Inertia(link.inertial.mass, np.zeros(3), _tensor(link.inertial.inertia))
            found[link.name] = to_placement(link.inertial.origin).act(inertia)
    return found


def _tensor(moments: tuple[float, ...]) -> FloatArray:
    """Return the symmetric matrix (3, 3) of ixx, ixy, ixz, iyy, iyz, izz."""
    xx, xy, xz, yy, yz, zz = moments
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
