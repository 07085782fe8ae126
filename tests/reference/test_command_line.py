"""The page about the command line has every command and flag, and examples that parse."""

from __future__ import annotations

import re

import pytest
from reference_lib import command_line

from rlbench_pin.cli.running import COMMANDS, parse
from tests.cli.support import exit_code
from tests.reference.support import page, part, rows


def examples() -> list[str]:
    """Return the command lines of the page."""
    blocks = re.findall(r"```bash\n(.*?)```", page("command_line"), re.DOTALL)
    lines = (line.split("  #")[0].strip() for block in blocks for line in block.splitlines())
    return [line for line in lines if not line.startswith("#")]


def test_every_command_has_its_section_and_an_example() -> None:
    """Those of `dataset`, too."""
    headings = re.findall(r"^## (.*)$", page("command_line"), re.MULTILINE)
    assert set(headings) - {"Exit codes"} == {name.replace("-", " ", 1) for name in command_line.commands()}
    assert {heading.split()[0] for heading in headings} - {"Exit"} == {name.split()[0] for name in COMMANDS}
    for heading in headings[1:]:
        assert any(line.startswith(f"rlbench-pin {heading}") for line in examples()), heading


@pytest.mark.parametrize("line", examples())
def test_the_parser_takes_the_examples(line: str) -> None:
    """As they stand."""
    assert callable(parse(line.split()[1:]).run)


@pytest.mark.parametrize("name", command_line.commands())
def test_the_page_has_the_flags_of_the_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """No flag more and none less than what the command prints."""
    assert exit_code(*name.replace("-", " ", 1).split(), "--help") == 0
    printed = set(re.findall(r"--[a-z][a-z-]+", capsys.readouterr().out)) - {"--help"}
    text = part("command_line", name)
    flags = {flag for row in rows(text) for flag in re.findall(r"--[a-z][a-z-]+", row[0])}
    assert flags <= printed
    assert printed <= set(re.findall(r"--[a-z][a-z-]+", text))


@pytest.mark.parametrize(
    ("words", "code"), [(("list",), 0), (("dataset", "info", "nowhere"), 1), (("view", "no_such_task"), 2), (("fly",), 2)]
)
def test_exit_codes_are_those_of_the_page(words: tuple[str, ...], code: int, capsys: pytest.CaptureFixture[str]) -> None:
    """Done, failed, misused; `tests/cli` has those of interrupts and closed pipes."""
    assert exit_code(*words) == code
    assert str(code) in [row[0] for row in rows(part("command_line", "codes"))]
    assert capsys.readouterr().out if code == 0 else not capsys.readouterr().out
