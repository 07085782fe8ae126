"""Exact saving and restoring of a world: in memory, pickled, and as plain arrays for another process.

PyBullet's state contains positions, velocities and contacts. This module stores the rest: motor commands, attachments, collision
filters, colours, locks, frames and the bodies added at run time.
"""

from __future__ import annotations

import json
import weakref
import zlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.sim.arm.control import ArmControl
from rlbench_pin.sim.arm.grasp import Attachment
from rlbench_pin.sim.arm.gripper import FingerControl
from rlbench_pin.sim.body import Body, Color
from rlbench_pin.sim.client import PhysicsClient, bullet, restore_bytes, to_bytes
from rlbench_pin.sim.contents import Contents
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_record

_FAR, _SPACING, _SHIFT = 1000.0, 20.0, 10.0  # [m]
_DETECTIONS = 20


@dataclass(frozen=True, eq=False)
class LogicalBodyState:
    """The part of the state of one body that PyBullet's state does not contain."""

    colors: dict[int, Color]
    collides: bool
    graspable: bool
    locks: dict[str, float | None]
    fixed: bool | None = None
    """Whether the body cannot move, where that differs from how it was loaded."""


@dataclass(frozen=True, eq=False)
class LogicalState:
    """The part of the state of a world that PyBullet's state does not contain."""

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
    """State of each of `World.keepers`; None leaves them as they are."""


@dataclass(frozen=True, eq=False)
class DetachedPhysics:
    """PyBullet's part of a state of another server, as bytes."""

    data: bytes = field(repr=False)

    def restore(self, client: PhysicsClient) -> None:
        """Restore a server with the same bodies to this state."""
        restore_bytes(client, zlib.decompress(self.data))


class Physics:
    """PyBullet's part of a state: a number in its server or, if that server is built again, bytes.

    Continuations from the number and from the bytes differ in the last bits where bodies touch, so a portable one has no number.

    Args:
        client: The physics server, whose present state is saved.
        portable: Store bytes, which another process can use.
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
            raise RlbenchPinError("This state of a world cannot be pickled. Use a state from `TaskEnvironment.get_state()`.")
        return DetachedPhysics, (zlib.compress(self._bytes, 1),)

    def restore(self, client: PhysicsClient) -> None:
        """Restore the server to this state."""
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
        """Whether the state is independent of its server."""
        return bool(self._bytes)

    def take_bytes(self) -> None:
        """Store the present state of the server, which must be this state, as bytes."""
        self._bytes = to_bytes(self.client)

    def take(self) -> None:
        """Save the present state of the server."""
        self._number = bullet.saveState(physicsClientId=self.client.id)

    def forget(self) -> None:
        """Free the server's memory."""
        if self._number is not None and not self.client.closed:
            bullet.removeState(self._number, physicsClientId=self.client.id)
        self._number = None


@dataclass(frozen=True, eq=False)
class WorldState:
    """State of one world. Only that world can restore it; after pickling, any world with the same bodies can."""

    physics: Physics | DetachedPhysics
    logical: LogicalState


def save(world: Contents, portable: bool = False) -> WorldState:
    """Return the present state; the physics server frees it with the returned object. Only a portable one can be pickled."""
    logical = read_logical_state(world)
    world.gripper.set_attachments(world.gripper.attachments())  # as restoring does
    physics = Physics(world.client, portable)
    saved = WorldState(physics, logical)
    weakref.finalize(saved, physics.forget)
    _restore_server(world, physics.restore, logical)
    return saved


def restore(world: Contents, saved: WorldState) -> None:
    """Restore a saved state.

    Raises:
        RlbenchPinError: The state belongs to another world or, if it was pickled, to another scene.
    """
    if isinstance(saved.physics, DetachedPhysics):
        check_same_scene(world, saved.logical)
    elif saved.physics.client is not world.client:
        raise RlbenchPinError("This state was saved by another world. Use arrays() and set_arrays() between worlds.")
    write_logical_state(world, saved.logical)
    _restore_server(world, saved.physics.restore, saved.logical)
    world.robot.forget_measurements()  # a keeper may have asked before


def check_same_scene(world: Contents, logical: LogicalState) -> None:
    """Raise RlbenchPinError unless a state of another world has the bodies and frames of this one."""
    here = {*world.room, *(n for n in world.bodies if n not in world.spawned)}
    there = {n for n in logical.bodies if n not in logical.spawned}
    if here != there or set(logical.frames) != set(world.frames):
        differing = sorted((here ^ there) | (set(logical.frames) ^ set(world.frames)))
        problem = f"The state is of another scene: only one of the two has {', '.join(differing[:6])}"
        raise RlbenchPinError(f"{problem}. Load the scene of the state.")


