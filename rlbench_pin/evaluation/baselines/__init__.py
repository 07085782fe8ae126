"""Policies that show the scale of the benchmark, each small."""
