"""The catalogue of arms."""

from __future__ import annotations

import pytest

from rlbench_pin.errors import UnknownName
from rlbench_pin.robot.description import SUPPORTED_ROBOTS, robot_description


def test_name_is_found_in_any_case() -> None:
    """'Panda' and 'panda' are the same arm."""
    assert robot_description("Panda") is robot_description("panda")
    assert "panda" in SUPPORTED_ROBOTS


def test_unknown_name_proposes_the_nearest() -> None:
    """A wrong name is a ValueError that says what was probably meant."""
    with pytest.raises(ValueError, match="Did you mean 'panda'") as caught:
        robot_description("pandas")
    assert isinstance(caught.value, UnknownName)
    assert caught.value.known == tuple(SUPPORTED_ROBOTS)


def test_files_of_every_robot_exist() -> None:
    """Every description refers to files that are there, and has one acceleration and one home angle per joint."""
    for description in SUPPORTED_ROBOTS.values():
        assert description.urdf.is_file()
        assert description.srdf.is_file()
        assert len(description.arm_joints) == len(description.home) == len(description.acceleration)
