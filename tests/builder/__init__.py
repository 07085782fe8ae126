"""Tests of the task builder."""
