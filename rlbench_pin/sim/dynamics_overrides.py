"""Scaled masses, friction, damping and gains, and the way back to the exact original values."""

from __future__ import annotations

from typing import Any

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim.arm.robot import POSITION_GAIN, SimRobot
from rlbench_pin.sim.bodies.body import Body
from rlbench_pin.sim.bodies.model import BASE, LoadedModel
from rlbench_pin.sim.client import bullet
from rlbench_pin.urdf import read_urdf

_HELD = {"mass": 0.0, "localInertiaDiagonal": [0.0, 0.0, 0.0]}
"""What keeps a body at its place; PyBullet moves nothing that has no mass and is at rest."""


class DynamicsOverrides:
    """Masses, friction, damping and gains that differ from those of the model files.

    Args:
        robot: The arm, whose motors can be made stiffer or softer.
    """

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self._originals: dict[tuple[int, int], dict[str, Any]] = {}
        self._changed: dict[tuple[int, int], dict[str, Any]] = {}
        self._held: set[int] = set()

    def scale(self, model: LoadedModel, *, mass: float = 1.0, friction: float = 1.0, damping: float = 1.0) -> None:
        """Multiply masses (with their inertia), friction coefficients and joint damping of all links of a body."""
        for link in model.links.values():
            original = self._original(model, link)
            changed = {
                "mass": original["mass"] * mass,
                "localInertiaDiagonal": [i * mass for i in original["localInertiaDiagonal"]],
                "lateralFriction": original["lateralFriction"] * friction,
            }
            if "jointDamping" in original:
                changed["jointDamping"] = original["jointDamping"] * damping
            self._change(model, link, changed)

    def mass(self, model: LoadedModel, link: int) -> float:
        """Mass of a link [kg] that it has, or would have if it could move."""
        return float(self._changed.get((model.uid, link), {}).get("mass") or self._original(model, link)["mass"])

    def set_mass(self, model: LoadedModel, link: int, mass: float) -> None:
        """Give a link another mass [kg]; its inertia grows alike. What is held at its place has it once it can move.

        Raises:
            RlbenchPinError: The link has no mass in its model file.
        """
        original = self._original(model, link)
        if not original["mass"] > 0.0:
            raise RlbenchPinError(f"A link of {model.urdf.name} has no mass there, and so no inertia to scale.")
        factor = mass / original["mass"]
        self._change(model, link, {"mass": mass, "localInertiaDiagonal": [i * factor for i in original["localInertiaDiagonal"]]})

    def set_fixed(self, body: Body, fixed: bool) -> None:
        """Hold a body at its place, or let it move; it begins at rest.

        Raises:
            RlbenchPinError: The body has joints, or no mass in its model file.
        """
        if fixed == body.fixed:
            return
        model = body.model
        if model.joints:
            raise RlbenchPinError(f"'{body.name}' has joints; only the scene file can say whether it is `fixed`.")
        original = self._original(model, BASE)
        if not original["mass"] > 0.0:
            raise RlbenchPinError(f"'{body.name}' has no mass in {model.urdf.name}, so that it cannot move.")
        body.hold(fixed)
        if fixed:
            self._held.add(model.uid)
        else:
            self._held.discard(model.uid)
        masses = {"mass": original["mass"], "localInertiaDiagonal": original["localInertiaDiagonal"]}
        self._change(model, BASE, {**masses, **self._changed.get((model.uid, BASE), {})})

    def friction(self, model: LoadedModel, link: int) -> float:
        """Coefficient of sliding friction of a link."""
        return float(bullet.getDynamicsInfo(model.uid, link, physicsClientId=model.client.id)[1])

    def set_friction(self, model: LoadedModel, link: int, friction: float) -> None:
        """Give a link another coefficient of sliding friction."""
        self._original(model, link)
        self._change(model, link, {"lateralFriction": friction})

    def forget(self, model: LoadedModel) -> None:
        """Forget a body that is taken away."""
        self._held.discard(model.uid)
        for links in (self._originals, self._changed):
            for key in [k for k in links if k[0] == model.uid]:
                del links[key]

    def scale_gains(self, factor: float) -> None:
        """Multiply the position gain of the arm's motors."""
        self._robot.position_gain = POSITION_GAIN * factor

    def clear(self) -> None:
        """Restore all original values."""
        self._robot.position_gain = POSITION_GAIN
        for (uid, link), original in self._originals.items():
            self._apply(uid, link, original)
        self._originals.clear()
        self._changed.clear()

    def apply_again(self) -> None:
        """Apply the present overrides in a physics server that was built again."""
        for (uid, link), changed in self._changed.items():
            self._apply(uid, link, changed)

    def _change(self, model: LoadedModel, link: int, changed: dict[str, Any]) -> None:
        self._changed[model.uid, link] = {**self._changed.get((model.uid, link), {}), **changed}
        self._apply(model.uid, link, self._changed[model.uid, link])

    def _apply(self, uid: int, link: int, values: dict[str, Any]) -> None:
        held = _HELD if link == BASE and uid in self._held else {}
        client = self._robot.model.client
        client.changes += 1
        bullet.changeDynamics(uid, link, physicsClientId=client.id, **{**values, **held})

    def _original(self, model: LoadedModel, link: int) -> dict[str, Any]:
        key = (model.uid, link)
        if key not in self._originals:
            info = bullet.getDynamicsInfo(model.uid, link, physicsClientId=model.client.id)
            values: dict[str, Any] = {"mass": info[0], "localInertiaDiagonal": info[2], "lateralFriction": info[1]}
            if link == BASE and values["mass"] == 0.0:
                self._held.add(model.uid)
                values |= _inertial_of_file(model)
            if link >= 0:
                values["jointDamping"] = bullet.getJointInfo(model.uid, link, physicsClientId=model.client.id)[6]
            self._originals[key] = values
        return self._originals[key]


def _inertial_of_file(model: LoadedModel) -> dict[str, Any]:
    """Mass and inertia of the base link in the model file; PyBullet forgets those of what is loaded fixed."""
    urdf = read_urdf(model.urdf)
    inertial = next(link.inertial for link in urdf.links if link.name == urdf.base_link)
    if inertial is None:
        return {"mass": 0.0, "localInertiaDiagonal": [0.0, 0.0, 0.0]}
    return {"mass": inertial.mass, "localInertiaDiagonal": [inertial.inertia[k] for k in (0, 3, 5)]}
