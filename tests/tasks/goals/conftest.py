"""The goal that a test asks for by `goal_of`."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.tasks.goals.goal import Goal
from tests.tasks.running import begin, running


@pytest.fixture
def goal(request: pytest.FixtureRequest) -> Iterator[Goal]:
    """A task at the nominal place, its episode begun; the test must see its goal reached and not reached."""
    name, variation = request.param
    with running(name) as task:
        found = Goal(task, begin(task, variation))
        assert not found.reached()
        yield found
        assert found.verdicts == {True, False}, "the test never saw the goal reached"
