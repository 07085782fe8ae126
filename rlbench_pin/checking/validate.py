"""Measurements on one running task that `rlbench-pin check` and the contract tests validate."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.demos import EXTRA_TICKS, DemoPlayer, try_play
from rlbench_pin.environment.replay import reaches_goal
from rlbench_pin.observation import Demo
from rlbench_pin.robot import geometry
from rlbench_pin.scene.snapshot import BodySnapshot
from rlbench_pin.spatial import FloatArray

NOOP_STEPS = RANDOM_STEPS = 200
NOOP_TIME = 2.0
"""Time after a reset in which no object may move [s]."""
MAX_DRIFT = 1e-3
"""Largest motion of an object in that time [m]."""
MAX_PENETRATION = 2e-3
"""Largest penetration of objects at a reset [m]."""
ENGINE_STATE = "physics"
"""Array of `World.arrays` with the engine's own file, whose memory addresses differ from save to save."""


@dataclass(frozen=True)
class NoopEpisode:
    """An episode of the no-op policy, in which the arm is stationary after the reset."""

    penetration: float
    """Deepest overlap at the reset [m]."""
    held: tuple[str, ...]
    """Objects that the gripper holds at the reset, which is a fault."""
    arm_speed: float
    """Largest joint speed of the arm at the reset [rad/s]."""
    drift: float
    """Largest distance that a corner of a link has moved after `NOOP_TIME` [m]."""
    drifter: str
    """The link of that corner."""
    success: bool
    """Whether the goal was reached, at the reset or later, which is a fault."""


def noop_episode(task: TaskEnvironment, seed: int, variation: int, steps: int = NOOP_STEPS) -> NoopEpisode:
    """Reset, and keep the arm stationary for `steps` control ticks, at least for `NOOP_TIME`."""
    task.reset(seed=seed, variation=variation)
    penetration, held = task.world.max_penetration(), task.runtime.gripper.grasped
    speed = float(np.abs(task.world.robot.joint_velocities).max())
    success = task.task.success()[0]
    still = np.append(task.world.robot.joint_positions, 1.0)
    settled, watched = corners(task), round(NOOP_TIME / task.world.control_dt)
    success |= reaches_goal(task, [still] * watched)
    drift, drifter = _largest_move(settled, corners(task))
    success = success or reaches_goal(task, [still] * (steps - watched))
    return NoopEpisode(penetration, held, speed, drift, drifter, success)


def random_succeeds(task: TaskEnvironment, seed: int, variation: int, steps: int = RANDOM_STEPS) -> bool:
    """Whether `steps` actions drawn uniformly from the action space reach the goal, which is a fault."""
    rng = np.random.default_rng(seed)
    task.reset(seed=seed, variation=variation)
    low, high = task.action_bounds()
    return reaches_goal(task, (rng.uniform(low, high) for _ in range(steps)))


def left_over(task: TaskEnvironment, demo: Demo) -> tuple[str, ...]:
    """Restart a demonstration after it was played, and return the differences; there are none if the task cleans up."""
    assert demo.seed is not None
    if demo.attempt or demo.state is None:
        task.reset_to_demo(demo)
        return ()
    task.reset(seed=demo.seed, variation=demo.variation_number)
    remains = differences(demo.state, task.world.arrays(exact=False))
    if remains:
        task.reset_to_demo(demo)
    return remains


def reset_repeats(task: TaskEnvironment, seed: int, variation: int) -> bool:
    """Whether the same seed gives a byte-identical world, also after another episode."""
    first = _start(task, seed, variation)
    task.reset(seed=seed + 1)
    task.step(np.append(task.world.robot.joint_positions, 0.0))
    return _start(task, seed, variation) == first


def demo_repeats(task: TaskEnvironment, seed: int, variation: int) -> bool:
    """Whether a demonstration played twice is byte-identical, or fails twice for the same cause."""
    first, second = (_demo_bytes(task, seed, variation) for _ in range(2))
    return first == second


def demo_bytes(demo: Demo) -> bytes:
    """Return all low-dimensional data of a demonstration."""
    return b"".join(observation.get_low_dim_data().tobytes() for observation in demo)


def solved_by_other_plans(task: TaskEnvironment, seed: int, variation: int, tries: int) -> bool:
    """Whether one of `tries` demonstrations in the same scene of a seed succeeds, each planned with other random draws."""
    task.reset(seed=seed, variation=variation)
    start = task.get_state()
    for number in range(1, tries + 1):
        task.set_state(replace(start, runtime=replace(start.runtime, planning=start.runtime.planning ^ number)))
        cause, _ = try_play(DemoPlayer(task.runtime, record=False))
        if not cause:
            return True
    return False


