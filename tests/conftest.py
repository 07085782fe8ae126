"""What all tests share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

os.environ.setdefault("OMP_NUM_THREADS", "1")

SIMULATION = ("assets", "builder", "cli", "compat", "contract", "datasets", "evaluation", "integration", "tasks")
"""Folders whose tests play episodes, run commands, or build many worlds or files; `make check` leaves them out, single tests
elsewhere are marked."""
SLOW = 14_400
"""Time limit of a test that is marked `slow` [s]; `timeout` in pyproject.toml is that of the others."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark all tests of these folders `simulation`, and give slow tests more time."""
    root = Path(__file__).parent
    for item in items:
        if item.path.is_relative_to(root) and item.path.relative_to(root).parts[0] in SIMULATION:
            item.add_marker(pytest.mark.simulation)
        if item.get_closest_marker("slow") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(SLOW))
