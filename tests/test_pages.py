"""The pages of `docs/` are true: links lead to files, and what they name exists. `test_code_blocks.py` runs their code."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from rlbench_pin.environment import low_dim_config, make_environment
from rlbench_pin.tasks import library_names

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted(page for folder in (".", "reference", "tutorials", "how_to") for page in (ROOT / "docs" / folder).glob("*.md"))
SUFFIXES = ("py", "md", "json", "toml", "jpg", "txt")


def _code(page: Path) -> list[str]:
    """Return what the prose of a page says in backticks."""
    prose = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return re.findall(r"`([^`\n]+)`", prose)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_to_files(page: Path) -> None:
    """Every relative link and every image exists, and where a link names a heading, so does that."""
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
    theirs = ("mine/", "my_tasks/", "out/")  # folders of the reader
    assert [
        p for p in paths if p not in written and not p.startswith(theirs) and not any((root / p).exists() for root in roots)
    ] == []


def test_the_page_says_how_many_tasks_are_the_same_with_two_interpreters() -> None:
    """The sentence has the figures of docs/results/interpreters.json."""
    results = json.loads((ROOT / "docs" / "results" / "interpreters.json").read_text(encoding="utf-8"))
    tasks, filmed = ({key.split()[0] for key in results[section]} for section in ("tasks", "cameras"))
    changed = {difference.split("/")[1].split()[0] for run in results["runs"] for difference in run["differences"]}
    pythons = " and ".join(run["python"] for run in results["runs"])
    text = (ROOT / "docs" / "compatibility.md").read_text(encoding="utf-8")
    assert f"Python {pythons} gave byte-identical" in text
    assert f"in {len(tasks - changed)} of {len(tasks)} tasks" in text and f"in {len(filmed)} of them" in text


GALLERY = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")


def test_the_gallery_shows_every_task() -> None:
    """An image that exists and leads to the sheet, the name, and an instruction, of each task of the library and no other."""
    shown = re.findall(r"\[!\[(\w+)\]\(images/gallery/(\w+)\.jpg\)\]\(images/sheets/(\w+)\.jpg\)<br>`(\w+)`<br>([^|<]+)", GALLERY)
    assert [entry[0] for entry in shown] == list(library_names())
    assert all(len(set(entry[:4])) == 1 and entry[4].strip().endswith((".", "?", "!")) for entry in shown)
    pictures = sorted((ROOT / "docs" / "images" / "gallery").iterdir())
    assert [path.stem for path in pictures] == sorted(library_names())
    assert sum(path.stat().st_size for path in pictures) < 3e6
    assert "docs/gallery.md" in (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.simulation
def test_the_gallery_quotes_instructions() -> None:
    """Each is the first of its task for seed and variation 0: otherwise `python scripts/gallery.py` writes it anew."""
    with make_environment(low_dim_config()) as environment:
        for name in library_names():
            descriptions, _ = environment.get_task(name).reset(seed=0, variation=0)
            assert f"<br>`{name}`<br>{descriptions[0]} |" in GALLERY, name
