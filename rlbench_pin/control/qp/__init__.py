"""Quadratic programs: their terms, their bounds and their solvers."""
