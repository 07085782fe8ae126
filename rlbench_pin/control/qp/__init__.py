"""Quadratic programs: their terms, their bounds and their solvers.

`foreign_solver` is not imported here: it needs the `bench` extra.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.control.qp.constraints import HeldQuantity, JointBounds
from rlbench_pin.control.qp.objectives import PostureObjective, TipObjective
from rlbench_pin.control.qp.osqp_solver import OsqpSolver
from rlbench_pin.control.qp.quadratic_program import QPSolver, QuadraticProgram
from rlbench_pin.front_door import front_door

__all__ = [
    "HeldQuantity",
    "JointBounds",
    "OsqpSolver",
    "PostureObjective",
    "QPSolver",
    "QuadraticProgram",
    "TipObjective",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
