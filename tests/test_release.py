"""A release: one version everywhere, clean tree, generated pages up to date; wheel and sdist are complete."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from release import GENERATORS, NAMED, page_faults, tree_faults, version, version_faults

ROOT = Path(__file__).resolve().parents[1]
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Return a folder with the files in which the version stands."""
    for file in ("pyproject.toml", "CHANGELOG.md", *NAMED):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / file, tmp_path / file)
    return tmp_path


def test_the_version_is_the_same_everywhere() -> None:
    """In pyproject.toml, the package, CITATION.cff, docs/why.md and CHANGELOG.md."""
    assert version_faults(ROOT) == []


def test_a_version_that_was_raised_in_one_file_only_is_refused(checkout: Path) -> None:
    """Each file that still has the old version is named, and the section that CHANGELOG.md lacks."""
    project = checkout / "pyproject.toml"
    project.write_text(project.read_text().replace(f'version = "{version(ROOT)}"', 'version = "9.8.7"'))
    found = version_faults(checkout)
    assert [fault.split()[0] for fault in found] == [*NAMED, "CHANGELOG.md"]
    assert found[-1] == "CHANGELOG.md has no section '## 9.8.7 - YYYY-MM-DD'"


def test_a_dirty_tree_is_refused(tmp_path: Path) -> None:
    """Changed and new files are named; a tree that is committed has no fault."""

    def git(*arguments: str) -> None:
        identity = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *identity, *arguments], cwd=tmp_path, check=True, capture_output=True)

    git("init")
    (tmp_path / "old.txt").write_text("1")
    git("add", ".")
    git("commit", "-m", "first")
    assert tree_faults(tmp_path) == []
    (tmp_path / "old.txt").write_text("2")
    (tmp_path / "new.txt").write_text("1")
    assert tree_faults(tmp_path) == ["not committed: old.txt", "not committed: new.txt"]


def test_an_old_page_is_refused(tmp_path: Path) -> None:
    """The generator is asked with `--check` and its arguments; the last line that it prints is the reason."""
    (tmp_path / "good.py").write_text("")
    (tmp_path / "old.py").write_text("import sys; print('begun'); print('out of date:', *sys.argv[1:]); sys.exit(1)")
    assert page_faults(tmp_path, [("good.py",), ("old.py", "peract18")]) == ["scripts/old.py: out of date: peract18 --check"]


def test_every_generator_with_check_is_asked() -> None:
    """A new script with `--check` belongs to the list."""
    scripts = {path.name for path in (ROOT / "scripts").glob("*.py") if "With `--check`" in path.read_text(encoding="utf-8")}
    assert {name for name, *_ in GENERATORS} == scripts


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.stem)
def test_issue_forms_are_complete(form: Path) -> None:
    """Every form has a name and a description; ids are unique, and no field is without a label."""
    content = yaml.safe_load(form.read_text(encoding="utf-8"))
    assert content["name"] and content["description"]
    assert len({field["id"] for field in content["body"]}) == len(content["body"])
    assert all(field["attributes"]["label"] for field in content["body"])
