"""Tests of the task builder in a browser."""
