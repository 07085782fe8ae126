"""The generated pages of the documentation site; `make docs` builds all of it and fails at a warning."""

from __future__ import annotations

import multiprocessing
import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest
from docs_lib.api import api_pages, constant, is_type, names_and_homes, value_of
from docs_lib.error_table import error_page, error_types
from docs_lib.llms import write_markdown
from docs_lib.pages import copied, without_empty
from docs_lib.public import ROOT, assigned, public_names
from docs_lib.tasks import condition_rows, index_row, page, sentences

from rlbench_pin.tasks import library_names

Result = TypeVar("Result")


def in_another_process(function: Callable[[], Result]) -> Result:
    """Call a function that imports modules without their optional libraries, which no other test may find in this process."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function)


def names_and_pages() -> tuple[dict[tuple[str, str], str], dict[str, str]]:
    """Return the home of every public name, and the pages of the reference."""
    return names_and_homes(public_names()), api_pages()


def errors_and_page() -> tuple[list[str], str]:
    """Return the names of all types of errors, and their page."""
    return [kind.__name__ for kind in error_types()], error_page()["errors.md"]


def test_every_public_name_is_documented() -> None:
    """On the page of the shortest package that has it; the pages of others link to it there."""
    public = public_names()
    homes, pages = in_another_process(names_and_pages)
    assert set(homes) == {(module, name) for module, names in public.items() for name in names}
    for (module, name), home in homes.items():
        text = pages[f"api/{home}.rst"]
        is_module = (ROOT / module.replace(".", "/") / name).is_dir() or (
            ROOT / module.replace(".", "/") / f"{name}.py"
        ).is_file()
        assert is_module or re.search(rf"^\.\. \w[\w:]*:: ({re.escape(home)}\.)?{name}$", text, re.MULTILINE), (module, name)
        assert is_module or f":py:obj:`~{home}.{name}`" in pages[f"api/{module}.rst"]


def test_constants_are_found_where_they_are_assigned() -> None:
    """With type, value and the text below them, through the imports of packages; aliases of types are none."""
    assert assigned("rlbench_pin.sim", "RENDERERS").annotation == "tuple[str, ...]"
    lines = list(constant("rlbench_pin.tasks", "NO_ROTATION", value_of("rlbench_pin.tasks", "NO_ROTATION")))
    assert lines[0] == ".. py:data:: NO_ROTATION" and lines[2].startswith("   :value: (0.0, 0.0")
    assert is_type("FloatArray") and not is_type("RENDERERS")


def test_every_error_has_a_cause_and_a_next_step() -> None:
    """One row for each type, in the order of the alphabet."""
    kinds, text = in_another_process(errors_and_page)
    rows = [re.split(r"(?<!\\) \| ", line.strip("| ")) for line in text.splitlines() if line.startswith("| ")][2:]
    names = [re.sub(r".*[.`~](\w+)`$", r"\1", row[0]) for row in rows]
    assert names == sorted(kinds, key=str.lower)
    assert [row for row in rows if len(row) != 4 or not row[1] or not row[3]] == []
    by_name = dict(zip(names, rows))
    assert by_name["NotReset"][3] == "Call `reset()` first." and "*call*" in by_name["NotReset"][2]


def test_links_lead_from_the_copies_of_pages(tmp_path: Path) -> None:
    """Pages link to pages, images and files of the repository to the originals; folders have no page."""
    text = copied(ROOT / "README.md", tmp_path / "readme.md", tmp_path)
    targets = [target for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text) if "://" not in target]
    assert "gallery.md" in targets and "contributing.md" in targets
    originals = [target for target in targets if not target.endswith(".md")]
    assert originals and all((tmp_path / target).resolve().is_file() for target in originals)
    assert "](examples/policies)" in (ROOT / "README.md").read_text(encoding="utf-8") and "examples/policies)" not in text


def test_results_are_not_searched(tmp_path: Path) -> None:
    """Long tables of figures have a title, and are left out of the index."""
    text = copied(ROOT / "docs" / "results" / "record.md", tmp_path / "results" / "record.md", tmp_path)
    assert text.startswith("---\nno-search: true\n---\n# ")


def test_patterns_without_pages_are_dropped() -> None:
    """A table of contents may name pages that are not written yet."""
    assert without_empty("start*\nhow_to/*\nreadme\n", ["readme.md", "start.md"]) == "start*\nreadme\n"


def test_the_gallery_has_every_task(tmp_path: Path) -> None:
    """With a sentence, and images that exist."""
    assert set(sentences()) == set(library_names())
    for name in library_names():
        image, sentence, variations, *_ = index_row(name, tmp_path)
        assert (tmp_path / "task_gallery" / re.findall(r"\]\(([^)]+jpg)\)", image)[0]).resolve().is_file()
        assert sentence[-1] in ".?!" and int(variations) >= 1


@pytest.mark.simulation
def test_a_page_of_a_task_has_its_conditions_and_figures(tmp_path: Path) -> None:
    """The sizes of sensors and the counts that success asks for."""
    rows = condition_rows("stack_blocks")
    assert rows[0][0] == "`DetectedSeveral`" and rows[0][1].endswith("sensor `column` (cylinder 0.005 x 0.22 m), count 2")
    assert rows[-1][0] == "`NothingGrasped`"
    text = page("stack_blocks", rows, tmp_path)
    assert "| Variations | 60 |" in text and "Success at the first try, unseen seeds" in text and "`object_color`" in text


def test_the_list_for_language_models_has_every_page(tmp_path: Path) -> None:
    """Below the captions of the index; the Markdown of each page lies beside its HTML."""
    (tmp_path / "rendered").mkdir()
    (tmp_path / "rendered" / "api.md").write_text("# Names\n", encoding="utf-8")
    index = "# Site\n\n:::{toctree}\n:caption: Start\n\nstart*\n:::\n"
    pages = {
        "index.md": index,
        "start.md": "# First steps\n",
        "task.md": "---\norphan: true\n---\n\n# Task\n",
        "api.rst": "Names\n",
    }
    write_markdown(pages, tmp_path / "rendered", tmp_path / "site")
    text = (tmp_path / "site" / "llms.txt").read_text(encoding="utf-8")
    assert "## Start\n\n- [First steps](start.md)\n" in text
    assert text.endswith("## Further pages\n\n- [Names](api.md)\n- [Task](task.md)\n")
    assert (tmp_path / "site" / "task.md").read_text(encoding="utf-8") == "# Task\n"
