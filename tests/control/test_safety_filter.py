"""The safety filter and its records."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import DifferentialIK, FilterCounts, SafeCommand, SafetyConfig, SafetyFilter
from rlbench_pin.control.qp.constraints import HeldQuantity
from rlbench_pin.control.qp.programs import QuadraticProgram
from rlbench_pin.errors import InfeasibleControl, InvalidTarget, InvalidValue
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray
from tests.control.analytic_worlds import TABLE_TOP, TOP_DOWN, box, cluttered, smallest_margin, table

DT = 0.05
CONFIG = SafetyConfig()


class Checker:
    """Moves an arm with the commands of a filter and measures what breaks."""

    def __init__(self, model: RobotModel, world: WorldSnapshot, hold: HeldQuantity = "velocity") -> None:
        self.model, self.hold, self.limits = model, hold, model.limits
        self.filter = SafetyFilter(model, SafetyConfig(hold=hold))
        self.filter.distances.update(world)
        self.distances = DistanceModel(model)
        self.distances.update(world)
        self.q, self.v = np.array(world.arm), np.zeros(model.size)
        self.margin = np.inf
        self.travelled = 0.0

    def tick(self, wanted: FloatArray) -> None:
        """Filter one command, run it, and check limits; distances four times on the way."""
        u = self.filter.filter(self.q, self.v, wanted).velocity
        assert np.all(np.abs(u) <= self.limits.velocity + 1e-9)
        assert np.all(np.abs(u - self.v) <= DT * self.limits.acceleration + 1e-9)
        start = u if self.hold == "velocity" else self.v
        if self.hold == "any":  # light joints are there at once, heavy ones at the end of the tick
            start = np.where(np.arange(self.model.size) < 2, self.v, u)
        for share in (0.25, 0.5, 0.75, 1.0):
            q = self.q + DT * share * (start + 0.5 * share * (u - start))
            self.margin = min(self.margin, smallest_margin(self.distances, q, CONFIG.margin, CONFIG.self_margin))
        self.travelled += float(np.abs(q - self.q).sum())
        self.q, self.v = q, u
        assert self.limits.contains(q, 1e-9)


@pytest.mark.simulation
@pytest.mark.parametrize("hold", ["velocity", "acceleration", "any"])
@pytest.mark.parametrize("keep", [1, 30])
def test_random_actions_break_nothing(model: RobotModel, hold: HeldQuantity, keep: int) -> None:
    """Random velocities of full range, new at each tick or kept for long, among boxes: limits and distances hold."""
    rng = np.random.default_rng(keep)
    for seed in range(3):
        checker = Checker(model, cluttered(model, seed=seed), hold)
        for k in range(200):
            if k % keep == 0:
                wanted = rng.uniform(-model.limits.velocity, model.limits.velocity)
            checker.tick(wanted)
        assert checker.margin > -1e-3
        assert checker.travelled > 10.0


@pytest.mark.slow
def test_many_random_actions_break_nothing(model: RobotModel) -> None:
    """The same for 10,000 actions over ten worlds."""
    rng = np.random.default_rng(5)
    for seed in range(10):
        checker = Checker(model, cluttered(model, seed=seed))
        for k in range(1000):
            if k % (1 + 10 * (seed % 3)) == 0:
                wanted = rng.uniform(-model.limits.velocity, model.limits.velocity)
            checker.tick(wanted)
        assert checker.margin > -1e-3


def test_a_policy_that_drives_into_the_table_stops_above_it(model: RobotModel) -> None:
    """Aimed below the table top, the gripper stops at the margin, and the filter says why."""
    checker = Checker(model, WorldSnapshot((table(),), model.home, np.full(2, 0.04)))
    policy = DifferentialIK(model)
    for _ in range(150):
        checker.tick(policy.velocity_to_pose(checker.q, checker.v, [0.3, 0.0, TABLE_TOP - 0.2, *TOP_DOWN]))
    assert checker.margin > -1e-3
    nearest = checker.distances.nearest(checker.q)[0]
    assert nearest.b == "table"
    assert nearest.distance < CONFIG.margin + CONFIG.buffer + 2e-3
    command = checker.filter.filter(
        checker.q, checker.v, policy.velocity_to_pose(checker.q, checker.v, [0.3, 0.0, 0.5, *TOP_DOWN])
    )
    assert "distance" in command.reasons
    assert any("table" in pair for pair in command.pairs)
    assert "near table" in str(command)
    assert checker.filter.counts.interventions > 0


@pytest.mark.simulation
def test_the_arm_slides_along_what_it_may_not_enter(model: RobotModel) -> None:
    """Pushed into the table and sideways at once, the gripper goes sideways."""
    checker, policy = Checker(model, WorldSnapshot((table(),), model.home, np.full(2, 0.04))), DifferentialIK(model)
    for _ in range(100):
        checker.tick(policy.velocity_to_pose(checker.q, checker.v, [0.3, 0.0, TABLE_TOP - 0.1, *TOP_DOWN]))
    for _ in range(150):
        checker.tick(policy.velocity_to_pose(checker.q, checker.v, [0.3, 0.25, TABLE_TOP - 0.1, *TOP_DOWN]))
    assert model.tip_pose(checker.q)[1] > 0.15
    assert checker.margin > -1e-3


def test_harmless_commands_pass_unchanged(model: RobotModel) -> None:
    """A slow motion in free space comes out as it went in, without a reason."""
    safety, wanted = SafetyFilter(model), np.full(model.size, 0.05)
    safety.distances.update(WorldSnapshot((table(),), model.home, np.full(2, 0.04)))
    command = safety.filter(model.home, np.zeros(7), wanted)
    np.testing.assert_array_equal(command.velocity, wanted)
    assert not command.intervened
    assert not command.stopped
    assert str(command) == "passed"


def test_what_is_allowed_may_be_touched(model: RobotModel) -> None:
    """The filter lets the gripper near a body whose name is allowed, and to no other."""
    tip = model.tip_pose(model.home)[:3]
    block = box("block", (0.04, 0.04, 0.04), tip + [0.06, 0.0, -0.03])
    world = WorldSnapshot((table(), block), model.home, np.full(2, 0.04))
    safety, v = SafetyFilter(model), np.zeros(7)
    towards = DifferentialIK(model).velocity_for_twist(model.home, v, [0.2, 0, 0, 0, 0, 0])
    safety.distances.update(world)
    assert "distance" in safety.filter(model.home, v, towards).reasons
    safety.distances.update(world, allowed=("block",))
    assert "distance" not in safety.filter(model.home, v, towards).reasons


def test_a_distance_below_the_minimum_at_the_start_grows(model: RobotModel) -> None:
    """Started inside the margin, the arm does not come nearer whatever is wanted, and moves away when nothing is."""
    tip = model.tip_pose(model.home)[:3]
    world = WorldSnapshot((box("block", (0.1, 0.1, 0.1), tip + [0.0, 0.0, -0.055]),), model.home, np.full(2, 0.04))
    safety, distances, rng = SafetyFilter(model), DistanceModel(model), np.random.default_rng(2)
    safety.distances.update(world)
    distances.update(world)
    start = distances.nearest(model.home)[0].distance
    assert start < safety.config.margin
    q, v = model.home.copy(), np.zeros(7)
    for _ in range(40):
        v = safety.filter(q, v, rng.uniform(-1.0, 1.0, 7)).velocity
        q = q + DT * v
        assert distances.nearest(q)[0].distance > start - 1e-3
    for _ in range(100):
        v = safety.filter(q, v, np.zeros(7)).velocity
        q = q + DT * v
    assert distances.nearest(q)[0].distance > safety.config.margin


def test_limits_crossed_at_the_start_are_led_back(model: RobotModel) -> None:
    """Beyond a joint limit the filter brakes and returns, and names the limits as the reason."""
    safety, q, v = SafetyFilter(model), model.home.copy(), np.zeros(7)
    q[3] = model.limits.upper[3] + 0.1
    for _ in range(30):
        command = safety.filter(q, v, np.ones(7))
        q, v = q + DT * command.velocity, command.velocity
        assert "limits" in command.reasons
    assert model.limits.contains(q, 1e-9)


class NoSolution:
    """A solver that never finds one."""

    def solve(self, problem: QuadraticProgram) -> FloatArray:
        """Refuse."""
        raise InfeasibleControl("test", "no solution", problem)


def test_an_infeasible_program_stops_the_arm(model: RobotModel) -> None:
    """Without a solution the command is braking, it is reported, and the arm comes to rest without touching anything."""
    checker, policy = Checker(model, WorldSnapshot((table(),), model.home, np.full(2, 0.04))), DifferentialIK(model)
    checker.filter = SafetyFilter(model, solver=NoSolution())
    checker.filter.distances.update(WorldSnapshot((table(),), model.home, np.full(2, 0.04)))
    for _ in range(100):
        checker.tick(policy.velocity_to_pose(checker.q, checker.v, [0.3, 0.0, TABLE_TOP - 0.2, *TOP_DOWN]))
    assert checker.margin > -1e-3
    assert checker.filter.counts.reasons["infeasible"] > 0
    assert checker.filter.counts.stops >= checker.filter.counts.reasons["infeasible"]


@pytest.mark.simulation
def test_a_command_depends_on_its_arguments_alone(model: RobotModel) -> None:
    """A filter that has worked gives the same bytes as a new one."""
    world, rng = cluttered(model), np.random.default_rng(3)
    worked = SafetyFilter(model)
    worked.distances.update(world)
    for _ in range(25):
        q, v = rng.uniform(model.limits.lower, model.limits.upper), rng.uniform(-1.0, 1.0, 7)
        wanted, fresh = rng.uniform(-2.0, 2.0, 7), SafetyFilter(model)
        fresh.distances.update(world)
        np.testing.assert_array_equal(worked.filter(q, v, wanted).velocity, fresh.filter(q, v, wanted).velocity)


def test_accelerations_are_filtered_too(model: RobotModel) -> None:
    """A wanted acceleration becomes the velocity at the end of the tick, within the limits."""
    command = SafetyFilter(model).filter_acceleration(model.home, np.zeros(7), np.full(7, 100.0))
    np.testing.assert_allclose(command.velocity, DT * model.limits.acceleration)


def test_bad_input_is_refused(model: RobotModel) -> None:
    """NaN anywhere raises the typed error."""
    safety, good, bad = SafetyFilter(model), np.zeros(7), np.full(7, np.nan)
    for arguments in ((bad, good, good), (good, bad, good), (good, good, bad), (good, good, np.zeros(6))):
        with pytest.raises(InvalidTarget):
            safety.filter(*arguments)


WRONG: list[tuple[dict[str, object], str]] = [
    ({"ticks": -1}, "FilterCounts.ticks"),
    ({"solves": 1.5}, "FilterCounts.solves"),
    ({"interventions": True}, "FilterCounts.interventions"),
    ({"stops": float("nan")}, "FilterCounts.stops"),
    ({"reasons": {"limit": 1}}, r"FilterCounts.reasons has to map reasons \(limits, distance, braking, torque, infeasible\)"),
    ({"reasons": [("limits", 1)]}, "FilterCounts.reasons"),
    ({"reasons": {"limits": -1}}, r"FilterCounts.reasons\['limits'\]"),
]


@pytest.mark.parametrize(("values", "words"), WRONG)
def test_counts_are_counts(values: dict[str, object], words: str) -> None:
    """What is none is refused by name."""
    with pytest.raises(InvalidValue, match=words):
        FilterCounts(**values)  # type: ignore[arg-type]


def test_only_commands_are_counted() -> None:
    """A command is counted once, for each of its reasons; what is no command is refused, and nothing is counted."""
    counts = FilterCounts(ticks=2, reasons={"limits": 1})
    counts.add(SafeCommand(np.zeros(7), np.ones(7), ("limits", "distance"), (), True))
    assert (counts.ticks, counts.interventions, counts.stops) == (3, 1, 1)
    assert counts.reasons == {"limits": 2, "distance": 1}
    with pytest.raises(InvalidValue, match="command has to be a SafeCommand"):
        counts.add("stop")  # type: ignore[arg-type]
    assert counts.ticks == 3
