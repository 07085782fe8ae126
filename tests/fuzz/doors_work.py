"""Doors that work for long where they are not refused: recordings, checks, evaluation, environments of gymnasium, conditions."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rlbench_pin import control, gym, robot
from rlbench_pin.checking import Item, TrialJournal, explain_failure, run_trials
from rlbench_pin.control.qp.programs import empty_rows
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.evaluation import EvaluationConfig, evaluate
from rlbench_pin.recording import ImageConfig, ProcessEngine, RecordConfig, SerialEngine, record, rerender, write_seeds
from rlbench_pin.recording.rerender import EpisodeSeed
from rlbench_pin.tasks import conditions
from tests.fuzz.doors import Door, Fresh, functions, methods, parameters_of

TASK = "reach_target"
LOOSE: dict[str, str] = {"LeRobotEnv": "render_mode", "LazyAsyncVectorEnv": "like makers"}


def program_doors() -> list[Door]:
    """Return those of quadratic programs, bounds of joints, and rules of a motion."""
    model = robot.RobotModel(robot.robot_description("panda"))
    q, zero, ones = model.home, np.zeros(7), np.ones(7)
    A, lower, upper = empty_rows(7)
    program = control.QuadraticProgram(np.eye(7), zero, A, lower, upper, -ones, ones)
    motion, collision = control.DifferentialIKQP(model), robot.CollisionModel(model)
    good: dict[str, object] = {
        "P": np.eye(7), "q": q, "A": np.zeros((2, 7)), "lower": -np.ones(2), "upper": np.ones(2), "x_lower": -ones,
        "x_upper": ones, "x": zero, "v": zero, "command": 0.1 * ones, "limits": model.limits, "dt": 0.05, "problem": program,
        "target": lambda now: (now, 0.01),
    }  # fmt: skip

    def wider(more: float, ends: Sequence[object]) -> None:
        with collision.wider(more, ends):  # type: ignore[arg-type]
            collision.in_collision(q)

    loose = {"QuadraticProgram": "lower upper x_lower x_upper"}
    doors = functions(control, ["QuadraticProgram", "JointBounds", "OsqpSolver"], good, loose)
    for thing in (program, control.JointBounds(model.limits, 0.05), control.OsqpSolver()):
        doors += methods(thing, good, {})
    doors += [door for door in methods(motion, good, {}) if door.name.endswith(".problem")]
    return [*doors, Door("CollisionModel.wider", lambda: wider, {"more": 0.01, "ends": [q]})]


def asked(condition: object) -> str:
    """Ask a condition that was made, and say what is wrong with it."""
    assert isinstance(condition, conditions.Condition)
    try:
        condition.reset()
        met = condition.met()
        condition.set_state(condition.state())
    except Exception as error:  # whatever a wrong part leads to
        return f"is made, and then {type(error).__name__}"
    return "" if isinstance(met, bool | np.bool_) else f"is met: {met!r}"


def condition_doors(task: TaskEnvironment) -> list[Door]:
    """Return those of all conditions."""
    world = task.world
    body = next(body for body in world.bodies.values() if body.joints)
    held = conditions.NothingGrasped(world.gripper)
    good: dict[str, object] = {
        "members": [held], "element": body, "sensor": _Volume(), "elements": [body, body], "count": 1, "robot": world.robot,
        "body": body, "points": np.zeros((2, 3)), "gripper": world.gripper, "rgb": [1.0, 0.0, 0.0],
        "joint": next(iter(body.joints.values())), "distance": 0.1, "items": [1], "reference": body, "angle": 0.1,
    }  # fmt: skip
    names = [name for name in conditions.__all__ if name != "Condition"]
    found = functions(conditions, names, good, {"ListEmpty": "items", "FollowPath": "points"})
    return [replace(door, result=asked) for door in found]


class _Volume:
    """A sensor, as conditions see it; the scene has none."""

    def detects(self, name: str) -> bool:
        """Nothing is inside."""
        return name == ""

    def contains(self, point: np.ndarray) -> bool:
        """Whether a point is below the table."""
        return bool(point[2] < 0.0)


def recording_doors(folder: Path) -> list[Door]:
    """Return those that record or check; good arguments are those of the smallest work."""
    numbers = itertools.count()
    out = Fresh(lambda: folder / f"recorded{next(numbers)}")
    images = ImageConfig(products=())
    config, engine = RecordConfig(tasks=(TASK,), episodes=1, images=images), SerialEngine()
    small = EvaluationConfig(policy="noop", tasks=(TASK,), episodes=1, max_seconds=0.1)
    seeds = write_seeds(folder / "seeds.json", [EpisodeSeed(TASK, 0, 0, 1, 0)])
    journal = TrialJournal(None, [])
    item = Item(TASK, "words", (0,), 1)
    return [
        Door("record", lambda: record, {"config": config, "root": out, "engine": engine}, finite=False),
        Door("rerender", lambda: rerender, {"source": seeds, "out": out, "images": images, "engine": engine}, finite=False),
        Door("evaluate", lambda: evaluate, {"config": small, "out": out, "engine": engine}, finite=False),
        Door("ProcessEngine", lambda: ProcessEngine),
        Door("run_trials", lambda: run_trials, {"items": [item], "workers": 1, "journal": journal}, finite=False),
        Door("explain_failure", lambda: explain_failure, {"task": TASK, "seed": 0, "variation": 0}),
    ]


def gym_doors() -> list[Door]:
    """Return the constructors of environments; what was made is asked for its first observation, and closed."""
    small = {"image_size": (16, 16), "cameras": ("front",)}
    doors = [
        Door("GymnasiumEnv", lambda: gym.GymnasiumEnv, {"task": TASK}),
        Door("LeRobotEnv", lambda: gym.LeRobotEnv, {"task": TASK, **small}),
        Door("make_env", lambda: gym.make_env, {"tasks": [TASK]}),
    ]
    return [replace(door, result=begun, finite=False, loose=frozenset(LOOSE.get(door.name, "").split())) for door in doors]


def begun(env: object) -> str:
    """Begin an episode of an environment, or of each in a suite, and close them; say what is wrong."""
    environments = [e for suite in env.values() for e in suite.values()] if isinstance(env, dict) else [env]
    try:
        for one in [one for one in environments if not isinstance(one, gym.LazyAsyncVectorEnv)][:1]:  # no processes
            one.reset(seed=1)
    except Exception as error:  # whatever a wrong setting leads to
        return f"is made, and then {type(error).__name__}"
    finally:
        for one in environments:
            one.close()
    return ""


def without_default(door: Door) -> list[str]:
    """Return the arguments of a door that have no default."""
    return [name for name, p in parameters_of(door.target()).items() if p.default is p.empty]
