"""Tests of tasks that are being edited."""
