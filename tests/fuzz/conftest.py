"""What all fuzz tests share: how much of the cases is tried, and the report of what breaks the law."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.fuzz.cases import Tally

SEED = int(os.environ.get("RLBENCH_PIN_FUZZ_SEED", "0"))


@pytest.fixture
def seed() -> int:
    """Seed of the cases; `RLBENCH_PIN_FUZZ_SEED` chooses others."""
    return SEED


@pytest.fixture
def tally() -> Tally:
    """A new count."""
    return Tally()


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Run in a folder of its own: hostile paths may be relative ones."""
    below = tmp_path / "a" / "b" / "c"
    below.mkdir(parents=True)
    monkeypatch.chdir(below)
    return tmp_path