def _restore_server(world: Contents, restore_state: Callable[[PhysicsClient], None], logical: LogicalState) -> None:
    """Restore the physics server to a state, without contacts from before."""
    separate_bodies(world)
    restore_state(world.client)
    world.resting.go_on(logical.quiet)


def build_again(world: Contents, origin: WorldState, saved_states: Iterable[WorldState]) -> None:
    """Restore a world to its origin in a physics server that is emptied and built again; saved states stay valid."""
    for saved in saved_states:
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
    _restore_server(world, origin.physics.restore, origin.logical)
    world.robot.forget_measurements()
    world.texture_overrides.apply_again()
    world.dynamics_overrides.apply_again()


def separate_bodies(world: Contents) -> None:
    """Move all bodies far apart, so that PyBullet drops all contacts.

    PyBullet restores only one set of contact points per pair of links. For links of several convex parts the other sets would be
    those from before; after this call they are computed from the restored poses. A save restores as well, so that continuations
    after a save and after a restore are bit-identical.
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


def read_logical_state(world: Contents) -> LogicalState:
    """Return the part of the state that PyBullet's state does not contain."""
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


def write_logical_state(world: Contents, logical: LogicalState) -> None:
    """Restore the part of the state that PyBullet's state does not contain; only differences cost time."""
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


