"""Every public function, class and method takes good arguments, and refuses hostile ones by an error of ours with a text."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.environment import TaskEnvironment
from tests.fuzz.cases import Tally
from tests.fuzz.doors import Door, cases_of, missing
from tests.fuzz.doors_analytic import analytic_doors
from tests.fuzz.doors_data import data_doors
from tests.fuzz.doors_work import condition_doors, gym_doors, program_doors, recording_doors
from tests.fuzz.doors_world import opened, world_doors


def try_all(doors: Iterable[Door], tally: Tally, seed: int, share: float) -> None:
    """Run a share of the cases of every door and fail with all that is wrong."""
    doors = list(doors)
    assert [(door.name, lacking) for door in doors if (lacking := missing(door))] == []
    for number, door in enumerate(doors):
        for case in cases_of(door, np.random.default_rng((seed, number)), share):
            tally.run(case)
    assert not tally.faults, f"seed {seed}:\n{tally.report()}"


def test_analytic_doors(tally: Tally, seed: int) -> None:
    """Poses, arms, controllers, planning."""
    try_all([*analytic_doors(), *program_doors()], tally, seed, 0.04)
    assert tally.cases > 900


@pytest.mark.slow
def test_analytic_doors_with_every_value(tally: Tally, seed: int) -> None:
    """All values at all arguments."""
    try_all([*analytic_doors(), *program_doors()], tally, seed, 0.5)
    assert tally.cases > 9_000


@pytest.mark.simulation
def test_doors_of_a_world(tally: Tally, seed: int) -> None:
    """World, bodies, joints, frames, arm, gripper, task; nothing that a case does outlives it."""
    with opened() as task:
        try_all([*world_doors(task), *condition_doors(task)], tally, seed, 0.1)
    assert tally.cases > 300


@pytest.mark.slow
def test_doors_of_a_world_with_every_value(tally: Tally, seed: int) -> None:
    """All values at all arguments."""
    with opened() as task:
        try_all([*world_doors(task), *condition_doors(task)], tally, seed, 0.9)
    assert tally.cases > 3_000


@pytest.mark.simulation
def test_doors_of_data(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Datasets, tasks, settings, recordings, checks."""
    with opened() as task:
        try_all(data_doors(elsewhere, task), tally, seed, 0.03)
    assert tally.cases > 600


@pytest.mark.slow
def test_doors_of_data_with_every_value(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Many values at all arguments."""
    with opened() as task:
        try_all(data_doors(elsewhere, task), tally, seed, 0.3)
    assert tally.cases > 6_000


def work_doors(folder: Path, task: TaskEnvironment) -> list[Door]:
    """Return the doors of everything that works for long."""
    return [*recording_doors(folder), *gym_doors()]


@pytest.mark.simulation
def test_doors_of_long_work(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Recordings, checks, segments of demonstrations, environments of gymnasium: a few of what is refused before the work."""
    with opened("reach_target") as task:
        try_all(work_doors(elsewhere, task), tally, seed, 0.05)
    assert tally.cases > 50


@pytest.mark.slow
def test_doors_of_long_work_with_many_values(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Many values at all arguments."""
    with opened("reach_target") as task:
        try_all(work_doors(elsewhere, task), tally, seed, 0.4)
    assert tally.cases > 800
