"""The pages of `docs/` are true: their code runs, their links lead to files, and what they name exists."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "reference").glob("*.md")])
PROGRAMS = {"cameras": True, "control": True, "datasets": False, "planning": True, "tasks": True}
PROGRAMS |= {f"reference/{name}": True for name in ("action_modes", "observations", "scene_files", "conditions")}
"""Page -> whether its Python blocks are one program together; `tests/gym/test_docs.py` runs those of the page about gymnasium."""
SUFFIXES = ("py", "md", "json", "toml", "jpg", "txt")


def _code(page: Path) -> list[str]:
    """Return what the prose of a page says in backticks."""
    prose = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return re.findall(r"`([^`\n]+)`", prose)


@pytest.mark.simulation
@pytest.mark.parametrize("name", PROGRAMS)
def test_the_code_of_a_page_runs(name: str, tmp_path: Path) -> None:
    """In the order of the page, in an empty folder."""
    text = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    for number, code in enumerate(["\n".join(blocks)] if PROGRAMS[name] else blocks):
        program = tmp_path / f"program{number}.py"
        program.write_text(code, encoding="utf-8")
        result = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=300, cwd=tmp_path)
        assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_to_files(page: Path) -> None:
    """Every relative link and every picture exists, and where a link names a heading, so does that."""
    targets = [t for t in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")) if "://" not in t]
    assert [t for t in targets if not (page.parent / t.partition("#")[0]).exists()] == []
    headings = [(page.parent / file if file else page, heading) for file, _, heading in (t.partition("#") for t in targets)]
    assert [heading for file, heading in headings if heading and heading not in _anchors(file)] == []


def _anchors(page: Path) -> set[str]:
    """Return how links name the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_files_that_a_page_names_exist(page: Path) -> None:
    """A path with a folder and a known ending is one of the repository, of the package, or of the pages."""
    paths = [c for c in _code(page) if re.fullmatch(rf"[\w./-]+/[\w.-]+\.({'|'.join(SUFFIXES)})", c)]
    written = {"benchmarks/results/latest.json", "docs/results/benchmarks.json"}  # by `make bench`, and kept by hand
    roots = (ROOT, ROOT / "rlbench_pin", ROOT / "docs")
    theirs = ("mine/", "my_tasks/")  # folders of the reader
    assert [
        p for p in paths if p not in written and not p.startswith(theirs) and not any((root / p).exists() for root in roots)
    ] == []
