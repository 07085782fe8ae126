"""Build wheel and sdist of a version into dist/, after the checks of a release.

    python scripts/release.py

It stops with the reasons if the working tree is dirty, the version differs between files, CHANGELOG.md has no section for
the version, or a generated page or table is older than the code. The last check takes minutes.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
GENERATORS: tuple[tuple[str, ...], ...] = (
    ("update_readme.py",),
    ("write_baseline_tables.py",),
    ("write_deviations.py",),
    ("write_factor_results.py",),
    ("write_factors.py",),
    ("write_instructions.py",),
    ("write_leaderboard.py",),
    ("write_protocol_results.py",),
    ("write_reference.py",),
    ("write_results_tables.py",),
    ("write_protocol_states.py", "peract18"),
)
"""The scripts that have `--check`, with their arguments; the slow one is last."""
NAMED = {
    "rlbench_pin/__init__.py": '__version__ = "{}"',
    "CITATION.cff": "version: {}",
    "docs/why.md": "| | rlbench-pin {} |",
}
"""Where the version stands besides pyproject.toml."""


def version(root: Path) -> str:
    """Return the version in pyproject.toml."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return str(project["version"])


def tree_faults(root: Path) -> list[str]:
    """Return what git says is not committed."""
    command = ["git", "status", "--porcelain"]
    lines = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True).stdout.splitlines()
    return [f"not committed: {line[3:]}" for line in lines]


def version_faults(root: Path) -> list[str]:
    """Return which files name another version than pyproject.toml, and whether the section of CHANGELOG.md is missing."""
    number = version(root)
    found = [
        f"{file} does not contain '{text.format(number)}'"
        for file, text in NAMED.items()
        if text.format(number) not in (root / file).read_text(encoding="utf-8")
    ]
    changes = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    if not re.search(rf"^## {re.escape(number)} - \d{{4}}-\d\d-\d\d$", changes, re.MULTILINE):
        found.append(f"CHANGELOG.md has no section '## {number} - YYYY-MM-DD'")
    return found


def page_faults(scripts: Path, generators: Sequence[Sequence[str]]) -> list[str]:
    """Run generators with `--check` and return those whose pages are out of date."""
    found = []
    for script, *arguments in generators:
        command = [sys.executable, str(scripts / script), *arguments, "--check"]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode:
            said = (result.stdout + result.stderr).strip().splitlines()
            found.append(f"scripts/{script}: {said[-1] if said else 'failed'}")
    return found


def build(root: Path, out: Path) -> list[Path]:
    """Build wheel and sdist, check their metadata and the README in them, and return the files.

    Raises:
        subprocess.CalledProcessError: A build or a check fails; the tools have printed why.
    """
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-d", str(out)], cwd=root, check=True)
    files = sorted(out.glob(f"rlbench_pin-{version(root)}*"))
    subprocess.run([sys.executable, "-m", "twine", "check", "--strict", *map(str, files)], check=True)
    return files


def main() -> int:
    """Check, then build."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    faults = [*tree_faults(ROOT), *version_faults(ROOT)] or page_faults(ROOT / "scripts", GENERATORS)
    if faults:
        print(f"Version {version(ROOT)} cannot be released:", *faults, sep="\n  ")
        return 1
    print(*build(ROOT, ROOT / "dist"), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
