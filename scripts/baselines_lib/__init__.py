"""Evaluations of `make baselines`, and the tables of their results."""
