"""The gripper's logic, on fingers that do what is commanded unless something is in between."""

from __future__ import annotations

import pytest

from rlbench_pin.control import GripperConfig, GripperController
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.description import robot_description

CONFIG = GripperConfig.of(robot_description("panda"))


class Fingers:
    """Two fingers that drive to the commanded width and meet an object of `thing` [m]; they press when they cannot."""

    def __init__(self, width: float, thing: float = 0.0, stiffness: float = 1000.0) -> None:
        self.width, self.thing, self.stiffness, self.force = width, thing, stiffness, 0.0

    def drive(self, width: float, limit: float) -> None:
        """Move for one tick."""
        self.width = max(width, self.thing)
        self.force = min(limit, self.stiffness * max(0.0, self.thing - width))


def run(controller: GripperController, fingers: Fingers, ticks: int = 60, senses_force: bool = True) -> list[str]:
    """Run for some ticks, and return the states."""
    states = []
    for _ in range(ticks):
        command = controller.update(fingers.width, fingers.force if senses_force else 0.0)
        fingers.drive(command.width, command.force)
        states.append(command.state)
    return states


def test_it_opens_all_the_way_and_stays() -> None:
    """From closed to open at the set speed, then at rest."""
    controller, fingers = GripperController(CONFIG), Fingers(0.0)
    controller.open()
    states = run(controller, fingers)
    assert fingers.width == pytest.approx(0.08, abs=CONFIG.tolerance)
    assert controller.done
    assert not controller.holds
    assert states.index("reached") == pytest.approx(0.08 / (CONFIG.speed * CONFIG.dt), abs=2)


def test_it_closes_to_a_width() -> None:
    """A width in between is reached and kept."""
    controller, fingers = GripperController(CONFIG), Fingers(0.08)
    controller.move(0.03)
    run(controller, fingers)
    assert fingers.width == pytest.approx(0.03, abs=CONFIG.tolerance)
    assert controller.state == "reached"


def test_fingers_that_meet_hold_nothing() -> None:
    """Closing on air ends at zero and is no grasp."""
    controller, fingers = GripperController(CONFIG), Fingers(0.08)
    controller.close()
    run(controller, fingers)
    assert controller.state == "reached"
    assert not controller.holds


@pytest.mark.parametrize("senses_force", [True, False])
def test_it_holds_what_is_in_between_with_limited_force(senses_force: bool) -> None:
    """Closing on an object ends in holding it, by force or by standing still, and never presses harder than allowed."""
    controller, fingers = GripperController(CONFIG), Fingers(0.08, thing=0.04)
    controller.close(force=8.0)
    run(controller, fingers, senses_force=senses_force)
    assert controller.holds
    assert 0.0 < fingers.force <= 8.0


def test_it_goes_on_when_the_object_slips() -> None:
    """What is taken away is noticed: the fingers close on."""
    controller, fingers = GripperController(CONFIG), Fingers(0.08, thing=0.04)
    controller.close()
    run(controller, fingers)
    assert controller.holds
    fingers.thing = 0.0
    run(controller, fingers)
    assert controller.state == "reached"
    assert fingers.width < 0.002


def test_blocked_while_opening_is_stalled() -> None:
    """Fingers that cannot open do not hold; they are stuck, and the command stops pushing."""
    controller = GripperController(CONFIG)
    controller.open()
    for _ in range(10):
        command = controller.update(0.02)
    assert command.state == "stalled"
    assert command.width == pytest.approx(0.02)
    assert not controller.holds


def test_a_new_goal_starts_afresh() -> None:
    """After a grasp, opening lets go."""
    controller, fingers = GripperController(CONFIG), Fingers(0.08, thing=0.04)
    controller.close()
    run(controller, fingers)
    controller.open()
    assert not controller.done
    run(controller, fingers)
    assert fingers.width == pytest.approx(0.08, abs=CONFIG.tolerance)


def test_goals_are_kept_within_the_hand() -> None:
    """Widths beyond the fingers and forces beyond the motor are cut."""
    controller = GripperController(CONFIG)
    controller.move(1.0, force=1e6)
    assert controller.target == CONFIG.widest
    assert controller.force == CONFIG.force
    assert controller.update(0.08).fingers() == (0.04, 0.04)


def test_bad_input_is_refused() -> None:
    """NaN widths, NaN measurements, and forces of zero."""
    controller = GripperController(CONFIG)
    with pytest.raises(InvalidTarget):
        controller.move(float("nan"))
    with pytest.raises(InvalidTarget):
        controller.update(float("nan"))
    with pytest.raises(InvalidTarget):
        controller.update(0.08, [1.0, float("nan")])
    with pytest.raises(ValueError, match="force"):
        controller.close(force=0.0)
    with pytest.raises(ValueError, match="speed"):
        GripperConfig(widest=0.08, force=40.0, speed=0.0)
