"""Every code block of the pages runs as it stands, in the order of its page, or says why it does not."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path

import pytest

from rlbench_pin.cli.running import parse
from tests.code_blocks import PAGES, ROOT, Block, blocks, command_lines, why_not_played

ALL = [block for page in PAGES for block in blocks(page)]
RUN = sorted({block.page for block in ALL if block.runs_here})
ONE_BY_ONE = ("docs/datasets.md",)
"""Pages whose Python blocks are programs of their own; those of the others are one program, which begins at the first."""
PRINTS = {
    "README.md": "frames, the last with the tip at",
    "docs/protocols.md": "Push Button",
    "docs/policies.md": "reward 1.0 after",
    "docs/style.md": "No task is called 'reach_targt'. Did you mean 'reach_target'?",
    "docs/tasks.md": "[True]",
}
SILENT = ("docs/gymnasium.md",)
"""Pages whose programs print nothing to stderr."""
FILES = {
    "docs/compatibility.md": {"program.py": "import rlbench\nprint(rlbench.__version__)\n"},
    "docs/policies.md": {"my_policy.py": (ROOT / "examples" / "policies" / "my_policy.py").read_text(encoding="utf-8")},
}
"""Files of the reader that a page takes for granted. A block whose first line names a new file is that file: written, not run."""


def test_blocks_are_of_known_kinds() -> None:
    """Blocks that are no code are called text."""
    assert {block.language for block in ALL} <= {"python", "bash", "toml", "text"}


def test_excerpts_are_parts_of_their_files() -> None:
    """Letter by letter, at any depth."""
    excerpts = [block for block in ALL if block.is_excerpt]
    assert excerpts
    for block in excerpts:
        assert block.file is not None
        whole = (ROOT / block.file).read_text(encoding="utf-8")
        assert any(textwrap.indent(block.body, " " * depth) in whole for depth in (0, 4, 8)), block


@pytest.mark.parametrize("block", [b for b in ALL if b.language == "toml"], ids=lambda b: b.page)
def test_toml_can_be_read(block: Block) -> None:
    """It is TOML."""
    assert tomllib.loads(block.text)


@pytest.mark.parametrize("page", sorted({block.page for block in ALL if block.language == "bash"}))
def test_commands_take_what_pages_give_them(page: str) -> None:
    """Every line that starts `rlbench-pin`, run or not."""
    for block in blocks(page):
        for line in command_lines(block) if block.language == "bash" else ():
            words = shlex.split(line, comments=True)
            if words[0] == "rlbench-pin":
                assert parse(words[1:]), line


@pytest.fixture
def shell(tmp_path: Path) -> dict[str, str]:
    """The environment of a shell that has `rlbench-pin` and `python`."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, words in {"rlbench-pin": "-m rlbench_pin.cli.main", "python": ""}.items():
        (folder / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {words} "$@"\n', encoding="utf-8")
        (folder / name).chmod(0o755)
    paths = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))
    return {**os.environ, "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": paths}


@pytest.mark.simulation
@pytest.mark.parametrize("page", RUN)
def test_the_blocks_of_a_page_run(page: str, tmp_path: Path, shell: dict[str, str]) -> None:
    """In the order of the page, in a folder of their own."""
    work = tmp_path / "work"
    work.mkdir()
    written = {block.file: block.body for block in blocks(page) if block.runs_here and block.file}
    for name, text in {**FILES.get(page, {}), **written}.items():
        (work / name).parent.mkdir(parents=True, exist_ok=True)
        (work / name).write_text(text, encoding="utf-8")
    printed = ""
    for number, (language, text) in enumerate(_steps(page)):
        if language == "toml":
            continue
        program = work / f"step{number}.{'py' if language == 'python' else 'sh'}"
        program.write_text(text, encoding="utf-8")
        command = [sys.executable, str(program)] if language == "python" else ["bash", "-e", str(program)]
        result = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=work, env=shell)
        assert result.returncode == 0, result.stdout + result.stderr
        assert page not in SILENT or (result.stderr == "" and result.stdout), result.stderr
        printed += result.stdout
    assert PRINTS.get(page, "") in printed


def _steps(page: str) -> list[tuple[str, str]]:
    """Return what runs, in order: (language, text)."""
    found = [block for block in blocks(page) if block.runs_here and not block.file]
    programs = [block.body for block in found if block.language == "python"]
    steps, begun = [], False
    for block in found:
        if block.language == "bash":
            steps.append(("bash", "\n".join(line for line in command_lines(block) if why_not_played(page, line) is None)))
        elif block.language != "python" or page in ONE_BY_ONE:
            steps.append((block.language, block.body))
        elif not begun:
            steps.append(("python", "\n".join(programs)))
            begun = True
    return steps
