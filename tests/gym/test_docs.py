"""The code of the page about gymnasium."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "gymnasium.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.slow
def test_every_snippet_runs() -> None:
    """What the page shows runs as it stands, silently on stderr."""
    assert len(SNIPPETS) >= 3
    for code in SNIPPETS:
        result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
        assert result.returncode == 0 and result.stdout, result.stderr
        assert result.stderr == ""
