"""No task of the library without a test of its goal."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

from rlbench_pin.tasks import library_names
from tests.tasks.running import running


def asked_variations() -> dict[str, set[int]]:
    """Return the variations that the tests of this folder ask for by `goal_of`, by task."""
    found: dict[str, set[int]] = {}
    for path in sorted(Path(__file__).parent.glob("test_*.py")):
        for test in vars(import_module(f"{__package__}.{path.stem}")).values():
            for mark in getattr(test, "pytestmark", ()):
                if mark.name == "parametrize" and mark.args[0] == "goal":
                    for case in mark.args[1]:
                        name, variation = case.values[0]
                        found.setdefault(name, set()).add(variation)
    return found


TESTED = asked_variations()


@pytest.mark.parametrize("name", library_names())
def test_every_task_has_a_test_of_its_goal(name: str) -> None:
    """Write one with `goal_of(name)`: its goal reached, the nearest states that are not, both sides of every threshold."""
    assert name in TESTED, f"'{name}' has no test of its goal in tests/tasks/goals"


@pytest.mark.parametrize("name", sorted(TESTED))
def test_first_last_and_a_middle_variation_are_tested(name: str) -> None:
    """Of tasks whose goal varies."""
    with running(name) as task:
        count = task.variation_count()
    assert {0, count - 1} <= TESTED[name]
    assert len(TESTED[name]) >= min(count, 3)
