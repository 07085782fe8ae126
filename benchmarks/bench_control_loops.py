"""Safety filter, operational space control, prediction, on analytic worlds. Goal: median tick of the filter at most 300 us."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from harness import Result, main, summary

from rlbench_pin.control import CartesianImpedance, CartesianMPC, OperationalSpaceQP, PoseIK, SafetyConfig, SafetyFilter
from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import RobotModel

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.control.analytic_worlds import TOP_DOWN, cluttered, simulate, smallest_margin
from tests.control.test_operational_space import circle

DT = 0.05


def benchmark(actions: int = 4000) -> list[Result]:
    """Measure all loops."""
    model = RobotModel(robot_description("panda"))
    filters = [_filter(model, keep, actions) for keep in (1, 20)]
    return [*filters, _circle(model), _impedance(model), *(_prediction(model, avoid) for avoid in (False, True))]


def _filter(model: RobotModel, keep: int, actions: int) -> Result:
    """Filter random velocities of full range, each kept for some ticks, on a table with ten boxes; ten worlds in turn."""
    config, limits, rng = SafetyConfig(), model.limits, np.random.default_rng(keep)
    seconds, margin, broken, changed, solves, stops = [], np.inf, 0, 0, 0, 0
    for seed in range(10):
        safety, checker, world = SafetyFilter(model, config), DistanceModel(model), cluttered(model, seed=seed)
        safety.distances.update(world)
        checker.update(world)
        q, v = model.home.copy(), np.zeros(7)
        for k in range(actions // 10):
            if k % keep == 0:
                wanted = rng.uniform(-limits.velocity, limits.velocity)
            began = time.perf_counter()
            u = safety.filter(q, v, wanted).velocity
            seconds.append(time.perf_counter() - began)
            broken += bool(np.any(np.abs(u) > limits.velocity + 1e-9))
            broken += bool(np.any(np.abs(u - v) > DT * limits.acceleration + 1e-9))
            for share in (0.5, 1.0):
                margin = min(margin, smallest_margin(checker, q + share * DT * u, config.margin, config.self_margin))
            q, v = q + DT * u, u
            broken += not limits.contains(q, 1e-9)
        changed += sum(n for reason, n in safety.counts.reasons.items() if reason != "limits")
        solves, stops = solves + safety.counts.solves, stops + safety.counts.stops
    note = f"{broken} violations, {1e3 * margin:+.2f} mm from the margin, {solves / actions:.0%} QPs, {stops / actions:.1%} stops"
    figures = {
        "violations": float(broken),
        "margin_mm": 1e3 * margin,
        "distances_active": changed / actions,
        "stops": stops / actions,
    }
    return summary(f"safety filter, actions kept {keep} ticks", seconds, note, **figures)


def _circle(model: RobotModel) -> Result:
    """Track a circle of 0.25 m at 0.5 m/s in rigid-body dynamics."""
    controller, plant = OperationalSpaceQP(model), RobotModel(model.description)
    q = PoseIK(model).solve(circle(0.0, 0.25, 0.5)[0], model.home, np.random.default_rng(0)).q
    v, seconds, worst, share = np.zeros(7), [], 0.0, 0.0
    for k in range(840):
        pose, twist, acceleration = circle(k * controller.config.dt, 0.25, 0.5)
        worst = max(worst, float(np.linalg.norm(plant.tip_pose(q)[:3] - pose[:3])))
        began = time.perf_counter()
        torque = controller.command(q, v, pose, twist, acceleration).torque
        seconds.append(time.perf_counter() - began)
        share = max(share, float(np.max(np.abs(torque) / model.limits.effort)))
        q, v = simulate(plant, q, v, torque, controller.config.dt)
    note = f"circle 0.25 m at 0.5 m/s: {1e3 * worst:.2f} mm off at most, {share:.0%} of the torque limits"
    return summary("operational space tick", seconds, note, worst_mm=1e3 * worst, torque_share=share)


def _impedance(model: RobotModel) -> Result:
    """Push the tip with 5 N along each axis."""
    controller, plant, seconds, worst = CartesianImpedance(model), RobotModel(model.description), [], 0.0
    start = np.array([0.0, 0.175, 0.0, -1.8, 0.0, 2.2, 0.785])
    target = model.tip_pose(start)
    for force in 5.0 * np.eye(3):
        q, v = start.copy(), np.zeros(7)
        for _ in range(480):
            began = time.perf_counter()
            torque = controller.torque(q, v, target)
            seconds.append(time.perf_counter() - began)
            q, v = simulate(plant, q, v, torque, 1.0 / 240.0, force)
        moved = plant.tip_pose(q)[:3] - target[:3]
        worst = max(worst, float(np.linalg.norm(moved - force / 400.0)) / (5.0 / 400.0))
    return summary("impedance tick", seconds, f"5 N: displacement within {worst:.2%} of force / stiffness", relative_error=worst)


def _prediction(model: RobotModel, avoid: bool) -> Result:
    """Move to a pose among boxes, with or without distances."""
    distances = DistanceModel(model)
    distances.update(cluttered(model))
    controller, seconds = CartesianMPC(model, distances=distances if avoid else None), []
    q, v, stops, goal = model.home.copy(), np.zeros(7), 0, np.array([0.3, 0.2, 1.1, *TOP_DOWN])
    for k in range(200):
        if k % 40 == 0:
            goal[1] = -goal[1]
        began = time.perf_counter()
        command = controller.command(q, v, goal)
        seconds.append(time.perf_counter() - began)
        q, v, stops = q + DT * command.velocity, command.velocity, stops + command.stopped
    return summary(
        f"prediction tick{', distances' if avoid else ''}", seconds, f"10 ticks ahead, {stops} stops", stops=float(stops)
    )


if __name__ == "__main__":
    main(__doc__, benchmark)
