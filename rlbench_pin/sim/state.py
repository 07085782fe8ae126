"""Saving and restoring a world in memory, exactly.

PyBullet's own state holds positions, velocities and contacts. What it leaves out is kept beside it: motor commands, attachments,
collision filters, colours, locks, frames and the bodies added at run time.
"""

from __future__ import annotations

import weakref
import zlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.sim.arm.control import ArmControl
from rlbench_pin.sim.arm.grasp import Attachment
from rlbench_pin.sim.arm.gripper import FingerControl
from rlbench_pin.sim.bodies.body import Body, Color
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.server.contents import restore_bytes, to_bytes
from rlbench_pin.spatial import FloatArray

if TYPE_CHECKING:
    from rlbench_pin.sim.world import World

_FAR, _SPACING, _SHIFT = 1000.0, 20.0, 10.0  # [m]
_DETECTIONS = 20


class StateKeeper(Protocol):
    """Something beside the world that is saved and restored with it, in memory."""

    def state(self) -> object:
        """Return what is to be remembered; it is never changed afterwards."""
        ...

    def set_state(self, state: object) -> None:
        """Go back to what `state()` returned; the world has been restored before."""
        ...


@dataclass(frozen=True, eq=False)
class LogicalBodyState:
    """What PyBullet's state does not say of one body."""

    colors: dict[int, Color]
    collides: bool
    graspable: bool
    locks: dict[str, float | None]
    fixed: bool | None = None
    """Whether the body cannot move, where that differs from how it was loaded."""


@dataclass(frozen=True, eq=False)
class LogicalState:
    """What PyBullet's state does not say of a world."""

    ticks: int
    arm: ArmControl
    fingers: FingerControl
    attachments: tuple[Attachment, ...]
    frames: dict[str, tuple[str, FloatArray]]
    """Parent and local pose of each frame."""
    bodies: dict[str, LogicalBodyState]
    spawned: dict[str, BodySpec]
    quiet: tuple[tuple[str, int], ...] = ()
    """Bodies that were at rest, and at the end of how many ticks in a row; enough of them and a body sleeps."""
    kept: tuple[object, ...] | None = None
    """What each of `World.keepers` gave; None leaves them as they are."""


@dataclass(frozen=True, eq=False)
class DetachedPhysics:
    """PyBullet's part of a state of another server, as bytes."""

    data: bytes = field(repr=False)

    def restore(self, client: PhysicsClient) -> None:
        """Bring a server with the same bodies to this state."""
        restore_bytes(client, zlib.decompress(self.data))


class Physics:
    """PyBullet's part of a state: a number in its server or, when that server is to be built again, the bytes.

    Going on from the number and from the bytes differs in the last bits where bodies touch, so a portable one has no number.

    Args:
        client: The physics server, whose present state is taken.
        portable: Keep bytes, as another process will have.
    """

    def __init__(self, client: PhysicsClient, portable: bool = False) -> None:
        self.client = client
        self._number: int | None = None
        self._bytes = to_bytes(client) if portable else b""
        self._portable = portable
        if not portable:
            self.take()

    def __reduce__(self) -> tuple[type[DetachedPhysics], tuple[bytes]]:
        if not self._bytes:
            raise RlbenchPinError("This state of a world cannot be pickled. `TaskEnvironment.get_state()` gives one that can.")
        return DetachedPhysics, (zlib.compress(self._bytes, 1),)

    def restore(self, client: PhysicsClient) -> None:
        """Bring the server to this state."""
        if client is not self.client:
            raise RlbenchPinError("This state was saved by another world. Use arrays() and set_arrays() between worlds.")
        if self._number is not None:
            self.client.restore(stateId=self._number)
            return
        restore_bytes(self.client, self._bytes)
        if not self._portable:
            self.take()

    @property
    def has_bytes(self) -> bool:
        """Whether it outlasts its server."""
        return bool(self._bytes)

    def take_bytes(self) -> None:
        """Keep the server's present state, which must be this one, as bytes."""
        self._bytes = to_bytes(self.client)

    def take(self) -> None:
        """Take the server's present state."""
        self._number = bullet.saveState(physicsClientId=self.client.id)

    def forget(self) -> None:
        """Free the server's memory."""
        if self._number is not None and not self.client.closed:
            bullet.removeState(self._number, physicsClientId=self.client.id)
        self._number = None


@dataclass(frozen=True, eq=False)
class WorldState:
    """One instant of one world; only that world can restore it, unless it was pickled: then any with the same bodies can."""

    physics: Physics | DetachedPhysics
    logical: LogicalState


def save(world: World, portable: bool = False) -> WorldState:
    """Remember this instant; the physics server frees it when the returned object is gone. Only a portable one can be pickled."""
    logical = read_logical_state(world)
    world.gripper.set_attachments(world.gripper.attachments())  # as restoring does
    physics = Physics(world.client, portable)
    saved = WorldState(physics, logical)
    weakref.finalize(saved, physics.forget)
    world.saved_states.add(saved)
    _restore_physics(world, saved)
    return saved