# Instructions -------------------------------------------------------------------------------------------------------------------


def shared_instructions(words: Mapping[int, Sequence[str]]) -> tuple[tuple[int, int], ...]:
    """Return the pairs of variations that have the same instructions.

    Args:
        words: Variation -> instructions.
    """
    first: dict[tuple[str, ...], int] = {}
    pairs = []
    for variation, sentences in words.items():
        other = first.setdefault(tuple(sentences), variation)
        if other != variation:
            pairs.append((other, variation))
    return tuple(pairs)


def poor_instructions(words: Mapping[int, Sequence[str]]) -> tuple[int, ...]:
    """Return the variations with no instruction, an empty one, or the same one twice."""
    return tuple(v for v, s in words.items() if not s or len(set(s)) < len(s) or not all(t.strip() for t in s))


# Places of bodies --------------------------------------------------------------------------------------------------------------


def corners(task: TaskEnvironment) -> dict[str, FloatArray]:
    """Return the corners (8, 3) of the box around every link of every body in the world [m], by `body/link`.

    A ball has only its centre (1, 3), since its rotation is not visible; under the name of each body is its origin (1, 3).
    """
    points = {name: body.position[None] for name, body in task.world.bodies.items()}
    return points | {f"{body.name}/{link}": box for body in task.world.snapshot().bodies for link, box in _corners(body)}


def _corners(body: BodySnapshot) -> Iterator[tuple[str, FloatArray]]:
    solid = {} if body.shapes else geometry.solid_geometry(body.urdf, body.scale)
    for link, pose in zip(body.link_names, body.link_poses, strict=True):
        parts = solid.get(link, ())
        corners = geometry.box_corners(geometry.bounds(parts), pose)
        is_ball = len(parts) == 1 and geometry.as_shape(parts[0]).kind == "sphere"
        yield link, corners.mean(axis=0)[None] if is_ball else corners


def _largest_move(before: Mapping[str, FloatArray], after: Mapping[str, FloatArray]) -> tuple[float, str]:
    """Return the largest displacement of a corner [m] and the link it belongs to."""
    moves = {name: float(np.linalg.norm(after[name] - box, axis=1).max()) for name, box in before.items() if name in after}
    name = max(moves, key=moves.__getitem__, default="")
    return moves.get(name, 0.0), name


def differences(before: Mapping[str, np.ndarray], after: Mapping[str, np.ndarray]) -> tuple[str, ...]:
    """Return the differences of two `World.arrays` as text, without the clock and the engine's own state."""
    was, now = (json.loads(np.asarray(a["meta"], dtype=np.uint8).tobytes()) for a in (before, after))
    if list(was["bodies"]) != list(now["bodies"]):
        changed = sorted(set(was["bodies"]) ^ set(now["bodies"])) or ["order of bodies"]
        return tuple(f"bodies: {name}" for name in changed)
    found = [
        f"{what} of {name}" for name, entry in was["bodies"].items() for what in entry if entry[what] != now["bodies"][name][what]
    ]
    found += [f"{key}" for key in was if key not in ("bodies", "ticks") and was[key] != now[key]]
    for key in sorted(set(before) - {"meta", ENGINE_STATE}):
        found += _rows_that_differ(key, before[key], after[key], list(was["bodies"]))
    return tuple(found)


def _rows_that_differ(key: str, before: np.ndarray, after: np.ndarray, bodies: list[str]) -> list[str]:
    if before.shape != after.shape:
        return [key]
    if key in ("body_poses", "body_velocities"):
        what = key.removeprefix("body_")
        return [f"{what} of {name}" for name, a, b in zip(bodies, before, after, strict=True) if a.tobytes() != b.tobytes()]
    return [key] if before.tobytes() != after.tobytes() else []


def _start(task: TaskEnvironment, seed: int, variation: int) -> bytes:
    """Bytes of the world after a reset and again some steps later, when hidden differences have become visible."""
    task.reset(seed=seed, variation=variation)
    first = _world_bytes(task)
    for _ in range(EXTRA_TICKS):
        task.step(np.append(task.world.robot.joint_positions, 1.0))
    return first + _world_bytes(task)


def _world_bytes(task: TaskEnvironment) -> bytes:
    arrays = task.world.arrays()
    return b"".join(arrays[name].tobytes() for name in sorted(arrays) if name != ENGINE_STATE)


def _demo_bytes(task: TaskEnvironment, seed: int, variation: int) -> bytes:
    outcome = task.try_demo(seed=seed, variation=variation)
    return outcome.cause.encode() if outcome.demo is None else demo_bytes(outcome.demo)
