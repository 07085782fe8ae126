"""Baselines: small policies and learners that show the scale."""