def restore(world: World, saved: WorldState) -> None:
    """Go back to a remembered instant.

    Raises:
        RlbenchPinError: The state belongs to another world or, when it was pickled, to another scene.
    """
    if isinstance(saved.physics, DetachedPhysics):
        check_same_scene(world, saved.logical)
    elif saved.physics.client is not world.client:
        raise RlbenchPinError("This state was saved by another world. Use arrays() and set_arrays() between worlds.")
    write_logical_state(world, saved.logical)
    _restore_physics(world, saved)
    world.robot.forget_measurements()  # a keeper may have asked before


def check_same_scene(world: World, logical: LogicalState) -> None:
    """Raise RlbenchPinError unless a state of another world has the bodies and frames of this one."""
    here = {*world.room, *(n for n in world.bodies if n not in world.spawned)}
    there = {n for n in logical.bodies if n not in logical.spawned}
    if here != there or set(logical.frames) != set(world.frames):
        differing = sorted((here ^ there) | (set(logical.frames) ^ set(world.frames)))
        raise RlbenchPinError(f"The state is of another scene; only one of the two has {', '.join(differing[:6])}.")


def _restore_physics(world: World, saved: WorldState) -> None:
    separate_bodies(world)
    saved.physics.restore(world.client)
    world.resting.go_on(saved.logical.quiet)


def build_again(world: World) -> None:
    """Bring a world to its origin, in a physics server that was emptied and built again; saved states stay valid."""
    origin = world.origin
    for saved in world.saved_states:
        assert isinstance(saved.physics, Physics)
        if saved is not origin and not saved.physics.has_bytes:
            restore(world, saved)
            saved.physics.take_bytes()
        saved.physics.forget()
    write_logical_state(world, origin.logical)
    world.client.build_again()
    world.resting.forget()
    world.robot.keep_torques(False)
    world.robot.forget_measurements()
    assert isinstance(origin.physics, Physics)
    origin.physics.take()
    _restore_physics(world, origin)
    world.robot.forget_measurements()
    world.texture_overrides.apply_again()
    world.dynamics_overrides.apply_again()


def separate_bodies(world: World) -> None:
    """Take all bodies far apart, so that PyBullet forgets every contact.

    It restores only one set of contact points per pair of links. Where links are made of several convex parts the other sets
    would be left over from what happened before; after this they are computed afresh from the restored poses. Saving restores
    as well, so that going on after a save and after a restore is the same to the last bit.
    """
    world.robot.keep_torques()
    world.resting.rouse()  # boxes of what sleeps do not follow
    identifier = world.client.id
    models = (world.robot.model, *(body.model for body in (*world.room.values(), *world.bodies.values())))
    # Each call drops about a tenth of the pairs that no longer overlap, and only when something has moved since the last one.
    for detection in range(_DETECTIONS):
        for number, model in enumerate(models):
            x = _FAR + _SPACING * number + _SHIFT * (detection % 2)
            bullet.resetBasePositionAndOrientation(model.uid, [x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], physicsClientId=identifier)
        bullet.performCollisionDetection(physicsClientId=identifier)


def read_logical_state(world: World) -> LogicalState:
    """Collect what PyBullet's state leaves out."""
    return LogicalState(
        world.ticks,
        world.robot.control,
        world.gripper.control,
        world.gripper.attachments(),
        {name: frame.state() for name, frame in world.frames.items()},
        {name: _read_body(body) for name, body in (*world.bodies.items(), *world.room.items())},
        dict(world.spawned),
        world.resting.quiet,
        tuple(keeper.state() for keeper in world.keepers),
    )


def _read_body(body: Body) -> LogicalBodyState:
    return LogicalBodyState(
        body.colors,
        body.collides,
        body.graspable,
        {name: joint.lock_position for name, joint in body.joints.items()},
        None if body.fixed == body.loaded_fixed else body.fixed,
    )


def write_logical_state(world: World, logical: LogicalState) -> None:
    """Bring about what PyBullet's state leaves out; only differences cost time."""
    match_spawned(world, logical.spawned)
    world.gripper.set_attachments(logical.attachments)
    for name, body_state in logical.bodies.items():
        body = world.body(name)
        world.dynamics_overrides.set_fixed(body, body.loaded_fixed if body_state.fixed is None else body_state.fixed)
        _write_body(body, body_state)
    for name, (parent, local) in logical.frames.items():
        world.frames[name].set_state(parent, local)
    world.robot.set_control(logical.arm)
    world.gripper.set_control(logical.fingers)
    world.set_ticks(logical.ticks)
    for keeper, kept in zip(world.keepers, logical.kept or ()):
        keeper.set_state(kept)


def _write_body(body: Body, logical: LogicalBodyState) -> None:
    body.set_colors(logical.colors)
    body.set_collides(logical.collides)
    body.graspable = logical.graspable
    for name, lock in logical.locks.items():
        body.joints[name].set_lock(lock)


def match_spawned(world: World, wanted: dict[str, BodySpec]) -> None:
    """Keep the run-time bodies that both have from the first on, remove the rest, and add what is missing, in order.

    PyBullet restores bodies by their order, so a gap is closed by rebuilding everything behind it.
    """
    present = list(world.spawned.items())
    target = list(wanted.items())
    same = 0
    while same < min(len(present), len(target)) and present[same] == target[same]:
        same += 1
    for name, _ in reversed(present[same:]):
        world.remove_body(name)
    for name, spec in target[same:]:
        world.add_body(name, spec)
