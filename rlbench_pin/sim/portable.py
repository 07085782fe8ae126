"""A world as plain arrays that another process can continue from."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.sim.arm.control import ArmControl
from rlbench_pin.sim.arm.grasp import Attachment
from rlbench_pin.sim.arm.gripper import FingerControl
from rlbench_pin.sim.server.contents import restore_bytes, to_bytes
from rlbench_pin.sim.state import (
    LogicalBodyState,
    LogicalState,
    check_same_scene,
    match_spawned,
    read_logical_state,
    restore,
    save,
    separate_bodies,
    write_logical_state,
)
from rlbench_pin.values import as_record

if TYPE_CHECKING:
    from rlbench_pin.sim.world import World

_FORMAT = 1
_MOST_BYTES = 1 << 28
"""More than any state of a physics server."""
_KEYS = {"meta", "frame_poses", "arm_control", "finger_control", "finger_limits", "attachment_poses"}
_MEASURED = {"body_poses", "body_velocities", "joint_states", "robot_joints"}
"""Arrays that replace `physics` where it is missing."""


def to_arrays(world: World, exact: bool = True) -> dict[str, np.ndarray]:
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
        _restore_physics(world, physics, logical)  # as the other process will, so that both go on alike
        arrays["physics"] = _bytes(zlib.compress(physics))
    return arrays


def _readable(world: World, logical: LogicalState) -> dict[str, np.ndarray]:
    bodies = list(logical.bodies)
    return {
        "meta": _bytes(json.dumps(_meta(world, logical)).encode()),
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


def _meta(world: World, logical: LogicalState) -> dict[str, Any]:
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


def from_arrays(world: World, arrays: Mapping[str, np.ndarray]) -> None:
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


def _continue_from(world: World, arrays: Mapping[str, np.ndarray]) -> None:
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
        physics = reader.decompress(np.asarray(arrays["physics"], dtype=np.uint8).tobytes(), _MOST_BYTES)
    except zlib.error as error:
        raise RlbenchPinError(f"The array 'physics' is damaged: {error}.") from error
    if not reader.eof:
        raise RlbenchPinError("The array 'physics' is damaged: it was cut off, or is too large.")
    write_logical_state(world, logical)
    _restore_physics(world, physics, logical)
    world.robot.forget_measurements()


def _set_measured(world: World, arrays: Mapping[str, np.ndarray], names: list[str]) -> None:
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


def _check(world: World, meta: dict[str, Any], logical: LogicalState) -> None:
    if meta["format"] != _FORMAT:
        raise RlbenchPinError(f"The arrays have format {meta['format']}; this version reads {_FORMAT}.")
    if meta["robot"] != world.robot.description.name:
        raise RlbenchPinError(f"The arrays belong to the robot '{meta['robot']}', not '{world.robot.description.name}'.")
    check_same_scene(world, logical)


def _restore_physics(world: World, physics: bytes, logical: LogicalState) -> None:
    separate_bodies(world)
    restore_bytes(world.client, physics)
    world.resting.go_on(logical.quiet)


def _bytes(data: bytes) -> np.ndarray:
    return np.frombuffer(data, dtype=np.uint8).copy()
