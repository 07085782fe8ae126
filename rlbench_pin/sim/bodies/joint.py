"""A joint of an object: its value, its friction, its spring, its lock."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.scene.spec import JointSpec
from rlbench_pin.sim.bodies.model import JointInfo, LoadedModel
from rlbench_pin.sim.checks import InvalidNumbers
from rlbench_pin.sim.client import bullet
from rlbench_pin.values import as_number

_LOCK_FORCE = 1000.0  # [N] or [N m]
_LOCK_GAIN = 0.5


class ObjectJoint:
    """One movable joint of an object.

    Args:
        name: `<body>/<joint>`.
        model: The body it belongs to.
        info: What PyBullet says about it.
    """

    def __init__(self, name: str, model: LoadedModel, info: JointInfo) -> None:
        self.name, self.spec = name, JointSpec(name=name)
        self._model, self._info = model, info
        self._locked_at: float | None = None
        self._inertia = _link_inertia(model, info)
        self._drive()

    def configure(self, spec: JointSpec) -> None:
        """Take start value, friction, damping, spring and lock from the scene file."""
        self.spec = spec
        if spec.damping is not None:
            self._change(bullet.changeDynamics, jointDamping=spec.damping)
        self._reset(spec.position)
        self._locked_at = spec.position if spec.locked else None
        self._drive()

    @property
    def lower(self) -> float:
        """Lower limit [m] or [rad]; -inf without one."""
        return self._info.lower

    @property
    def upper(self) -> float:
        """Upper limit [m] or [rad]; inf without one."""
        return self._info.upper

    @property
    def position(self) -> float:
        """Value [m] or [rad]."""
        return self.state()[0]

    @property
    def velocity(self) -> float:
        """Speed [m/s] or [rad/s]."""
        return self.state()[1]

    def state(self) -> tuple[float, float]:
        """Value and speed."""
        state = bullet.getJointState(self._model.uid, self._info.index, physicsClientId=self._model.client.id)
        return state[0], state[1]

    def set_position(self, position: float) -> None:
        """Put the joint at a value [m] or [rad], at rest; a lock holds it there from now on."""
        value = as_number(position, f"The value of joint '{self.name}'", InvalidNumbers)
        self._reset(value)
        if self.locked:
            self.set_lock(value)

    def set_state(self, position: float, velocity: float) -> None:
        """Set value and speed, and leave the lock as it is."""
        position = as_number(position, f"The value of joint '{self.name}'", InvalidNumbers)
        self._reset(position, as_number(velocity, f"The speed of joint '{self.name}'", InvalidNumbers))

    @property
    def locked(self) -> bool:
        """Whether a stiff motor holds the joint."""
        return self._locked_at is not None

    @property
    def lock_position(self) -> float | None:
        """Value at which the joint is locked; None when it is free."""
        return self._locked_at

    def lock(self) -> None:
        """Hold the joint where it is."""
        self.set_lock(self.position)

    def unlock(self) -> None:
        """Let the joint move."""
        self.set_lock(None)

    def set_lock(self, position: float | None) -> None:
        """Hold the joint at a value [m] or [rad], or let it move.

        Raises:
            InvalidNumbers: It is no finite number (also a ValueError).
        """
        if position is not None:
            position = as_number(position, f"The value of joint '{self.name}'", InvalidNumbers)
        if position != self._locked_at:
            self._locked_at = position
            self._drive()

    def _reset(self, position: float, velocity: float = 0.0) -> None:
        self._change(bullet.resetJointState, position, targetVelocity=velocity)

    def _change(self, function: Callable[..., None], *positional: float, **named: float) -> None:
        self._model.client.change(function, self._model.uid, self._info.index, *positional, **named)

    def _drive(self) -> None:
        """Set PyBullet's motor as lock and friction require."""
        if self._locked_at is not None:
            self._change(
                bullet.setJointMotorControl2,
                controlMode=bullet.POSITION_CONTROL,
                targetPosition=self._locked_at,
                positionGain=_LOCK_GAIN,
                velocityGain=1.0,
                force=_LOCK_FORCE,
            )
        else:
            friction = self.spec.friction
            self._change(bullet.setJointMotorControl2, controlMode=bullet.VELOCITY_CONTROL, targetVelocity=0.0, force=friction)

    # Spring ----------------------------------------------------------------------------------------------------------

    @property
    def has_spring(self) -> bool:
        """Whether a spring pulls the joint."""
        return self.spec.spring is not None

    def pull(self, timestep: float) -> None:
        """Apply the spring's force for one physics step of length `timestep` [s].

        The force is k (rest - x) - d v. When k dt^2 + d dt exceeds the moving inertia the explicit force would grow from step
        to step, so it is scaled down to what an implicit step would give.
        """
        spring = self.spec.spring
        if spring is None or self._locked_at is not None:
            return
        position, velocity = self.state()
        force = spring.stiffness * (spring.rest - position) - spring.damping * velocity
        demand = (spring.stiffness * timestep + spring.damping) * timestep
        force *= min(1.0, self._inertia / demand) if demand > 0.0 else 1.0
        limit = spring.max_force if spring.max_force is not None else float("inf")
        force = max(-limit, min(limit, force))
        bullet.setJointMotorControl2(
            self._model.uid, self._info.index, bullet.TORQUE_CONTROL, force=force, physicsClientId=self._model.client.id
        )


def _link_inertia(model: LoadedModel, info: JointInfo) -> float:
    """Inertia that the joint moves [kg] or [kg m^2], of its own link alone."""
    dynamics = bullet.getDynamicsInfo(model.uid, info.index, physicsClientId=model.client.id)
    return float(dynamics[0]) if info.prismatic else float(max(dynamics[2]))
