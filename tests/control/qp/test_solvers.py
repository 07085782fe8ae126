"""Solvers of quadratic programs agree, repeat themselves, and say when there is no solution."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control.qp.programs import OsqpSolver, QuadraticProgram, empty_rows
from rlbench_pin.errors import InfeasibleControl

ROWS = 5


def random_program(rng: np.random.Generator, n: int = 7, m: int = ROWS) -> QuadraticProgram:
    """Return a feasible program: 0 satisfies it."""
    root = rng.normal(size=(n, n))
    return QuadraticProgram(
        root @ root.T + 0.1 * np.eye(n),
        5.0 * rng.normal(size=n),
        rng.normal(size=(m, n)),
        -rng.random(m),
        np.full(m, np.inf),
        -rng.random(n),
        rng.random(n),
    )


def test_solutions_are_optimal(rng: np.random.Generator) -> None:
    """Solutions keep the constraints, and no feasible point nearby is better."""
    solver = OsqpSolver(rows=ROWS, rho=0.1)
    for _ in range(20):
        problem = random_program(rng)
        x = solver.solve(problem)
        assert problem.violation(x) < 1e-6
        for _ in range(50):
            other = x + 1e-2 * rng.normal(size=len(x))
            if problem.violation(other) == 0.0:
                assert problem.cost(other) > problem.cost(x) - 1e-6


def test_a_solution_does_not_depend_on_the_problems_before(rng: np.random.Generator) -> None:
    """A solver that has worked gives the same bytes as a new one."""
    problems = [random_program(rng) for _ in range(10)]
    worked = OsqpSolver(rows=ROWS)
    for problem in problems:
        np.testing.assert_array_equal(worked.solve(problem), OsqpSolver(rows=ROWS).solve(problem))


def test_problems_may_have_fewer_rows_than_there_is_room_for(rng: np.random.Generator) -> None:
    """Rows that are not used do not matter; more rows than room are refused."""
    problem = random_program(rng, m=2)
    np.testing.assert_allclose(OsqpSolver(rows=30).solve(problem), OsqpSolver(rows=2).solve(problem), atol=1e-6)
    with pytest.raises(ValueError, match="up to 1 rows"):
        OsqpSolver(rows=1).solve(problem)


def test_an_infeasible_problem_raises_and_is_attached() -> None:
    """A row that contradicts the bounds makes a typed error that carries the problem."""
    problem = QuadraticProgram(
        np.eye(2), np.zeros(2), np.array([[1.0, 1.0]]), np.array([5.0]), np.array([np.inf]), -np.ones(2), np.ones(2)
    )
    with pytest.raises(InfeasibleControl) as caught:
        OsqpSolver(rows=1, rho=0.1).solve(problem)
    assert caught.value.problem is problem


@pytest.mark.parametrize("name", ["daqp", "quadprog"])
def test_foreign_solvers_fit_the_interface(name: str, rng: np.random.Generator) -> None:
    """Solvers of the bench extra find the same solutions."""
    pytest.importorskip("qpsolvers")
    pytest.importorskip(name)
    foreign = pytest.importorskip("rlbench_pin.control.qp.foreign_solver", exc_type=ImportError)
    solver = foreign.ForeignSolver(name)
    for m in (0, ROWS):
        problem = random_program(rng, m=m)
        np.testing.assert_allclose(solver.solve(problem), OsqpSolver(rows=ROWS, rho=0.1).solve(problem), atol=1e-5)


def test_empty_rows_are_empty() -> None:
    """A problem without rows is solved by its bounds alone."""
    problem = QuadraticProgram(np.eye(2), np.array([-3.0, 0.2]), *empty_rows(2), -np.ones(2), np.ones(2))
    np.testing.assert_allclose(OsqpSolver().solve(problem), [1.0, -0.2], atol=1e-7)
