"""A small dataset, for the tests that damage it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.demos_for_tests import fill


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Four episodes."""
    return fill(tmp_path / "data", range(4))
