"""Every row of `docs/compatibility.md` has a test that it is so; `compatibility_rows.ROWS` names them."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest

from tests.compatibility_rows import ROWS

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "compatibility.md"
NEW = ("compat/test_differences*.py", "environment/test_differences.py")
"""Files whose tests are there for rows of the page only."""


def page_rows() -> list[list[str]]:
    """Return the cells of all rows, without heads and rules."""
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]
    return [row for row, after in zip(cells, [*lines[1:], ""]) if not after.startswith("|---") and set(row[0]) - set("-|")]


@cache
def functions(file: Path) -> frozenset[str]:
    """Return the names of the tests in a file."""
    tree = ast.parse(file.read_text(encoding="utf-8")) if file.is_file() else ast.Module([], [])
    return frozenset(node.name for node in tree.body if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"))


def test_every_row_has_a_place_and_a_name_of_its_own() -> None:
    """Three cells each: topic, where, what."""
    rows = page_rows()
    topics = [row[0] for row in rows]
    assert len(topics) > 100 and sorted({topic for topic in topics if topics.count(topic) > 1}) == []
    assert [row for row in rows if len(row) != 3 or row[1] not in ("both", "native", "known") or not row[2]] == []


def test_every_row_is_tested_and_every_entry_is_a_row() -> None:
    """In the order of the page, so that both can be read side by side."""
    assert list(ROWS) == [row[0] for row in page_rows()]


@pytest.mark.parametrize("topic", ROWS)
def test_the_tests_of_a_row_exist(topic: str) -> None:
    """As functions of their files; a row about one side is shown on that side."""
    tests = [node.split("::") for node in ROWS[topic].split()]
    assert tests and [node for node in tests if node[1] not in functions(ROOT / "tests" / node[0])] == []
    where = {row[0]: row[1] for row in page_rows()}.get(topic)
    in_layer = {file.startswith("compat/") for file, _ in tests}
    assert where == "both" or (where == "known") in in_layer


def test_tests_of_differences_belong_to_rows() -> None:
    """A test that no row names shows something that the page does not say."""
    named = {node for row in ROWS.values() for node in row.split()}
    tests = ROOT / "tests"
    files = [file for pattern in NEW for file in tests.glob(pattern)]
    found = {f"{file.relative_to(tests).as_posix()}::{name}" for file in files for name in functions(file)}
    assert len(files) >= 5 and found - named == set()


def test_unknown_tests_are_found(tmp_path: Path) -> None:
    """The rule itself: a function that is not there, or a file that is not, has no tests."""
    file = tmp_path / "test_some.py"
    file.write_text("def test_one(): pass\ndef helper(): pass\n", encoding="utf-8")
    assert functions(file) == {"test_one"} and functions(tmp_path / "missing.py") == frozenset()
