"""The code blocks of the pages: what each of them is, and which command lines are not run here and why."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGES = tuple(
    page.relative_to(ROOT).as_posix()
    for page in sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
    if "results" not in page.parts
)
"""Everything that people wrote or read; `docs/results` is what was measured."""

NOT_PLAYED = {
    "docs/datasets.md": {
        "rlbench-pin record": "hours, or all tasks; the page records four episodes in Python",
        "rlbench-pin dataset merge": "wants a second dataset; tests/cli/test_dataset.py has two",
        "rlbench-pin dataset rerender": "minutes; tests/recording has it",
    },
    "docs/reference/command_line.md": {
        "rlbench-pin arm new": "wants the URDF of an arm; docs/arms.md has one",
        "rlbench-pin challenge run": "minutes; tests/evaluation/challenge has it",
        "rlbench-pin results": "wants two results files; docs/results_files.md makes two",
        "rlbench-pin serve": "it serves until Ctrl-C; tests/evaluation/policies has it",
    },
    "docs/tasks.md": {
        "rlbench-pin check": "minutes; tests/cli/test_new.py checks such a pair",
        "rlbench-pin record mine/touch_it.py": "minutes; the page records the task once more, in Python",
        "rlbench-pin record sort_two_cubes": "wants the package installed; tests/test_plugin_example.py does that",
    },
    "docs/policies.md": {"rlbench-pin serve": "it serves until Ctrl-C; tests/evaluation/policies has it"},
    "docs/protocols.md": {
        "rlbench-pin record --protocol peract18": "hours; tests/cli/test_protocols.py records a small protocol",
        "rlbench-pin evaluate expert --protocol peract18": "minutes; the page plays a small protocol",
        "rlbench-pin results out/peract18.json": "the file of that evaluation",
    },
    "docs/challenge.md": {"rlbench-pin challenge run": "minutes to hours; tests/evaluation/challenge has it"},
    "docs/worked_programs.md": {"python examples/": "played by tests/test_examples.py"},
}
"""Page -> how a command line begins that is read by its parser, but not run here -> why."""

ELSEWHERE = {
    "## From a reach to a pick-and-place": "tests/cli/test_new.py",
    "## Four how-to guides": "tests/test_how_to_guides.py",
}
"""Heading of CONTRIBUTING.md -> the test that runs the blocks below it."""


@dataclass(frozen=True)
class Block:
    """A code block."""

    page: str
    language: str
    text: str
    heading: str
    """The last `##` heading before it."""

    @property
    def reason(self) -> str | None:
        """Why it is not run, as its first line says."""
        found = re.match(r"# not run by tests: (.*)\n", self.text)
        return found.group(1) if found else None

    @property
    def file(self) -> str | None:
        """The file that it is, or is from, as its first line says."""
        found = re.match(r"# ([\w./-]+\.(?:py|toml))\b", self.text)
        return found.group(1) if found else None

    @property
    def body(self) -> str:
        """The text without such a line."""
        return self.text.split("\n", 1)[1] if self.reason or self.file else self.text

    @property
    def is_excerpt(self) -> bool:
        """Whether it is a part of a file of the repository."""
        return self.file is not None and (ROOT / self.file).is_file() and self.heading not in ELSEWHERE

    @property
    def runs_here(self) -> bool:
        """Whether it has to be run."""
        kinds = ("python", "bash", "toml")
        return self.language in kinds and not (self.reason or self.is_excerpt or self.heading in ELSEWHERE)


def blocks(page: str) -> Iterator[Block]:
    """Yield the code blocks of a page, those that show text included."""
    heading = ""
    text = (ROOT / page).read_text(encoding="utf-8")
    for found in re.finditer(r"^```(\w*)\n(.*?)^```$|^(## [^\n]*)$", text, re.DOTALL | re.MULTILINE):
        heading = found.group(3) or heading
        if not found.group(3):
            yield Block(page, found.group(1), found.group(2), heading)


def command_lines(block: Block) -> list[str]:
    """Return the commands of a shell block, a continued one in one line."""
    joined = block.body.replace("\\\n", " ")
    return [line for line in joined.splitlines() if shlex.split(line, comments=True)]


def why_not_played(page: str, line: str) -> str | None:
    """Return why a command line of a page is not run here, or None when it is."""
    words = " ".join(shlex.split(line, comments=True))
    return next((why for begin, why in NOT_PLAYED.get(page, {}).items() if words.startswith(begin)), None)
