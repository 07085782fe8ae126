"""What an environment is given is checked where it enters: seeds, variations, numbers, actions."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import Discrete, Environment, ERJointViaIK, JointPosition, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.environment.actions.modes import as_action
from rlbench_pin.environment.episode import checked_seed, demo_seeds
from rlbench_pin.environment.stored import StoredSelection
from rlbench_pin.errors import InvalidActionError, InvalidArgument, InvalidValue, OutsideJointLimits, RlbenchPinError
from rlbench_pin.gym.environment import checked_action

NO_ACTIONS = {
    "complex": np.zeros(3, dtype=complex),
    "text": ["0", "0", "0"],
    "one text": "abc",
    "objects": np.array([0.0, None, 1.0], dtype=object),
    "masked": np.ma.masked_array(np.zeros(3), [True, False, False]),
    "dates": np.array(["2026-01-01"] * 3, dtype="datetime64[D]"),
    "ragged": [[0.0], [0.0, 1.0]],
    "huge": [10**400, 0, 0],
    "none": None,
    "NaN": [0.0, np.nan, 0.0],
    "shape": np.zeros((1, 3)),
}


@pytest.mark.parametrize("name", NO_ACTIONS)
def test_actions_are_real_numbers(name: str) -> None:
    """Nothing is turned into numbers silently."""
    with pytest.raises(InvalidActionError, match="Mode"):
        as_action(NO_ACTIONS[name], 3, "Mode")


def test_actions_are_copied() -> None:
    """Lists, float16 and integers are taken; what a policy keeps is not changed."""
    given = np.array([0.0, 1.0, 2.0])
    assert as_action(given, 3, "Mode") is not given
    np.testing.assert_array_equal(as_action(given.astype(np.float16), 3, "Mode"), given)
    np.testing.assert_array_equal(as_action([0, 1, 2], 3, "Mode"), given)


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.uint32, np.int64])
def test_seeds_of_any_width_are_counted_on(kind: type[np.integer]) -> None:
    """255 + 3 is 258 also from eight bits."""
    rng = np.random.default_rng(0)
    assert demo_seeds(3, kind(120), rng) == [120, 121, 122]  # type: ignore[arg-type]
    assert demo_seeds(2, np.uint8(255), rng) == [255, 256]  # type: ignore[arg-type]
    assert demo_seeds(np.uint8(255), 1, rng)[-1] == 255  # type: ignore[arg-type]


def test_seeds_fit_into_episode_files() -> None:
    """The last one of several, too."""
    assert checked_seed(2**63 - 1) == 2**63 - 1
    for seed in (-1, 2**63, 1.0, "1", True, None, np.float64(1), [1]):
        with pytest.raises(InvalidArgument, match="A seed has to be a whole number >= 0"):
            checked_seed(seed)
    with pytest.raises(InvalidArgument):
        demo_seeds(2, 2**63 - 1, np.random.default_rng(0))
    for amount in (0, -1, 1.5, "2", True, None, 10**12):
        with pytest.raises(InvalidArgument, match="amount"):
            demo_seeds(amount, 0, np.random.default_rng(0))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "change",
    [
        {"seed": -1}, {"seed": "1"}, {"seed": 1.5}, {"arm_max_velocity": 0.0}, {"arm_max_velocity": float("nan")},
        {"arm_max_velocity": "fast"}, {"arm_max_acceleration": float("inf")}, {"obs_config": {}}, {"dataset_root": 5},
        {"action_mode": None}, {"action_mode": MoveArmThenGripper}, {"renderer": 3}, {"frequency": 0.5},
    ],
)  # fmt: skip
def test_environments_name_the_argument(change: dict[str, object]) -> None:
    """Before anything is loaded."""
    with pytest.raises(RlbenchPinError, match=next(iter(change))):
        Environment(**{"action_mode": MoveArmThenGripper(JointPosition(), Discrete()), **change})  # type: ignore[arg-type]


def test_selections_of_stored_demos() -> None:
    """Whole numbers and switches."""
    for change in ({"amount": "1"}, {"variation": 1.5}, {"from_episode_number": True}, {"image_paths": "no"}):
        with pytest.raises(InvalidArgument, match=next(iter(change))):
            StoredSelection(**{**vars(StoredSelection(1, 0, False, True, 0)), **change})  # type: ignore[arg-type]


def test_modes_check_their_settings() -> None:
    """Frames, switches, joints."""
    for make in (
        lambda: JointPosition(absolute_mode="no"),  # type: ignore[arg-type]
        lambda: ERJointViaIK(commanded_joints=(0.5,)),  # type: ignore[arg-type]
        lambda: ERJointViaIK(commanded_joints=(0, 0)),
        lambda: ERJointViaIK(eps=float("nan")),
        lambda: ERJointViaIK(frame=7),  # type: ignore[arg-type]
    ):
        with pytest.raises((InvalidValue, InvalidActionError)):
            make()


@pytest.mark.simulation
def test_variations_are_whole_numbers(reach: TaskEnvironment) -> None:
    """1.5 is not rounded, "1" fails here and not far away, numpy's integers are taken."""
    for variation in (1.5, "1", True, None, [1], float("nan")):
        with pytest.raises(InvalidArgument, match="whole number"):
            reach.set_variation(variation)  # type: ignore[arg-type]
    reach.set_variation(np.int8(3))  # type: ignore[arg-type]
    reach.reset(seed=np.uint8(7))  # type: ignore[arg-type]
    assert (reach.seed, reach.runtime.variation) == (7, 3)
    with pytest.raises(InvalidArgument):
        reach.reset(seed=2**63)
    with pytest.raises(InvalidArgument, match="get_state"):
        reach.set_state(None)  # type: ignore[arg-type]


