"""Scaled masses, friction, damping and gains, and the way back to the exact original values."""

from __future__ import annotations

from typing import Any

from rlbench_pin.sim.arm.robot import POSITION_GAIN, SimRobot
from rlbench_pin.sim.bodies.model import LoadedModel
from rlbench_pin.sim.client import bullet


class DynamicsOverrides:
    """Masses, friction, damping and gains that differ from those of the model files.

    Args:
        robot: The arm, whose motors can be made stiffer or softer.
    """

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self._originals: dict[tuple[int, int], dict[str, Any]] = {}
        self._changed: dict[tuple[int, int], dict[str, Any]] = {}

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
        """Mass of a link [kg], 0 when it cannot move."""
        return float(bullet.getDynamicsInfo(model.uid, link, physicsClientId=model.client.id)[0])

    def set_mass(self, model: LoadedModel, link: int, mass: float) -> None:
        """Give a link another mass [kg]; its inertia grows alike."""
        original = self._original(model, link)
        factor = mass / original["mass"]
        self._change(model, link, {"mass": mass, "localInertiaDiagonal": [i * factor for i in original["localInertiaDiagonal"]]})

    def friction(self, model: LoadedModel, link: int) -> float:
        """Coefficient of sliding friction of a link."""
        return float(bullet.getDynamicsInfo(model.uid, link, physicsClientId=model.client.id)[1])

    def set_friction(self, model: LoadedModel, link: int, friction: float) -> None:
        """Give a link another coefficient of sliding friction."""
        self._original(model, link)
        self._change(model, link, {"lateralFriction": friction})

    def forget(self, model: LoadedModel) -> None:
        """Forget a body that is taken away."""
        for links in (self._originals, self._changed):
            for key in [k for k in links if k[0] == model.uid]:
                del links[key]

    def scale_gains(self, factor: float) -> None:
        """Multiply the position gain of the arm's motors."""
        self._robot.position_gain = POSITION_GAIN * factor

    def clear(self) -> None:
        """Restore all original values."""
        self._robot.position_gain = POSITION_GAIN
        identifier = self._robot.model.client.id
        for (uid, link), original in self._originals.items():
            bullet.changeDynamics(uid, link, physicsClientId=identifier, **original)
        self._originals.clear()
        self._changed.clear()

    def apply_again(self) -> None:
        """Apply the present overrides in a physics server that was built again."""
        for (uid, link), changed in self._changed.items():
            bullet.changeDynamics(uid, link, physicsClientId=self._robot.model.client.id, **changed)

    def _change(self, model: LoadedModel, link: int, changed: dict[str, Any]) -> None:
        self._changed[model.uid, link] = {**self._changed.get((model.uid, link), {}), **changed}
        bullet.changeDynamics(model.uid, link, physicsClientId=model.client.id, **changed)

    def _original(self, model: LoadedModel, link: int) -> dict[str, Any]:
        key = (model.uid, link)
        if key not in self._originals:
            info = bullet.getDynamicsInfo(model.uid, link, physicsClientId=model.client.id)
            values: dict[str, Any] = {"mass": info[0], "localInertiaDiagonal": info[2], "lateralFriction": info[1]}
            if link >= 0:
                values["jointDamping"] = bullet.getJointInfo(model.uid, link, physicsClientId=model.client.id)[6]
            self._originals[key] = values
        return self._originals[key]
