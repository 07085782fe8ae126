"""Quadratic programs: their terms, their bounds and their solvers.

`foreign_solver` is not imported here: it needs the `bench` extra.
"""

from __future__ import annotations

from rlbench_pin.control.qp.constraints import HeldQuantity, JointBounds
from rlbench_pin.control.qp.objectives import PostureObjective, TipObjective
from rlbench_pin.control.qp.programs import OsqpSolver, QPSolver, QuadraticProgram

__all__ = [
    "HeldQuantity",
    "JointBounds",
    "OsqpSolver",
    "PostureObjective",
    "QPSolver",
    "QuadraticProgram",
    "TipObjective",
]