def match_spawned(world: Contents, wanted: dict[str, BodySpec]) -> None:
    """Keep the common prefix of the run-time bodies, remove the others, and add the missing ones in order.

    PyBullet restores bodies by their order, so all bodies after a gap are loaded again.
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


_FORMAT = 1
_MAX_BYTES = 1 << 28
"""More than any state of a physics server."""
_KEYS = {"meta", "frame_poses", "arm_control", "finger_control", "finger_limits", "attachment_poses"}
_MEASURED = {"body_poses", "body_velocities", "joint_states", "robot_joints"}
"""Arrays that replace `physics` where it is missing."""


def to_arrays(world: Contents, exact: bool = True) -> dict[str, np.ndarray]:
    """Return the present state as arrays of numbers; `meta` is JSON text and `physics` a compressed PyBullet state, as bytes.

    All arrays except `physics` can be read without this package and are byte-identical for equal worlds. `physics` adds the
    contacts that a bit-exact continuation needs. It contains memory addresses, so that its bytes differ between runs.

    Args:
        world: The world.
        exact: Include `physics`.
    """
    logical = read_logical_state(world)
    arrays = _readable(world, logical)
    if exact:
        physics = to_bytes(world.client)
        _restore_server(
            world, lambda client: restore_bytes(client, physics), logical
        )  # as the other process will, so that both go on alike
        arrays["physics"] = _byte_array(zlib.compress(physics))
    return arrays


def _readable(world: Contents, logical: LogicalState) -> dict[str, np.ndarray]:
    bodies = list(logical.bodies)
    return {
        "meta": _byte_array(json.dumps(_meta(world, logical)).encode()),
        "body_poses": np.array([world.body(n).pose for n in bodies]).reshape(-1, 7),
        "body_velocities": np.array([world.body(n).velocity for n in bodies]).reshape(-1, 6),
        "joint_states": np.array([j.state() for n in bodies for j in world.body(n).joints.values()]).reshape(-1, 2),
        "robot_joints": world.robot.joint_states(),
        "frame_poses": np.array([local for _, local in logical.frames.values()]).reshape(-1, 7),
        "arm_control": np.stack(_rows(logical.arm)),
        "finger_control": np.stack([logical.fingers.target, logical.fingers.reference, logical.fingers.last]),
        "finger_limits": np.array([logical.fingers.speed, logical.fingers.force]),
        "attachment_poses": np.array([a.T_hand_body for a in logical.attachments]).reshape(-1, 7),
    }


def _rows(arm: ArmControl) -> list[np.ndarray]:
    """The numbers of a command; the last row exists only after a tick of torques."""
    return [arm.target, arm.reference] if arm.torques is None else [arm.target, arm.reference, arm.torques]


def _meta(world: Contents, logical: LogicalState) -> dict[str, Any]:
    return {
        "format": _FORMAT,
        "robot": world.robot.description.name,
        "ticks": logical.ticks,
        "arm_mode": logical.arm.mode,
        "bodies": {
            name: {
                "colors": {str(k): v for k, v in m.colors.items()},
                "collides": m.collides,
                "graspable": m.graspable,
                "locks": m.locks,
                **({} if m.fixed is None else {"fixed": m.fixed}),
            }
            for name, m in logical.bodies.items()
        },
        "frames": {name: parent for name, (parent, _) in logical.frames.items()},
        "attachments": [a.body for a in logical.attachments],
        "spawned": [spec.model_dump(mode="json") for spec in logical.spawned.values()],
        "quiet": dict(logical.quiet),
    }


def from_arrays(world: Contents, arrays: Mapping[str, np.ndarray]) -> None:
    """Continue from `to_arrays` of a world with the same scene and robot.

    Raises:
        RlbenchPinError: The arrays are incomplete or damaged, or belong to another scene, robot or version of this format.
    """
    as_record(arrays, Mapping, "arrays, what `World.arrays()` returned,")  # type: ignore[type-abstract]
    missing = (_KEYS if "physics" in arrays else _KEYS | _MEASURED) - set(arrays)
    if missing:
        raise RlbenchPinError(
            f"The arrays are incomplete: {', '.join(sorted(missing))} is missing. Pass all arrays from `World.arrays()`."
        )
    before = save(world)
    try:
        _continue_from(world, arrays)
    except RlbenchPinError:
        restore(world, before)
        raise
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as error:
        restore(world, before)
        problem = f"{type(error).__name__}: {error}"
        raise RlbenchPinError(f"The arrays are damaged ({problem}). Pass arrays from `World.arrays()` unchanged.") from error


def _continue_from(world: Contents, arrays: Mapping[str, np.ndarray]) -> None:
    meta = json.loads(np.asarray(arrays["meta"], dtype=np.uint8).tobytes())
    logical = _logical_state(meta, arrays)
    _check(world, meta, logical)
    if "physics" not in arrays:
        match_spawned(world, logical.spawned)
        _set_measured(world, arrays, list(logical.bodies))
        write_logical_state(world, logical)
        return
    try:
        reader = zlib.decompressobj()
        physics = reader.decompress(np.asarray(arrays["physics"], dtype=np.uint8).tobytes(), _MAX_BYTES)
    except zlib.error as error:
        raise RlbenchPinError(f"The array 'physics' is damaged: {error}. Use an intact copy.") from error
    if not reader.eof:
        raise RlbenchPinError("The array 'physics' is damaged: it was cut off, or is too large. Use an intact copy.")
    write_logical_state(world, logical)
    _restore_server(world, lambda client: restore_bytes(client, physics), logical)
    world.robot.forget_measurements()


def _set_measured(world: Contents, arrays: Mapping[str, np.ndarray], names: list[str]) -> None:
    """Set poses, joint positions and velocities from the arrays."""
    joints = np.asarray(arrays["robot_joints"], dtype=float)
    world.robot.set_joint_states(joints[0], joints[1])
    states = iter(np.asarray(arrays["joint_states"], dtype=float).reshape(-1, 2))
    for name, pose, velocity in zip(names, arrays["body_poses"], arrays["body_velocities"], strict=True):
        body = world.body(name)
        body.place(pose)
        if not body.fixed:
            body.set_velocity(velocity)
        for joint in body.joints.values():
            joint.set_state(*next(states))


def _logical_state(meta: dict[str, Any], arrays: Mapping[str, np.ndarray]) -> LogicalState:
    arm, fingers, limits = (np.array(arrays[k], dtype=float) for k in ("arm_control", "finger_control", "finger_limits"))
    frames = np.array(arrays["frame_poses"], dtype=float).reshape(-1, 7)
    held = np.array(arrays["attachment_poses"], dtype=float).reshape(-1, 7)
    specs = [BodySpec.model_validate(s) for s in meta["spawned"]]
    return LogicalState(
        ticks=meta["ticks"],
        arm=ArmControl(meta["arm_mode"], *arm),
        fingers=FingerControl(fingers[0], fingers[1], float(limits[0]), float(limits[1]), fingers[2]),
        attachments=tuple(Attachment(n, pose) for n, pose in zip(meta["attachments"], held, strict=True)),
        frames={n: (parent, local) for (n, parent), local in zip(meta["frames"].items(), frames, strict=True)},
        bodies={name: _body_state(entry) for name, entry in meta["bodies"].items()},
        spawned={spec.name: spec for spec in specs},
        quiet=tuple(meta.get("quiet", {}).items()),
    )


def _body_state(entry: dict[str, Any]) -> LogicalBodyState:
    colors = {int(k): tuple(v) for k, v in entry["colors"].items()}
    return LogicalBodyState(colors, entry["collides"], entry["graspable"], entry["locks"], entry.get("fixed"))


def _check(world: Contents, meta: dict[str, Any], logical: LogicalState) -> None:
    if meta["format"] != _FORMAT:
        raise RlbenchPinError(f"The arrays have format {meta['format']}, not {_FORMAT}. Use the release that wrote them.")
    if meta["robot"] != world.robot.description.name:
        problem = f"The arrays are of the arm '{meta['robot']}', not '{world.robot.description.name}'"
        raise RlbenchPinError(f"{problem}. Build a world with that arm.")
    check_same_scene(world, logical)


def _byte_array(data: bytes) -> np.ndarray:
    return np.frombuffer(data, dtype=np.uint8).copy()
