"""The tested versions: every library that `make` installs is pinned, within what pyproject.toml allows."""

from __future__ import annotations

import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
WANTED = [Requirement(line) for line in (*PROJECT["dependencies"], *EXTRAS["dev"], *EXTRAS["bench"])]
PINS = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").split())
VERSIONS = {canonicalize_name(name): version for name, version in PINS.items()}


@pytest.mark.parametrize("wanted", WANTED, ids=lambda r: r.name)
def test_every_requirement_is_pinned_within_its_range(wanted: Requirement) -> None:
    """`make lock` writes the pins; a changed range asks for new ones."""
    assert wanted.specifier.contains(VERSIONS[canonicalize_name(wanted.name)], prereleases=True)


def test_what_is_installed_by_make_is_what_is_pinned() -> None:
    """The environment of `make` has the pinned versions; one made otherwise is not asked."""
    if Path(sys.prefix) != ROOT / ".venv":
        pytest.skip("this environment was not made by `make`")
    installed = {canonicalize_name(d.metadata["Name"]): d.version for d in metadata.distributions()}
    assert {n: v for n, v in installed.items() if n in VERSIONS and VERSIONS[n] != v} == {}


def test_make_and_continuous_integration_install_with_the_pins() -> None:
    """The one recipe that installs takes the constraints, and `.ci/run` goes through it."""
    assert "-c constraints.txt -e" in (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "make test" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
