"""A dataset for the commands that work on stored demonstrations."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin.datasets import DatasetWriter
from tests.demos_for_tests import make_demo


@pytest.fixture
def made_up(tmp_path: Path) -> Path:
    """A dataset of three made-up episodes."""
    for seed in range(3):
        DatasetWriter(tmp_path / "data").add(make_demo(frames=seed + 2, seed=seed))
    return tmp_path / "data"
