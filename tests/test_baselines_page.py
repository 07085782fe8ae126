"""The tables of docs/baselines.md are those of the results that are kept, and the commands behind them can be given."""

from __future__ import annotations

import pytest
from baselines_lib import tables
from baselines_lib.rows import Row, commands, rows

from rlbench_pin.cli.running import parse


def test_the_tables_are_those_of_the_results() -> None:
    """Both pages."""
    stale = [path.name for path, text in tables.pages().items() if path.read_text(encoding="utf-8") != text]
    assert stale == [], "run `python scripts/write_baseline_tables.py`"


def test_results_are_of_one_format_and_unaltered() -> None:
    """Reading checks both; no result is kept that no row wants."""
    assert {path.stem for path in tables.RESULTS.glob("*.json")} == set(tables.kept())


@pytest.mark.parametrize("row", rows().values(), ids=list(rows()))
def test_the_commands_can_be_given(row: Row) -> None:
    """Every word of every command is one that the program takes."""
    for command in commands(row):
        assert callable(parse([word.format(out="out", jobs=2) for word in command]).run)
