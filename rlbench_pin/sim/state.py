"""Saving and restoring a world, exactly: in memory, pickled, and as plain arrays that another process can continue from.

PyBullet's own state holds positions, velocities and contacts. What it leaves out is kept beside it: motor commands, attachments,
collision filters, colours, locks, frames and the bodies added at run time.
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
    """The part of the state of one body that PyBullet's state leaves out."""

    colors: dict[int, Color]
    collides: bool
    graspable: bool
    locks: dict[str, float | None]
    fixed: bool | None = None
    """Whether the body cannot move, where that differs from how it was loaded."""


@dataclass(frozen=True, eq=False)
class LogicalState:
    """The part of the state of a world that PyBullet's state leaves out."""

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


def save(world: Contents, portable: bool = False) -> WorldState:
    """Remember this instant; the physics server frees it when the returned object is gone. Only a portable one can be pickled."""
    logical = read_logical_state(world)
    world.gripper.set_attachments(world.gripper.attachments())  # as restoring does
    physics = Physics(world.client, portable)
    saved = WorldState(physics, logical)
    weakref.finalize(saved, physics.forget)
    _restore_server(world, physics.restore, logical)
    return saved


def restore(world: Contents, saved: WorldState) -> None:
    """Go back to a remembered instant.

    Raises:
        RlbenchPinError: The state belongs to another world or, when it was pickled, to another scene.
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
        raise RlbenchPinError(f"The state is of another scene; only one of the two has {', '.join(differing[:6])}.")


def _restore_server(world: Contents, restore_state: Callable[[PhysicsClient], None], logical: LogicalState) -> None:
    """Bring the physics server to a state, without contacts of what happened before."""
    separate_bodies(world)
    restore_state(world.client)
    world.resting.go_on(logical.quiet)


def build_again(world: Contents, origin: WorldState, saved_states: Iterable[WorldState]) -> None:
    """Bring a world to its origin, in a physics server that was emptied and built again; saved states stay valid."""
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


def read_logical_state(world: Contents) -> LogicalState:
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


def write_logical_state(world: Contents, logical: LogicalState) -> None:
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


def match_spawned(world: Contents, wanted: dict[str, BodySpec]) -> None:
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


_FORMAT = 1
_MAX_BYTES = 1 << 28
"""More than any state of a physics server."""
_KEYS = {"meta", "frame_poses", "arm_control", "finger_control", "finger_limits", "attachment_poses"}
_MEASURED = {"body_poses", "body_velocities", "joint_states", "robot_joints"}
"""Arrays that replace `physics` where it is missing."""


def to_arrays(world: Contents, exact: bool = True) -> dict[str, np.ndarray]:
    """Return this instant as arrays of numbers; `meta` is JSON text and `physics` a compressed PyBullet state, both as bytes.

    Everything but `physics` can be read without this package and has the same bytes whenever the world is the same; `physics`
    adds what a bit-exact continuation needs (contacts), and holds memory addresses, so that its bytes differ between runs.

    Args:
        world: The world to describe.
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
    """The numbers of a command; the last row is there after a tick of torques only."""
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
            f"The arrays are incomplete: {', '.join(sorted(missing))} is missing. `World.arrays()` gives them all."
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
        raise RlbenchPinError(f"The arrays are damaged ({problem}). `World.arrays()` gives whole ones.") from error


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
        raise RlbenchPinError(f"The array 'physics' is damaged: {error}.") from error
    if not reader.eof:
        raise RlbenchPinError("The array 'physics' is damaged: it was cut off, or is too large.")
    write_logical_state(world, logical)
    _restore_server(world, lambda client: restore_bytes(client, physics), logical)
    world.robot.forget_measurements()


def _set_measured(world: Contents, arrays: Mapping[str, np.ndarray], names: list[str]) -> None:
    """Put bodies and joints where the arrays say, with the velocities they say."""
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
        raise RlbenchPinError(f"The arrays have format {meta['format']}; this version reads {_FORMAT}.")
    if meta["robot"] != world.robot.description.name:
        raise RlbenchPinError(f"The arrays belong to the robot '{meta['robot']}', not '{world.robot.description.name}'.")
    check_same_scene(world, logical)


def _byte_array(data: bytes) -> np.ndarray:
    return np.frombuffer(data, dtype=np.uint8).copy()