@pytest.mark.simulation
def test_checkered_actions_move_nothing(reach: TaskEnvironment) -> None:
    """Refused actions leave the world as it was, also those of gymnasium."""
    reach.reset(seed=1)
    before = reach.get_observation().get_low_dim_data().tobytes()
    for action in (np.zeros(8, dtype=complex), ["0"] * 8, np.ma.masked_array(np.zeros(8), [True] + [False] * 7), None):
        with pytest.raises(InvalidActionError):
            reach.step(action)
        with pytest.raises(InvalidActionError):
            checked_action(action, reach.action_mode.spec(reach.runtime))
    assert reach.get_observation().get_low_dim_data().tobytes() == before


@pytest.mark.simulation
def test_motions_begin_where_motors_have_overshot(reach: TaskEnvironment) -> None:
    """A measured joint a little beyond its limit counts as at it; one that a reset put far outside is refused by the planner."""
    reach.reset(seed=1)
    runtime = reach.runtime
    limits, home = runtime.model.limits, np.array(runtime.description.home)
    for beyond, start in ((0.0, 0.0), (5e-4, 5e-4), (0.02, 0.0)):
        q = home.copy()
        q[3] = limits.upper[3] + beyond
        runtime.robot.reset_configuration(q)
        assert runtime.measured_start[3] == pytest.approx(limits.upper[3] + start, abs=1e-12)
    q[3] = limits.upper[3] + 1.0
    runtime.robot.reset_configuration(q)
    with pytest.raises(OutsideJointLimits, match="panda_joint4"):
        runtime.planner.plan_to_configuration(runtime.measured_start, home, rng=np.random.default_rng(0))


@pytest.mark.simulation
def test_every_call_refuses_by_an_error_of_ours(reach: TaskEnvironment) -> None:
    """Whatever is given in place of a seed, a number, a demonstration, a task or a name of a camera."""
    hostile = (None, float("nan"), -2, 1.5, "x", [], {}, object(), 10**400, 1j, int, np.ma.masked, np.datetime64("now"))
    calls = {
        "demo": lambda x: reach.reset(x if x is not None else 3),
        "variation": reach.set_variation,
        "step": reach.step,
        "state": reach.set_state,
        "seed": lambda x: reach.try_demo(seed=x, record=False),
        "attempt": lambda x: reach.try_demo(seed=0, attempt=x, record=False),
        "stored": reach.get_demos,
        "live": lambda x: reach.get_demos(x, live_demos=True),
        "tries": lambda x: reach.get_demos(1, live_demos=True, max_attempts=x),
        "camera": lambda x: reach.runtime.cameras[x],
        "camera pose": lambda x: reach.runtime.cameras["front"].set_pose(x),
    }
    with Environment(MoveArmThenGripper(JointPosition(), Discrete())) as environment:
        calls["task"] = environment.get_task
        calls["name"] = lambda x: environment.get_demos(x, 1)
        for name, call in calls.items():
            for value in hostile:
                with pytest.raises(RlbenchPinError):
                    call(value)
                    pytest.fail(f"{name} takes {value!r}")
