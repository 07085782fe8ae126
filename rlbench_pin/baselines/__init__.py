"""Baselines: small policies and learners as references for results."""
