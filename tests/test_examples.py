"""The examples run as they stand."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SAYS = {"04_safe_policy": "with the filter: touched nothing", "06_train_ppo": "the mean reward has risen"}
"""What an example says when it shows what it promises; the others reach the goal of their task."""
NEEDS = {"06_train_ppo": "stable_baselines3"}
"""What an example needs beyond the package; without it the example is skipped."""
EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("[0-9]*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(example: Path, tmp_path: Path) -> None:
    """Each ends well, says something, and reaches the goal that it shows."""
    if example.stem in NEEDS:
        pytest.importorskip(NEEDS[example.stem])
    result = subprocess.run([sys.executable, example], capture_output=True, text=True, timeout=1800, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert SAYS.get(example.stem, "reward 1.0") in result.stdout
