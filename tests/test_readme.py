"""The README is true: its links lead somewhere, its table is the measured one."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from rlbench_pin import __version__
from rlbench_pin.tasks import library_names

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
RESULTS = ROOT / "docs" / "results" / "demo_success.json"


def test_links_lead_to_files() -> None:
    """Every relative link and every image exists."""
    targets = re.findall(r"\]\(([^)#]+)\)", README)
    assert targets
    assert [t for t in targets if not (ROOT / t).exists()] == []


def test_counts() -> None:
    """All public tasks with all variations, six variants, and the tasks of GemBench; two sentences say so."""
    assert "112 tasks with 586 variations: the 106 public tasks of RLBench with 568, and 6 known variants with 18." in README
    assert "GemBench adds 17 tasks with 53." in README
    assert "| 129 (639 variations) |" in (ROOT / "docs" / "why.md").read_text(encoding="utf-8")


def test_make_targets_exist() -> None:
    """Every `make` target that the README names is one."""
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    named = set(re.findall(r"make ([a-z]+)", README))
    assert {"demo", "test"} <= named
    assert {t for t in named if not re.search(rf"^{t}:", makefile, re.MULTILINE)} == set()


def test_length() -> None:
    """It is short."""
    assert len(README.splitlines()) <= 130


@pytest.mark.simulation
@pytest.mark.skipif(not RESULTS.exists(), reason="not measured yet: `make sweep`")
def test_generated_pages_are_up_to_date() -> None:
    """The summary in the README and the pages of results are what the stored results give."""
    result = subprocess.run([sys.executable, ROOT / "scripts" / "update_readme.py", "--check"], timeout=60)
    assert result.returncode == 0, "run `python scripts/update_readme.py`"


def test_the_changelog_names_every_task() -> None:
    """Whoever looks for a task finds since when there is one."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert {name for name in library_names() if f"`{name}`" not in text} == set()
    assert re.search(rf"^## {re.escape(__version__)} - \d{{4}}-\d\d-\d\d$", text, re.MULTILINE)
