"""Inverse kinematics: one tick, and whole searches. Goals: a tick at most 3 times raw PlaCo, and 5 times faster than Pink."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from control_peers import DT, Pink, RawPlaco, reach_by_clik
from harness import Result, main, summary

from rlbench_pin.control import DifferentialIK, DifferentialIKQP, PoseIK
from rlbench_pin.errors import NoIkSolution
from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray

Tick = tuple[FloatArray, FloatArray, FloatArray]
SOLVERS = ("daqp", "quadprog")
BATCH = 100
"""Ticks of one controller before it is the next one's turn."""


def benchmark(goals: int = 40, poses: int = 1000) -> list[Result]:
    """Time ticks along motions to random goals, and searches for random reachable poses."""
    model = RobotModel(robot_description("panda"))
    return [*_ticks(model, goals), *_searches(model, poses)]


def _ticks(model: RobotModel, goals: int) -> list[Result]:
    """Run all controllers on the states of one motion by ours, in turns of a few ticks.

    The processor time of each turn is taken, and ratios are medians over turns: other work on the machine affects all alike.
    """
    ours, pinks = DifferentialIK(model), {f"ik tick, pink {name}": Pink(model, name) for name in SOLVERS}
    functions: dict[str, Callable[[FloatArray, FloatArray, FloatArray], FloatArray]] = {
        "ik tick": ours.velocity_to_pose,
        "ik tick, raw placo": RawPlaco(model).velocity,
        **{name: peer.velocity for name, peer in pinks.items()},
        "ik tick, written out, osqp": DifferentialIKQP(model).velocity_to_pose,
    }
    states = _states(model, ours, goals)
    seconds: dict[str, list[float]] = {name: [] for name in functions}
    for begin in range(0, len(states), BATCH):
        for name, function in functions.items():
            seconds[name].append(_timed(function, states[begin : begin + BATCH]))
    results = []
    for name, values in seconds.items():
        ratio = float(np.median(np.divide(values, seconds["ik tick"])))
        failed = f", {pinks[name].failures} of {len(states)} without solution" if name in pinks else ""
        results.append(
            summary(name, values, f"{1e6 * np.median(values):.1f} us, {ratio:.2f} x ours{failed}", ratio_to_ours=ratio)
        )
    return results


def _timed(function: Callable[[FloatArray, FloatArray, FloatArray], FloatArray], states: Sequence[Tick]) -> float:
    """Return the processor time of a tick, as the mean of some [s]."""
    began = time.process_time()
    for state in states:
        function(*state)
    return (time.process_time() - began) / len(states)


def _states(model: RobotModel, controller: DifferentialIK, goals: int) -> list[Tick]:
    """Return configuration, velocity and target of every tick of a motion past random goals."""
    rng, states = np.random.default_rng(1), []
    q, v, limits = model.home.copy(), np.zeros(model.size), model.limits
    for _ in range(goals):
        goal = model.tip_pose(np.clip(model.home + 0.5 * rng.normal(size=7), limits.lower + 0.1, limits.upper - 0.1))
        for _ in range(50):
            states.append((q.copy(), v.copy(), goal))
            v = controller.velocity_to_pose(q, v, goal)
            q = q + DT * v
    return states


def _searches(model: RobotModel, count: int) -> list[Result]:
    """Search configurations for poses that random configurations reach, with the same restarts for all."""
    rng, limits = np.random.default_rng(7), model.limits
    poses = [model.tip_pose(rng.uniform(limits.lower, limits.upper)) for _ in range(count)]
    ours, peer = PoseIK(model), Pink(model, SOLVERS[0], dt=1.0)

    def starts(i: int) -> list[FloatArray]:
        draw = np.random.default_rng(i)
        return [model.home, *(draw.uniform(limits.lower, limits.upper) for _ in range(ours.config.starts - 1))]

    def search(i: int) -> bool:
        try:
            ours.solve(poses[i], model.home, np.random.default_rng(i))
        except NoIkSolution:
            return False
        return True

    return [
        _search("ik search", search, count),
        _search(f"ik search, pink {SOLVERS[0]}", lambda i: peer.reach(model, poses[i], starts(i)), count // 4),
        _search("ik search, pinocchio clik", lambda i: reach_by_clik(model, poses[i], starts(i)), count // 4),
    ]


def _search(name: str, function: Callable[[int], bool], count: int) -> Result:
    seconds, found = [], 0
    for i in range(count):
        began = time.perf_counter()
        found += function(i)
        seconds.append(time.perf_counter() - began)
    return summary(name, seconds, f"{found / count:.1%} of {count} poses", success=found / count)


if __name__ == "__main__":
    main(__doc__, benchmark)
